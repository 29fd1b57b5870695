"""Sockets of server and clients: who may reach them, what they carry, what they survive."""

import asyncio
import os
import stat
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from support.server import free_port

from rfms_can.errors import LinkError
from rfms_can.link.address import (
    LAST_PORT,
    OPERATOR,
    SOCKETS,
    TcpAddress,
    endpoints_of,
    rendezvous_of,
    socket_paths,
    tcp_address,
)
from rfms_can.link.aio import AsyncClientSocket
from rfms_can.link.client import ClientSocket
from rfms_can.link.keys import ClientKeys, ServerKeys, new_client_keys, new_server_keys
from rfms_can.link.server import ServerSocket
from rfms_can.messages import MAX_BYTES

LONG_S = 5.0
SHORT_S = 0.2

pytestmark = pytest.mark.usefixtures("runtime")


@pytest.fixture
def server() -> Iterator[ServerSocket]:
    with ServerSocket("bench") as serving:
        yield serving


def echo(server: ServerSocket) -> list[bytes]:
    """Serve one round: every request comes back; what was heard."""
    heard = []
    server.wait(LONG_S)
    for peer, data in server.requests():
        heard.append(data)
        server.reply(peer, data[::-1])
    return heard


# --- addresses --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["", "../up", "a/b", "-x", "a" * 41, "a b", "ipc"[:0]])
def test_a_name_that_is_none_is_refused(name: str) -> None:
    with pytest.raises(LinkError, match="server name"):
        ServerSocket(name)


@pytest.mark.parametrize(
    ("address", "reason"),
    [
        ("tcp://localhost:5000", "a server's name, or tcp://"),
        ("ipc:///tmp/x", "a server's name, or tcp://"),
        ("tcp://127.0.0.1:0", r"port 0 is not in 1\.\.65533"),
        (f"tcp://127.0.0.1:{LAST_PORT + 1}", "three in a row"),
        ("tcp://127.0.0.300:5000", "is not numerical"),
        ("tcp://192.168.1.7:5000", "give the keys"),
        ("tcp://[2001:db8::1]:5000", "give the keys"),
    ],
)
def test_an_address_that_is_none_or_elsewhere_is_refused(address: str, reason: str) -> None:
    with pytest.raises(LinkError, match=reason):
        endpoints_of(address)


def test_three_ports_in_a_row() -> None:
    endpoints = endpoints_of("tcp://127.0.0.1:5000")
    assert endpoints == ("tcp://127.0.0.1:5000", "tcp://127.0.0.1:5001", "tcp://127.0.0.1:5002")
    assert tcp_address("tcp://[::1]:7").endpoints.requests == "tcp://[::1]:7"


def test_a_server_that_does_not_run_is_named(server: ServerSocket) -> None:
    with pytest.raises(LinkError, match=r"no server 'other' is running \(running: bench\)"):
        ClientSocket("other")


def test_a_long_runtime_directory_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path / ("d" * 100)))
    with pytest.raises(LinkError, match="too long for Unix sockets"):
        ServerSocket("bench")


# --- who may reach them -----------------------------------------------------------------------


def test_directory_and_sockets_are_their_owners(server: ServerSocket) -> None:
    directory = rendezvous_of("bench").directory
    assert stat.S_IMODE(directory.stat().st_mode) == 0o700
    for path in socket_paths("bench"):
        assert stat.S_ISSOCK(path.stat().st_mode)
        assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_a_directory_open_to_others_is_refused() -> None:
    rendezvous_of("bench").directory.mkdir(mode=0o755)
    with pytest.raises(LinkError, match="open to others"):
        ServerSocket("bench")


def test_a_client_does_not_trust_a_directory_open_to_others(server: ServerSocket) -> None:
    rendezvous_of("bench").directory.chmod(0o777)
    with pytest.raises(LinkError, match="open to others"):
        ClientSocket("bench")


def test_a_name_is_served_once(server: ServerSocket) -> None:
    with pytest.raises(LinkError, match=f"running already .process {os.getpid()}"):
        ServerSocket("bench")
    with ClientSocket("bench") as client:  # and the first still serves
        client.send(b"abc")
        assert echo(server) == [b"abc"]


@pytest.mark.parametrize("host", ["0.0.0.0", "192.168.1.7", "::"])
def test_what_is_not_loopback_is_not_bound_without_keys(host: str) -> None:
    with pytest.raises(LinkError, match="not loopback: others would move the arm"):
        ServerSocket("bench", TcpAddress(host, 5000))
    assert not rendezvous_of("bench").alive


def test_nothing_listens_on_tcp_unless_asked(server: ServerSocket) -> None:
    inodes = {os.readlink(link) for link in Path("/proc/self/fd").iterdir() if link.is_symlink()}
    listening = [
        line.split()[9]
        for table in ("/proc/net/tcp", "/proc/net/tcp6")
        if Path(table).exists()
        for line in Path(table).read_text().splitlines()[1:]
        if line.split()[3] == "0A"
    ]
    assert not [inode for inode in listening if f"socket:[{inode}]" in inodes]


# --- what they carry --------------------------------------------------------------------------


def test_requests_and_replies(server: ServerSocket) -> None:
    with ClientSocket("bench") as one, ClientSocket("bench") as two:
        one.send(b"ab")
        assert echo(server) == [b"ab"]
        two.send(b"cd")
        assert echo(server) == [b"cd"]
        assert two.receive(LONG_S) == b"dc"
        assert one.receive(LONG_S) == b"ba"
        assert one.receive(0.0) is None


def test_the_newest_status_only(server: ServerSocket) -> None:
    with ClientSocket("bench") as client:
        while client.newest_status(0.01) is None:  # until the subscription has arrived
            server.broadcast(b"first")
        for number in range(200):
            server.broadcast(b"%d" % number)
            server.wait(0.001)  # what a publisher keeps for a reader is gone to it by then
        read = [client.newest_status(LONG_S)]
        while read[-1] != b"last":
            server.broadcast(b"last")
            read.append(client.newest_status(LONG_S))
        assert len(read) < 20, "what was not read in time is replaced, not queued"


def test_a_slow_reader_does_not_keep_the_server(server: ServerSocket) -> None:
    with ClientSocket("bench") as client:
        while client.newest_status(0.01) is None:
            server.broadcast(b"first")
        for _ in range(20_000):
            server.broadcast(bytes(500))
        client.send(b"still there?")
        assert echo(server) == [b"still there?"]


def test_a_peer_that_does_not_read_its_replies_does_not_keep_the_server(
    server: ServerSocket,
) -> None:
    with ClientSocket("bench") as greedy, ClientSocket("bench") as other:
        greedy.send(b"x")
        server.wait(LONG_S)
        (peer, _), *_ = server.requests()
        for _ in range(5_000):
            server.reply(peer, bytes(60_000))
        other.send(b"abc")
        assert echo(server) == [b"abc"]


def test_emergency_stops_have_a_queue_of_their_own(server: ServerSocket) -> None:
    with ClientSocket("bench") as client:
        for _ in range(60):
            client.send(b"busy")
        client.emergency(b"stop")
        heard: list[bytes] = []
        while not heard:
            assert server.wait(LONG_S)
            heard = list(server.emergencies())
        assert heard == [b"stop"]


def test_an_emergency_stop_that_nobody_takes_is_said(server: ServerSocket) -> None:
    with ClientSocket("bench") as client:
        client.send(b"x")
        assert echo(server) == [b"x"]
        server.close()
        with pytest.raises(LinkError, match="did not take the emergency stop"):
            for _ in range(200):  # the first may be gone before the end is seen
                client.emergency(b"stop")
                time.sleep(0.02)


def test_too_long_a_message_is_refused_before_it_is_sent(server: ServerSocket) -> None:
    with ClientSocket("bench") as client:
        for hand_over in (client.send, client.emergency):
            with pytest.raises(LinkError, match=f"{MAX_BYTES + 1} bytes"):
                hand_over(bytes(MAX_BYTES + 1))
        client.send(bytes(MAX_BYTES))
        assert echo(server) == [bytes(MAX_BYTES)]


def test_requests_that_nobody_takes_are_refused_in_the_end(server: ServerSocket) -> None:
    with ClientSocket("bench") as client, pytest.raises(LinkError, match="takes no requests"):
        for _ in range(100_000):
            client.send(bytes(10_000))


def test_asyncio_twin(server: ServerSocket) -> None:
    async def converse() -> None:
        async with AsyncClientSocket("bench") as client:
            waiting = asyncio.create_task(client.receive(LONG_S))
            await asyncio.sleep(0.01)
            client.send(b"abc")
            client.emergency(b"stop")
            while not echo(server):
                pass
            assert await waiting == b"cba"
            status = None
            while status is None:
                server.broadcast(b"status")
                status = await client.newest_status(0.01)
            assert status == b"status"
            assert await client.receive(0.0) is None
            assert await client.receive(0.01) is None

    asyncio.run(converse())
    assert list(server.emergencies()) == [b"stop"]


# --- TCP and keys -----------------------------------------------------------------------------


def test_loopback_when_asked() -> None:
    port = free_port()
    with (
        ServerSocket("bench", TcpAddress("127.0.0.1", port)) as server,
        ClientSocket(f"tcp://127.0.0.1:{port}") as client,
    ):
        client.send(b"abc")
        assert echo(server) == [b"abc"]
        assert client.receive(LONG_S) == b"cba"
        client.emergency(b"stop")
        assert server.wait(LONG_S)
        assert list(server.emergencies()) == [b"stop"]


def test_the_bench_of_keys(tmp_path: Path) -> None:
    """An allowed client is let in, also from elsewhere; one without keys or unknown is not."""
    public = new_server_keys(tmp_path / "keys")
    allowed = ClientKeys.load(new_client_keys(tmp_path / "keys", "cell"), public)
    new_server_keys(tmp_path / "others")
    unknown = ClientKeys.load(new_client_keys(tmp_path / "others", "cell"), public)
    mistaken = allowed._replace(server=unknown.public)
    keys, port = ServerKeys.load(tmp_path / "keys"), free_port()
    address = f"tcp://127.0.0.1:{port}"
    with ServerSocket("bench", TcpAddress("0.0.0.0", port), keys) as server:
        for refused in (None, unknown, mistaken):
            with ClientSocket(address, refused) as client:
                client.send(b"refused")
                assert not server.wait(SHORT_S)
                with pytest.raises(LinkError, match="did not take"):
                    client.emergency(b"refused")
        with ClientSocket(address, allowed) as client:
            client.send(b"abc")
            assert echo(server) == [b"abc"]
            assert client.receive(LONG_S) == b"cba"
        with ClientSocket("bench") as local:  # the Unix sockets are their owner's: no keys
            local.send(b"abc")
            assert echo(server) == [b"abc"]


def test_keys_are_kept_from_others(tmp_path: Path) -> None:
    new_server_keys(tmp_path)
    secret = new_client_keys(tmp_path, "cell")
    assert stat.S_IMODE(secret.stat().st_mode) == 0o600
    server_secret = tmp_path / "server.key_secret"
    assert stat.S_IMODE(server_secret.stat().st_mode) == 0o600
    before = server_secret.read_bytes()
    new_server_keys(tmp_path)
    assert server_secret.read_bytes() == before, "a second call must not lock the clients out"
    server_secret.chmod(0o644)
    with pytest.raises(LinkError, match="can be read by others"):
        ServerKeys.load(tmp_path)


def test_keys_that_are_none_are_refused(tmp_path: Path) -> None:
    with pytest.raises(LinkError, match="is not a key"):
        ServerKeys.load(tmp_path)
    new_server_keys(tmp_path)
    with pytest.raises(LinkError, match="holds no client's key"):
        ServerKeys.load(tmp_path)
    with pytest.raises(LinkError, match="holds no secret key"):
        ClientKeys.load(tmp_path / "server.key", tmp_path / "server.key")
    for name in ("", "../up", "server", "a/b"):
        with pytest.raises(LinkError, match="client name"):
            new_client_keys(tmp_path, name)
    new_client_keys(tmp_path, "cell")
    with pytest.raises(LinkError, match="is there already"):
        new_client_keys(tmp_path, "cell")
    (tmp_path / "clients" / "bad.key").write_text("rubbish")
    with pytest.raises(LinkError, match=r"bad\.key is not a key"):
        ServerKeys.load(tmp_path)


def test_a_name_is_free_again_after_close() -> None:
    for _ in range(3):
        with ServerSocket("bench") as server, ClientSocket("bench") as client:
            client.send(b"abc")
            assert echo(server) == [b"abc"]
    assert all(not path.exists() for path in socket_paths("bench"))
    assert [path.name for path in socket_paths("bench")] == [*SOCKETS, OPERATOR]

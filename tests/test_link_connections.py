"""What peers may take from a server: descriptors and memory, and who is told."""

import resource
import socket
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator
from functools import partial
from typing import Final, cast

import msgspec
import pytest
from support.server import free_port
from support.zmtp import RawPeer

from rfms_can.link import connections
from rfms_can.link.address import OPERATOR, SOCKETS, TcpAddress, socket_paths
from rfms_can.link.client import ClientSocket
from rfms_can.link.descriptors import LEAST_SPARE, connections_each, raise_limit
from rfms_can.link.message_memory import resident_memory, thread_memory, used
from rfms_can.link.server import ServerSocket
from rfms_can.master.server.core import Server
from rfms_can.rig.server_driver import ServerDriver

LONG_S: Final = 10.0
FEW: Final = 5
MIB: Final = 1 << 20

pytestmark = pytest.mark.usefixtures("runtime")


def until(condition: Callable[[], object]) -> None:
    end = time.monotonic() + LONG_S
    while not condition():
        assert time.monotonic() < end, "it did not come about"
        time.sleep(0.01)


@pytest.fixture
def port() -> int:
    return free_port()


@pytest.fixture
def server(port: int, monkeypatch: pytest.MonkeyPatch) -> Iterator[ServerSocket]:
    """A server with few connections on each socket."""
    monkeypatch.setattr(connections, "connections_each", lambda *_: FEW)
    with ServerSocket("bench", TcpAddress("127.0.0.1", port)) as serving:
        yield serving


def connected(port: int, count: int) -> list[socket.socket]:
    """Peers that connect by TCP and say nothing; some are cut before they notice."""
    peers = [socket.socket() for _ in range(count)]
    for peer in peers:
        peer.connect_ex(("127.0.0.1", port))
    return peers


def open_now(peers: list[socket.socket]) -> list[socket.socket]:
    """Those of connected peers that have not been cut."""

    def lives(peer: socket.socket) -> bool:
        peer.setblocking(False)
        try:
            while data := peer.recv(64):
                assert data, "what the server says first"
        except BlockingIOError:
            return True
        except OSError:
            return False
        return False

    return [peer for peer in peers if lives(peer)]


def few_are_left(peers: list[socket.socket]) -> bool:
    return len(open_now(peers)) == FEW


def emergency_is_taken(server: ServerSocket, address: str) -> bool:
    with ClientSocket(address) as client:
        client.emergency(b"stop")
        return server.wait(LONG_S) and list(server.emergencies()) == [b"stop"]


# --- connections ------------------------------------------------------------------------------


def test_idle_connections_to_one_socket_leave_room_for_all_others(
    server: ServerSocket, port: int
) -> None:
    idle = connected(port, 3 * FEW)
    until(partial(few_are_left, idle))
    for address in ("bench", f"tcp://127.0.0.1:{port}"):
        assert emergency_is_taken(server, address)
    with ClientSocket("bench") as local:  # requests by Unix are counted apart from those by TCP
        local.send(b"abc")
        assert server.wait(LONG_S)
        assert [data for _, data in server.requests()] == [b"abc"]
    assert len(server.notices) == 1
    assert f"socket 'requests': over {FEW} connections by tcp" in server.notices[0]
    for peer in idle:
        peer.close()
    with ClientSocket(f"tcp://127.0.0.1:{port}") as late:  # and there is room again
        late.send(b"abc")
        until(lambda: [data for _, data in server.requests()] == [b"abc"])


def test_unix_connections_are_bounded_too(server: ServerSocket) -> None:
    for path in socket_paths("bench"):
        idle = [socket.socket(socket.AF_UNIX) for _ in range(3 * FEW)]
        for peer in idle:
            peer.connect(str(path))
        until(partial(few_are_left, idle))
        for peer in idle:
            peer.close()
    said = " ".join(server.notices)
    assert all(f"{name!r}: over {FEW} connections by ipc" in said for name in (*SOCKETS, OPERATOR))


def test_a_peer_that_does_not_introduce_itself_is_cut(
    port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rfms_can.link.server.HANDSHAKE_MS", 100)
    with ServerSocket("bench", TcpAddress("127.0.0.1", port)):
        (silent,) = connected(port, 1)
        talking = RawPeer(port, "DEALER")
        until(lambda: not open_now([silent]))
        assert open_now([talking.socket])


SCARCE: Final = """
import resource, sys
resource.setrlimit(resource.RLIMIT_NOFILE, (200, 200))
from rfms_can.link.address import TcpAddress
from rfms_can.link.server import ServerSocket
with ServerSocket("bench", TcpAddress("127.0.0.1", int(sys.argv[1]))) as server:
    print("ready", flush=True)
    heard = []
    while not heard:
        server.wait(1.0)
        heard = list(server.emergencies())
    print(heard, *server.notices, flush=True)
"""


def test_where_descriptors_are_few_an_emergency_stop_is_taken_all_the_same(port: int) -> None:
    server = subprocess.Popen(
        [sys.executable, "-c", SCARCE, str(port)], stdout=subprocess.PIPE, text=True
    )
    assert server.stdout is not None
    idle: list[socket.socket] = []
    try:
        assert server.stdout.readline() == "ready\n"
        idle = connected(port, 250)
        with ClientSocket("bench") as client:
            client.emergency(b"stop")
            told = server.stdout.readline()
        assert told.startswith("[b'stop']")
        assert "connections by tcp" in told
        assert server.wait(LONG_S) == 0
    finally:
        for peer in idle:
            peer.close()
        server.kill()
        server.wait()
        server.stdout.close()


def test_the_limit_is_raised_and_a_part_kept_back(monkeypatch: pytest.MonkeyPatch) -> None:
    limits = [1024, 2048]

    def set_limits(_: int, both: tuple[int, int]) -> None:
        limits[:] = both

    monkeypatch.setattr(resource, "getrlimit", lambda _: tuple(limits))
    monkeypatch.setattr(resource, "setrlimit", set_limits)
    assert raise_limit() == 2048
    assert limits == [2048, 2048]
    assert connections_each(8, 10_000) < (2048 - 2048 // 4) // 8
    assert connections_each(8, 3) == 3
    limits[:] = [100, 100]
    assert connections_each(2, 100) <= (100 - LEAST_SPARE) // 2
    limits[:] = [30, 30]
    assert connections_each(8, 100) == 1


# --- memory -----------------------------------------------------------------------------------

needs_arenas = pytest.mark.skipif(thread_memory() is None, reason="needs the GNU C library")


@pytest.mark.parametrize(
    ("place", "kind"), [(0, "DEALER"), (1, "SUB"), (2, "PUSH"), (3, "PUSH"), (-3, "DEALER")]
)
@needs_arenas
def test_a_message_that_does_not_end_is_cut(
    place: int, kind: str, port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On every Unix socket, and by TCP: the process stays small, and others are served."""
    monkeypatch.setattr(connections, "MAX_MESSAGE_MEMORY", 16 * MIB)
    monkeypatch.setattr(connections, "_GROWN", 4 * MIB)
    with ServerSocket("bench", TcpAddress("127.0.0.1", port)) as server:
        peer = RawPeer(port if place < 0 else socket_paths("bench")[place], kind)
        before = resident_memory()()
        assert peer.endless(1024 * MIB) < 900 * MIB
        until(lambda: resident_memory()() < before + 300 * MIB)
        until(lambda: server.notices)
        assert "messages not ended or not taken occupy" in server.notices[0]
        with ClientSocket("bench") as client:
            client.send(b"abc")
            until(lambda: [data for _, data in server.requests()] == [b"abc"])
        assert emergency_is_taken(server, "bench")


@needs_arenas
def test_the_tcp_peer_that_fills_the_memory_is_cut_and_no_other(
    port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connections, "MAX_MESSAGE_MEMORY", 16 * MIB)
    monkeypatch.setattr(connections, "_GROWN", 4 * MIB)
    with ServerSocket("bench", TcpAddress("127.0.0.1", port)) as server:
        honest = [RawPeer(port, "DEALER"), RawPeer(socket_paths("bench")[0], "DEALER")]
        culprit = RawPeer(port, "DEALER")
        culprit.endless(1024 * MIB)
        until(lambda: server.notices)
        assert len(open_now([peer.socket for peer in honest])) == len(honest)


def test_memory_in_use_of_all_arenas_but_the_first() -> None:
    arena = (
        b'<heap nr="%d"><sizes/><total type="fast" count="1" size="%d"/>'
        b'<total type="rest" count="2" size="%d"/>'
        b'<system type="current" size="%d"/><system type="max" size="9999"/></heap>'
    )
    report = b"<malloc>" + b"".join(
        arena % numbers for numbers in ((0, 0, 0, 5000), (1, 10, 20, 1000), (2, 0, 100, 700))
    )
    assert used(report + b'<total type="rest" count="1" size="120"/></malloc>') == 970 + 600
    assert used(b"") == 0


# --- who is told ------------------------------------------------------------------------------


class Told:
    """As much of a server as its driver asks when it broadcasts."""

    def __init__(self) -> None:
        self.events: deque[str] = deque()

    def status(self) -> msgspec.Struct:
        return msgspec.Struct()


def test_what_was_cut_is_told_among_the_events_of_the_server(server: ServerSocket) -> None:
    told = Told()
    server.notices.append("a line")
    ServerDriver(cast("Server", told), server).broadcast()
    assert list(told.events) == ["a line"]
    assert not server.notices

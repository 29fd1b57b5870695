"""The hub over real Unix sockets: arbitration, filters, slow clients, names, python-can."""

import os
import socket
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import can
import pytest

from rfms_can.bus.hub.address import SOCKET_FILE, hub_directory, live_hubs
from rfms_can.bus.hub.client import MAX_BACKLOG
from rfms_can.bus.hub.plugin import HubBus
from rfms_can.bus.hub.port import HubPort
from rfms_can.bus.hub.server import OTHER_IDENTIFIERS, UNINTRODUCED, Hub
from rfms_can.bus.timing import BusTiming
from rfms_can.errors import BusError
from rfms_can.link.rendezvous import LOCK_FILE
from rfms_can.wire.frame import Frame

Connect = Callable[..., HubPort]
WAIT_S = 0.05

pytestmark = pytest.mark.usefixtures("runtime")


@pytest.fixture
def hub() -> Iterator[Hub]:
    hub = Hub("bench")
    thread = threading.Thread(target=hub.run)
    thread.start()
    yield hub
    hub.stop()
    thread.join(5)
    assert not thread.is_alive()
    hub.close()


@pytest.fixture
def connect(hub: Hub) -> Iterator[Connect]:
    ports: list[HubPort] = []

    def connect_one(
        accepts: frozenset[int] | None = None, echo: bool = False, batch: bool = True
    ) -> HubPort:
        name = f"client {len(ports)}"
        ports.append(HubPort("bench", accepts, client=name, echo=echo, batch=batch))
        return ports[-1]

    yield connect_one
    for port in ports:
        port.close()


def next_frame(port: HubPort) -> Frame:
    for _ in range(100):
        frame = port.recv(WAIT_S)
        if frame is not None:
            return frame
    raise AssertionError("no frame came within 5 s")


def test_a_frame_reaches_everybody_who_accepts_it_but_its_sender(connect: Connect) -> None:
    sender, wants, wants_not = connect(), connect(frozenset({0x10})), connect(frozenset({0x11}))
    long, classic, end = Frame(0x10, bytes(64)), Frame(0x10, b"abc", False), Frame(0x11, b"")
    sender.send([long, classic, end])
    assert [next_frame(wants), next_frame(wants)] == [long, classic]
    assert next_frame(wants_not) == end
    assert wants.recv(0.0) is None
    assert sender.recv(0.0) is None


def test_echo_is_given_to_those_who_ask_for_it(connect: Connect) -> None:
    port = connect(echo=True)
    port.send([Frame(1, b"x")])
    assert next_frame(port) == Frame(1, b"x")


def test_the_frames_of_a_round_compete_by_identifier_and_keep_their_senders_order() -> None:
    hub = Hub("round")
    runner = threading.Thread(target=hub.run)
    ports: list[HubPort] = []

    def connect_before_the_round() -> None:
        ports.extend(HubPort("round", client=str(i)) for i in range(3))

    runner.start()
    connect_before_the_round()
    hub.stop()
    runner.join(5)
    assert hub._waker.recv(1)
    # the hub stands still: all of this is pending when its next round begins
    ports[0].send([Frame(0x300, b"a"), Frame(0x300, b"b")])
    ports[1].send([Frame(0x100, b""), Frame(0x200, b"")])
    runner = threading.Thread(target=hub.run)
    runner.start()
    received = [next_frame(ports[2]) for _ in range(4)]
    hub.stop()
    runner.join(5)
    for port in ports:
        port.close()
    hub.close()
    assert [frame.id for frame in received] == [0x100, 0x200, 0x300, 0x300]
    assert [frame.data for frame in received[2:]] == [b"a", b"b"]
    waited = hub.statistics.frames[0x200].max_response_ns
    assert waited == BusTiming().worst_case_ns(0) * 2, "virtual time: behind 0x100"


def test_the_hub_counts_frames_and_worst_case_bus_time(hub: Hub, connect: Connect) -> None:
    sender, receiver = connect(), connect()
    for _ in range(3):
        sender.send([Frame(0x140, bytes(64))])
        next_frame(receiver)
    assert hub.statistics.frames[0x140].count == 3
    assert hub.statistics.busy_ns == 3 * 169_600


def test_a_client_that_does_not_read_loses_frames_and_nobody_waits_for_it(
    hub: Hub, connect: Connect
) -> None:
    sender, slow, quick = connect(), connect(batch=False), connect()
    flood = [Frame(0x40, bytes(64))] * 64
    rounds = 60
    for _ in range(rounds):
        sender.send(flood)
        for _ in flood:
            next_frame(quick)
    slow_client = next(c for c in hub.clients.values() if c.name == "client 1")
    assert len(slow_client.backlog) == MAX_BACKLOG
    assert slow_client.overflow > 0
    read = 0
    while slow.recv(WAIT_S) is not None:
        read += 1
    assert read == rounds * len(flood) - slow_client.overflow


def test_malformed_packets_are_counted_and_the_client_stays(hub: Hub, connect: Connect) -> None:
    port, witness = connect(), connect()
    port._socket.send(b"not a frame")
    port._socket.send(bytes([1, 0, 0, 0, 65, 4]) + bytes(66))  # 65 bytes long
    port.send([Frame(2, b"")])
    assert next_frame(witness).id == 2
    assert next(c for c in hub.clients.values() if c.name == "client 0").malformed == 2


def test_extended_frames_reach_only_those_who_hear_everything(connect: Connect) -> None:
    sender, filtered, all_hearing = connect(), connect(frozenset({1, 2})), connect()
    sender._socket.send(bytes([1, 0, 0, 0x80, 0, 4]) + bytes(66))
    sender.send([Frame(2, b"")])
    assert next_frame(filtered).id == next_frame(all_hearing).id == 2
    assert all_hearing.statistics["foreign"] == 1
    assert filtered.statistics["foreign"] == 0


def test_a_hello_that_is_none_is_refused(hub: Hub) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as raw:
        raw.settimeout(5)
        raw.connect(str(hub_directory("bench") / SOCKET_FILE))
        raw.send(b'{"client": "x", "version": 99}')
        assert b"version 99" in raw.recv(1000)
        assert raw.recv(1000) == b""


def test_a_live_name_is_refused_and_a_stale_socket_replaced(hub: Hub) -> None:
    with pytest.raises(BusError, match=f"running already \\(process {os.getpid()}\\)"):
        Hub("bench")
    assert live_hubs() == ["bench"]
    directory = hub_directory("stale")
    directory.mkdir(mode=0o700)
    (directory / LOCK_FILE).write_text("123")
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as dead:
        dead.bind(str(directory / SOCKET_FILE))
    with pytest.raises(BusError, match=r"running: bench.*rfms hub stale"):
        HubPort("stale")
    Hub("stale").close()
    assert not (directory / SOCKET_FILE).exists()


def test_only_the_owner_reaches_a_hub(hub: Hub, runtime: Path) -> None:
    assert hub_directory("bench").stat().st_mode & 0o777 == 0o700
    hub_directory("open").mkdir(mode=0o755)
    with pytest.raises(BusError, match="open to others"):
        Hub("open")
    (runtime / f"rfms-hub-link-{os.getuid()}").symlink_to(runtime)
    with pytest.raises(BusError, match="not a directory of this user"):
        Hub("link")


def test_a_hub_that_goes_is_a_bus_error_with_the_way_out(runtime: Path) -> None:
    hub = Hub("brief")
    thread = threading.Thread(target=hub.run)
    thread.start()
    port = HubPort("brief", frozenset({1}))
    hub.stop()
    thread.join(5)
    hub.close()
    with pytest.raises(BusError, match="'brief' has gone"):
        next_frame(port)
    with pytest.raises(BusError, match="'brief' has gone"):
        port.send([Frame(1, b"")])
    port.close()


def test_python_can_attaches(connect: Connect) -> None:
    node = connect(frozenset({0x42}))
    with HubBus("bench", can_filters=[{"can_id": 0x43, "can_mask": 0x7FF}]) as bus:
        assert bus.protocol is can.CanProtocol.CAN_FD
        message = can.Message(arbitration_id=0x42, is_extended_id=False, data=bytes(64), is_fd=True)
        bus.send(message)
        assert next_frame(node) == Frame(0x42, bytes(64))
        node.send([Frame(0x44, b""), Frame(0x43, b"first123"), Frame(0x43, b"second", False)])
        first, second = bus.recv(5), bus.recv(5)
        assert first is not None
        assert second is not None
        assert (bytes(first.data), first.is_fd, first.bitrate_switch) == (b"first123", True, True)
        assert (bytes(second.data), second.is_fd) == (b"second", False)
        assert bus.recv(0) is None
        with pytest.raises(can.CanOperationError, match="11-bit data frames only"):
            bus.send(can.Message(arbitration_id=1, is_extended_id=True))


def test_python_can_finds_the_plugin_and_running_hubs(hub: Hub) -> None:
    with can.Bus(interface="rfms", channel="bench", ignore_config=True) as bus:
        assert isinstance(bus, HubBus)
        assert bus.fileno() >= 0
    assert can.detect_available_configs("rfms") == [{"interface": "rfms", "channel": "bench"}]
    with pytest.raises(can.CanInitializationError, match="rfms hub nobody"):
        HubBus("nobody")


# --- many clients -----------------------------------------------------------------------------


FEW = 4


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Hub, list[str]]]:
    """A hub with room for few clients, and what it tells a person."""
    monkeypatch.setattr("rfms_can.bus.hub.server.connections_each", lambda *_: FEW + UNINTRODUCED)
    notices: list[str] = []
    hub = Hub("small", notice=notices.append)
    thread = threading.Thread(target=hub.run)
    thread.start()
    yield hub, notices
    hub.stop()
    thread.join(5)
    hub.close()


def raw(name: str) -> socket.socket:
    connection = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    connection.settimeout(5)
    connection.connect(str(hub_directory(name) / SOCKET_FILE))
    return connection


def test_connections_without_a_hello_give_way_to_nodes(small: tuple[Hub, list[str]]) -> None:
    hub, notices = small
    silent = [raw("small") for _ in range(3 * (FEW + UNINTRODUCED))]
    ports = [HubPort("small", client=str(number)) for number in range(FEW)]
    ports[0].send([Frame(1, b"x")])
    assert next_frame(ports[-1]) == Frame(1, b"x")
    assert len(hub.clients) <= FEW + UNINTRODUCED
    assert silent[0].recv(1) == b"", "the oldest was cut"
    assert len(notices) == 1
    assert "without a hello" in notices[0]
    for one in silent:
        one.close()
    for port in ports:
        port.close()


def test_more_clients_than_may_be_are_refused_with_the_reason(
    small: tuple[Hub, list[str]],
) -> None:
    _, notices = small
    ports = [HubPort("small", client=str(number)) for number in range(FEW)]
    for _ in range(2):
        with pytest.raises(BusError, match=f"refuses 'late': {FEW} clients are connected"):
            HubPort("small", client="late")
    assert len(notices) == 1
    assert "'late' was refused" in notices[0]
    ports.pop().close()
    HubPort("small", client="late").close()
    for port in ports:
        port.close()


def test_identifiers_of_more_than_11_bits_do_not_fill_the_statistics(
    hub: Hub, connect: Connect
) -> None:
    sender, witness = connect(), connect(frozenset({2}))
    for number in range(2_000):
        extended = (0x8000_0000 | number).to_bytes(4, "little")
        sender._socket.send(extended + bytes([0, 4]) + bytes(66))
    sender.send([Frame(2, b"")])
    assert next_frame(witness).id == 2
    assert set(hub.statistics.frames) == {2, OTHER_IDENTIFIERS}
    assert hub.statistics.frames[OTHER_IDENTIFIERS].count == 2_000

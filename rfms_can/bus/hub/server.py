"""The hub: one CAN bus for many processes, where the kernel has none.

A single-threaded loop takes one packet from every client that has one, arbitrates the frames of
this round by identifier as on an idle bus, and sends each client the frames it subscribed to in one
packet. The hub has no clock of its own: frames travel as fast as the processes exchange them; their
worst-case bit times add up to the virtual time on which load figures are based.

Not modelled: the duration of a frame, error frames, error counters and bus-off (see
``simulated.py``), time stamps.
"""

import select
import signal
import socket
import time
from collections.abc import Callable, Iterable
from operator import itemgetter
from typing import Final

import msgspec

from rfms_can.bus.canfd_struct import CANFD_BYTES, CANFD_STRUCT, FD_FORMAT
from rfms_can.bus.hub.address import claim, release
from rfms_can.bus.hub.client import HubClient
from rfms_can.bus.hub.protocol import MAX_HELLO_BYTES, MAX_PACKET_BYTES, VERSION, Hello, Welcome
from rfms_can.bus.statistics import BusStatistics
from rfms_can.bus.timing import BusTiming
from rfms_can.errors import BusError
from rfms_can.link.descriptors import connections_each
from rfms_can.wire.frame import CLASSIC_LENGTHS, FD_LENGTHS, MAX_ID

Competitor = tuple[int, HubClient, bytes, int]
"""A frame of one round: identifier (with flags), sender, 72 bytes, bus time in ns."""

MAX_CLIENTS: Final = 256
"""Clients at a time, where there are descriptors enough."""
UNINTRODUCED: Final = 16
"""Connections beside them that have said no hello yet; then the oldest of these gives way."""
OTHER_IDENTIFIERS: Final = MAX_ID + 1
"""Stands in the statistics for every identifier that is none of 11 bits: those are too many."""
_BACKLOG_OF_CONNECTIONS: Final = 64
_by_identifier = itemgetter(0)


class Hub:
    """A hub that listens from its construction on; ``run`` serves until ``stop``.

    Args:
        name: of the hub.
        timing: bit rates of the emulated bus.
        notice: called with a line for a person, about clients that were refused.

    Attributes:
        name: as given.
        timing: as given.
        bound: clients at a time.
        statistics: of all frames; times are virtual.
        clients: connected clients, welcomed or about to be.

    Raises:
        BusError: the name is taken or invalid.
    """

    def __init__(
        self,
        name: str,
        timing: BusTiming | None = None,
        notice: Callable[[str], None] = lambda _: None,
    ) -> None:
        self.name = name
        self._notice, self._noticed = notice, False
        self.timing = timing or BusTiming()
        self.statistics = BusStatistics(since_ns=time.monotonic_ns())
        self.clients: dict[int, HubClient] = {}
        self._path, self._lock = claim(name)
        self.bound = max(1, connections_each(1, MAX_CLIENTS + UNINTRODUCED) - UNINTRODUCED)
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._waker, self._wake = socket.socketpair()
        try:
            self._listener.bind(str(self._path))
        except OSError as error:
            self.close()
            raise BusError(f"hub {name!r}: cannot bind {self._path}: {error}") from error
        self._listener.listen(_BACKLOG_OF_CONNECTIONS)
        self._listener.setblocking(False)
        self._epoll = select.epoll()
        self._epoll.register(self._listener, select.EPOLLIN)
        self._epoll.register(self._waker, select.EPOLLIN)
        self._routes: dict[int, tuple[HubClient, ...]] = {}
        self._bus_time_ns = _bus_times(self.timing)

    def stop(self) -> None:
        """Let ``run`` return; from any thread or signal handler."""
        self._wake.send(b"x")

    def close(self) -> None:
        """Disconnect all clients and release the name."""
        for client in self.clients.values():
            client.socket.close()
        self.clients.clear()
        for sock in (self._listener, self._waker, self._wake):
            sock.close()
        release(self._path, self._lock)

    def run(self) -> None:
        """Serve until ``stop`` is called."""
        waker, listener = self._waker.fileno(), self._listener.fileno()
        poll, clients = self._epoll.poll, self.clients
        while True:
            round_: list[Competitor] = []
            for descriptor, events in poll():
                client = clients.get(descriptor)
                if client is None:
                    if descriptor == waker:
                        return
                    if descriptor == listener:
                        self._accept()
                    continue
                if events & select.EPOLLOUT:
                    self._drain(client)
                if events & ~select.EPOLLOUT:
                    self._read(client, round_)
            if round_:
                self._arbitrate(round_)

    def _read(self, client: HubClient, round_: list[Competitor]) -> None:
        """Read one packet of a client into this round."""
        try:
            packet = client.socket.recv(MAX_HELLO_BYTES)
        except BlockingIOError:
            return
        except OSError:
            packet = b""
        if not packet:
            self._disconnect(client)
        elif not client.name:
            self._welcome(client, packet)
        elif len(packet) % CANFD_BYTES or len(packet) > MAX_PACKET_BYTES:
            client.malformed += 1
        else:
            for offset in range(0, len(packet), CANFD_BYTES):
                self._admit(client, packet[offset : offset + CANFD_BYTES], round_)

    def _admit(self, client: HubClient, frame: bytes, round_: list[Competitor]) -> None:
        can_id, length, flags, _ = CANFD_STRUCT.unpack(frame)
        bus_time_ns = self._bus_time_ns.get((flags & FD_FORMAT) << 8 | length)
        if bus_time_ns is None:
            client.malformed += 1
            return
        client.sent += 1
        round_.append((can_id, client, frame, bus_time_ns))

    def _arbitrate(self, round_: list[Competitor]) -> None:
        """Sort the frames of a round by identifier and distribute them."""
        if len(round_) > 1:
            round_.sort(key=_by_identifier)
        routes, count_frame = self._routes, self.statistics.count_frame
        receivers: dict[HubClient, None] = {}
        since_start_ns = 0
        for can_id, sender, frame, bus_time_ns in round_:
            since_start_ns += bus_time_ns
            counted = can_id if can_id <= MAX_ID else OTHER_IDENTIFIERS
            count_frame(counted, bus_time_ns, since_start_ns)
            route = routes.get(can_id)
            for client in self._route(can_id) if route is None else route:
                if client is not sender or client.echo:
                    client.outbox.append(frame)
                    receivers[client] = None
        for client in receivers:
            self._flush(client)

    def _route(self, can_id: int) -> tuple[HubClient, ...]:
        """Subscribers of an identifier; cached until a client connects or disconnects."""
        route = tuple(
            client
            for client in self.clients.values()
            if client.name and (client.ids is None or can_id in client.ids)
        )
        if can_id <= MAX_ID:
            self._routes[can_id] = route
        return route

    def _flush(self, client: HubClient) -> None:
        try:
            if client.flush():
                self._epoll.modify(client.socket, select.EPOLLIN | select.EPOLLOUT)
        except OSError:
            client.outbox.clear()  # gone: its end of file is read in a coming round

    def _drain(self, client: HubClient) -> None:
        try:
            if not client.drain():
                self._epoll.modify(client.socket, select.EPOLLIN)
        except OSError:
            client.backlog.clear()
            self._epoll.modify(client.socket, select.EPOLLIN)

    def _accept(self) -> None:
        try:
            connection, _ = self._listener.accept()
        except OSError:
            return  # the client disconnected before it was accepted
        connection.setblocking(False)
        if len(self.clients) >= self.bound + UNINTRODUCED:
            self._disconnect(next(one for one in self.clients.values() if not one.name))
            self._tell("connections without a hello: the oldest was cut")
        self.clients[connection.fileno()] = HubClient(connection)
        self._epoll.register(connection, select.EPOLLIN)

    def _tell(self, what: str) -> None:
        """Tell a person once that the hub is full, until it is no longer."""
        if not self._noticed:
            self._notice(f"{len(self.clients)} {what}; see which program connects so often")
        self._noticed = True

    def _welcome(self, client: HubClient, packet: bytes) -> None:
        """Answer a hello; a client that is refused is disconnected."""
        refused = ""
        try:
            hello = msgspec.json.decode(packet, type=Hello)
        except msgspec.DecodeError as error:
            refused = f"its hello is invalid: {error}"
        else:
            if hello.version != VERSION:
                refused = f"it speaks version {hello.version}, this hub {VERSION}"
            elif sum(bool(other.name) for other in self.clients.values()) >= self.bound:
                refused = f"{self.bound} clients are connected, as many as may be; end some"
                self._tell(f"clients, {self.bound} may be: {hello.client!r} was refused")
        welcome = Welcome(self.timing.nominal_bit_rate, self.timing.data_bit_rate, refused)
        if not refused:
            client.name = hello.client or "unnamed"
            client.ids = None if hello.ids is None else frozenset(hello.ids)
            client.echo, client.batch = hello.echo, hello.batch
            self._routes.clear()
        client.outbox.append(msgspec.json.encode(welcome))
        self._flush(client)
        if refused:
            self._disconnect(client)

    def _disconnect(self, client: HubClient) -> None:
        del self.clients[client.socket.fileno()]
        self._epoll.unregister(client.socket)
        client.socket.close()
        self._routes.clear()
        if len(self.clients) < self.bound:
            self._noticed = False


def _bus_times(timing: BusTiming) -> dict[int, int]:
    """Worst-case bus time, ns, by format flag and length; all other combinations are invalid."""
    times = {length: timing.worst_case_ns(length, fd=False) for length in CLASSIC_LENGTHS}
    if timing.data_bit_rate is not None:
        for length in FD_LENGTHS:
            times[FD_FORMAT << 8 | length] = timing.worst_case_ns(length)
    return times


def serve(
    name: str,
    timing: BusTiming | None = None,
    on_ready: Callable[[Hub], None] | None = None,
    stop_signals: Iterable[signal.Signals] = (signal.SIGINT, signal.SIGTERM),
    notice: Callable[[str], None] = lambda _: None,
) -> BusStatistics:
    """Run a hub in this process until one of the signals; its statistics.

    Raises:
        BusError: the name is taken or invalid.
    """
    hub = Hub(name, timing, notice)
    previous = {number: signal.signal(number, lambda *_: hub.stop()) for number in stop_signals}
    try:
        if on_ready is not None:
            on_ready(hub)
        hub.run()
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
        hub.close()
    return hub.statistics

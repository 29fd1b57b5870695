"""Bounds what peers take from a server: connections, and memory for messages that do not end.

ZeroMQ accepts as many connections as there are descriptors, and aborts the process over a Unix
connection it has none for. So each socket has its number of connections on each transport, out of
a limit that is raised as far as it may be: connections to one never take those of another, the
emergency socket's least of all. What is too many is cut as soon as it has been accepted.

ZeroMQ's monitors tell of every connection. A thread reads them, so that a server that computes
is guarded too; it sleeps while no peer is connected.
"""

import contextlib
import os
import socket
import struct
import time
from collections import Counter, deque
from collections.abc import Iterable, Iterator, Mapping
from threading import Thread
from typing import Final, NamedTuple

import zmq
from zmq.utils.monitor import recv_monitor_message

from rfms_can.link.descriptors import connections_each
from rfms_can.link.message_memory import resident_memory, thread_memory

MAX_CONNECTIONS: Final = 256
"""Connections of one socket on one transport, where there are descriptors enough."""
MAX_MESSAGE_MEMORY: Final = 64 << 20
"""Bytes that messages not yet taken may occupy, of all peers together."""
LOOK_MS: Final = 200
"""Time between two looks at the memory, while peers are connected, ms."""
NOTICE_EVERY_S: Final = 10.0
"""Time between two notices of one kind, s."""

_TRANSPORTS: Final = ("ipc", "tcp")
_EVENTS: Final = zmq.EVENT_ACCEPTED | zmq.EVENT_DISCONNECTED
_GROWN: Final = MAX_MESSAGE_MEMORY // 4
"""Growth of the process after which its messages are measured, bytes."""
_UNANSWERED: Final = 8 << 20
"""Bytes from one TCP peer, with a hundredth of them answered at most, that tell the culprit."""
_BYTES_ACKED_AND_RECEIVED: Final = struct.Struct("=120xQQ")  # struct tcp_info, linux/tcp.h
_RESET_AT_CLOSE: Final = struct.pack("ii", 1, 0)

Kind = tuple[str, str]
"""Name of the socket, transport."""


class Connection(NamedTuple):
    """One accepted connection: name of the socket, and its descriptor."""

    name: str
    descriptor: int


class ConnectionGuard:
    """Counts the connections of sockets and cuts those that are too many or take too much.

    Args:
        sockets: by name, before they are bound.
        addresses: what they will be bound to: paths of Unix sockets and TCP ports.
        notices: takes lines about what was cut.

    Attributes:
        bound: connections of one socket on one transport.
    """

    def __init__(
        self,
        sockets: "Mapping[str, zmq.Socket[bytes]]",
        addresses: Iterable[str | int],
        notices: deque[str],
    ) -> None:
        self._notices = notices
        self._addresses = frozenset(addresses)
        self._sockets = sockets
        self._monitors = {s.get_monitor_socket(_EVENTS): name for name, s in sockets.items()}
        self._woken = os.eventfd(0)
        # A second descriptor holds a connection still while it is looked at: the first may be
        # closed and given to another file meanwhile. It is opened while there are descriptors.
        self._held = os.dup(self._woken)
        self.bound = connections_each(len(sockets) * len(_TRANSPORTS), MAX_CONNECTIONS)
        self._open: dict[Connection, str] = {}  # to the transport
        self._count: Counter[Kind] = Counter()
        self._memory = thread_memory()
        self._resident_now = resident_memory()
        self._resident = self._resident_now()
        self._over = False
        self._cut: Counter[Kind] = Counter()
        self._noticed: dict[Kind, float] = {}
        self._thread = Thread(target=self._run, name="link-guard", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the thread and the monitors; the sockets are still open."""
        os.eventfd_write(self._woken, 1)
        self._thread.join()
        for guarded in self._sockets.values():
            guarded.disable_monitor()
        for monitor in self._monitors:
            monitor.close(linger=0)
        for descriptor in (self._woken, self._held):
            os.close(descriptor)

    def _run(self) -> None:
        poller = zmq.Poller()
        poller.register(self._woken, zmq.POLLIN)
        for monitor in self._monitors:
            poller.register(monitor, zmq.POLLIN)
        look_at = time.monotonic()
        while True:
            ready = [source for source, _ in poller.poll(LOOK_MS if self._open else None)]
            if self._woken in ready:
                return
            for monitor, name in self._monitors.items():
                if monitor in ready:
                    self._listen(monitor, name)
            if time.monotonic() >= look_at:
                self._look_at_memory()
                look_at = time.monotonic() + LOOK_MS * 1e-3

    # --- connections --------------------------------------------------------------------------

    def _listen(self, monitor: "zmq.Socket[bytes]", name: str) -> None:
        """Take what a monitor tells: a connection was accepted, or has ended."""
        while monitor.poll(0):
            event = recv_monitor_message(monitor)
            connection = Connection(name, int(event["value"]))
            if event["event"] == zmq.EVENT_ACCEPTED:
                self._accepted(connection, event["endpoint"].partition(b":")[0].decode())
            else:
                self._ended(connection)

    def _accepted(self, connection: Connection, transport: str) -> None:
        kind = connection.name, transport
        self._ended(connection)  # had its end not been told, it would count twice
        self._open[connection] = transport
        self._count[kind] += 1
        if self._count[kind] > self.bound:
            self._shut(connection)
            self._notice(
                kind,
                f"socket {connection.name!r}: over {self.bound} connections by {transport}, "
                f"{{}} cut since this was told; see which program opens so many",
            )

    def _ended(self, connection: Connection) -> None:
        transport = self._open.pop(connection, None)
        if transport is not None:
            self._count[connection.name, transport] -= 1

    @contextlib.contextmanager
    def _hold(self, connection: Connection) -> Iterator[socket.socket | None]:
        """The connection, held open; None if its descriptor is another file's by now."""
        try:
            os.dup2(connection.descriptor, self._held, inheritable=False)
            held = socket.socket(fileno=self._held)
        except OSError:
            yield None
            return
        try:
            address = held.getsockname()
            own = address if isinstance(address, str) else address[1]
            yield held if own in self._addresses else None
        finally:
            held.detach()
            os.dup2(self._woken, self._held, inheritable=False)

    def _shut(self, connection: Connection) -> None:
        """End a connection; ZeroMQ notices and closes it, and the peer is told at once."""
        with self._hold(connection) as held, contextlib.suppress(OSError):
            if held is not None:
                held.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _RESET_AT_CLOSE)
                held.shutdown(socket.SHUT_RDWR)

    # --- memory -------------------------------------------------------------------------------

    def _look_at_memory(self) -> None:
        """Cut who fills the memory; measured when the process has grown, or was over the bound."""
        now = self._resident_now()
        if self._memory is None or (now < self._resident + _GROWN and not self._over):
            self._resident = min(self._resident, now)
            return
        self._resident = now
        occupied = self._memory()
        self._over = occupied > MAX_MESSAGE_MEMORY
        if not self._over:
            return
        culprits = [one for one in self._open if self._is_unanswered(one)] or list(self._open)
        for connection in culprits:
            self._shut(connection)
        for kind in {(one.name, self._open[one]) for one in culprits}:
            self._notice(
                kind,
                f"socket {kind[0]!r}: messages not ended or not taken occupy {occupied >> 20} MiB, "
                f"bound {MAX_MESSAGE_MEMORY >> 20}; cut connections by {kind[1]}: see which "
                f"program sends so much",
            )

    def _is_unanswered(self, connection: Connection) -> bool:
        """Whether a TCP peer has sent much and was told next to nothing."""
        if self._open[connection] != "tcp":
            return False
        with self._hold(connection) as held, contextlib.suppress(OSError, struct.error):
            if held is not None:
                info = held.getsockopt(
                    socket.IPPROTO_TCP, socket.TCP_INFO, _BYTES_ACKED_AND_RECEIVED.size
                )
                acked, received = _BYTES_ACKED_AND_RECEIVED.unpack(info)
                return bool(received > _UNANSWERED and received > 100 * acked)
        return False

    # --- notices ------------------------------------------------------------------------------

    def _notice(self, kind: Kind, text: str) -> None:
        """Say it, unless it was said a moment ago: ``{}`` stands for how many since."""
        self._cut[kind] += 1
        now = time.monotonic()
        if now - self._noticed.get(kind, -NOTICE_EVERY_S) >= NOTICE_EVERY_S:
            self._notices.append(text.format(self._cut[kind]))
            self._noticed[kind], self._cut[kind] = now, 0

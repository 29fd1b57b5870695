"""Drives the server: carries messages between its sockets and its core, which does no I/O."""

import time
from collections.abc import Callable, Iterable

import msgspec

from rfms_can.link.server import ServerSocket
from rfms_can.master.server.core import Server
from rfms_can.master.server.replies import Outgoing

_encode = msgspec.msgpack.Encoder().encode


class ServerDriver:
    """Passes received messages to the core and its replies to the peers.

    Args:
        server: the core.
        socket: the sockets.
        clock: wall-clock time, ns, monotonic.
    """

    def __init__(
        self, server: Server, socket: ServerSocket, clock: Callable[[], int] = time.monotonic_ns
    ) -> None:
        self._server = server
        self._socket = socket
        self._clock = clock

    def serve(self) -> None:
        """Handle received messages, emergency stops first; fast if there are none."""
        socket, server = self._socket, self._server
        if not socket.pending():
            return
        for data in socket.emergencies():
            self._send(server.emergency(data))
        for data in socket.operators():
            server.operator(data)
        for peer, data in socket.requests():
            self._send(server.receive(peer, data, self._clock()))

    def wait(self, timeout_s: float) -> None:
        """Wait for messages, handle them, and check whether the lease has lapsed."""
        self._socket.wait(timeout_s)
        self.serve()
        self._send(self._server.look(self._clock()))

    def close_cycle(self) -> None:
        """After a closed cycle: answer waiting requests, broadcast the arm's state."""
        self._send(self._server.close_cycle(self._clock()))
        self.broadcast()

    def broadcast(self) -> None:
        """Broadcast the arm's state; pass on what the sockets have to tell a person."""
        notices = self._socket.notices
        while notices:
            self._server.events.append(notices.popleft())
        self._socket.broadcast(_encode(self._server.status()))

    def end(self, reason: str) -> None:
        """Answer waiting requests: the server ends."""
        self._send(self._server.end(reason))

    def _send(self, replies: Iterable[Outgoing]) -> None:
        for peer, data in replies:
            self._socket.reply(peer, data)

"""One client of the hub: its subscription and its queue."""

import socket
from collections import deque
from typing import Final

from rfms_can.bus.hub.protocol import MAX_FRAMES_PER_PACKET

MAX_BACKLOG: Final = 1024
"""Frames the hub queues for a client that does not read, in addition to its socket's buffer."""


class HubClient:
    """A connected client.

    Attributes:
        socket: the connection, non-blocking.
        name: from its hello; empty until then.
        ids: identifiers it receives; None for all.
        echo: whether it receives its own frames.
        batch: whether it accepts several frames in one packet.
        outbox: frames of this round.
        backlog: frames queued because its socket's buffer was full.
        sent: frames it sent.
        overflow: frames dropped because its backlog was full.
        malformed: invalid packets it sent.
    """

    __slots__ = (
        "backlog",
        "batch",
        "echo",
        "ids",
        "malformed",
        "name",
        "outbox",
        "overflow",
        "sent",
        "socket",
    )

    def __init__(self, connection: socket.socket) -> None:
        self.socket = connection
        self.name = ""
        self.ids: frozenset[int] | None = frozenset()
        self.echo = False
        self.batch = True
        self.outbox: list[bytes] = []
        self.backlog: deque[bytes] = deque()
        self.sent = 0
        self.overflow = 0
        self.malformed = 0

    def flush(self) -> bool:
        """Send the outbox without blocking; True if a backlog remains.

        Raises:
            OSError: the client has gone.
        """
        outbox = self.outbox
        if (
            not self.backlog
            and (len(outbox) == 1 or self.batch)
            and (len(outbox) <= MAX_FRAMES_PER_PACKET)
        ):
            try:
                self.socket.send(b"".join(outbox))
            except BlockingIOError:
                pass
            else:
                outbox.clear()
                return False
        room = MAX_BACKLOG - len(self.backlog)
        self.backlog.extend(outbox[:room])
        self.overflow += max(0, len(outbox) - room)
        outbox.clear()
        return self.drain()

    def drain(self) -> bool:
        """Send as much of the backlog as fits in the socket's buffer; True if a backlog remains.

        Raises:
            OSError: the client has gone.
        """
        size = MAX_FRAMES_PER_PACKET if self.batch else 1
        while self.backlog:
            packet = [self.backlog.popleft() for _ in range(min(size, len(self.backlog)))]
            try:
                self.socket.send(b"".join(packet))
            except BlockingIOError:
                self.backlog.extendleft(reversed(packet))
                return True
        return False

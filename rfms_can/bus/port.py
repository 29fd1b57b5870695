"""A port: one process' access to a bus. Protocol and common parts of all ports."""

import select
import socket
import struct
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Final, Protocol

from rfms_can.node.port_counts import PortCounts
from rfms_can.wire.frame import Frame

LONGEST_WAIT_S: Final = 0.05
"""Longest wait for a frame, s, so that a driver reacts to a stop request in time."""

SEND_WAIT_S: Final = 0.1
"""How long a send may wait for buffer space before the frame is counted as lost."""

OnForeign = Callable[[str], None]
"""Called with the kind of a frame that is not for nodes: ``"error"``, ``"not 11-bit data"``."""


class Port(Protocol):
    """Access to a bus.

    Attributes:
        statistics: counts since opening: ``received`` (returned by ``recv``), ``sent``,
            ``foreign`` (frames other than data frames with an 11-bit identifier),
            ``tx_overflow`` (frames dropped because no buffer became free), ``error_frames``,
            ``bus_off``, ``rx_overflow`` as far as the bus reports them.
    """

    statistics: Counter[str]

    def send(self, frames: Sequence[Frame]) -> None:
        """Send frames in their order.

        Raises:
            BusError: the bus has gone.
        """

    def recv(self, timeout_s: float) -> Frame | None:
        """The next frame; None if none came within ``timeout_s`` or ``LONGEST_WAIT_S``.

        Foreign frames are counted and skipped.

        Raises:
            BusError: the bus has gone.
        """

    def fileno(self) -> int:
        """A descriptor that is readable when the operating system has data for ``recv``."""

    def close(self) -> None:
        """Leave the bus; may be called twice."""


def counts_of(statistics: Counter[str]) -> PortCounts:
    """Of a port's statistics, what a heartbeat tells."""
    return PortCounts(statistics["bus_off"], statistics["tx_overflow"] + statistics["rx_overflow"])


def set_time_limits(sock: socket.socket) -> None:
    """Set timeouts on a blocking socket: one system call a frame, no ``poll``."""
    sock.setblocking(True)
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, _timeval(LONGEST_WAIT_S))
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, _timeval(SEND_WAIT_S))


def receive(sock: socket.socket, size: int, timeout_s: float) -> bytes | None:
    """One packet from a socket with time limits; None if none came in time."""
    try:
        if timeout_s >= LONGEST_WAIT_S:
            return sock.recv(size)
        if timeout_s > 0 and not select.select((sock,), (), (), timeout_s)[0]:
            return None
        return sock.recv(size, socket.MSG_DONTWAIT)
    except BlockingIOError:
        return None


def _timeval(seconds: float) -> bytes:
    whole = int(seconds)
    return struct.pack("@ll", whole, round((seconds - whole) * 1e6))

"""The node protocol: a state machine without I/O.

A node opens no socket, reads no clock and draws no random number that was not given to it. A
driver moves frames and re-arms one timer. So one and the same object runs on the simulated bus,
on the hub and on SocketCAN, and a test can pump two of them with plain function calls.
"""

from collections.abc import Sequence
from typing import Final, Protocol

from rfms_can.wire.frame import Frame

NOTHING: Final[tuple[Frame, ...]] = ()
"""What a node hands back when it has nothing to send."""


class Node(Protocol):
    """What a bus knows of a node."""

    @property
    def name(self) -> str:
        """The node's name in logs, tables and errors, e.g. ``"joint 3"``."""

    @property
    def accepts(self) -> frozenset[int]:
        """Identifiers the node wants to hear; the bus delivers these and no others."""

    def on_frame(self, frame: Frame, now_ns: int) -> Sequence[Frame]:
        """Take one frame from the bus; return frames to send. Never raises on what it is sent."""

    def on_time(self, now_ns: int) -> Sequence[Frame]:
        """Do what is due at ``now_ns`` (monotonic, ns); return frames to send."""

    def next_deadline_ns(self) -> int | None:
        """When ``on_time`` wants to be called next (monotonic, ns); None if never."""

"""The node protocol: a state machine without I/O.

A node opens no socket, reads no clock and draws no random numbers of its own. A driver moves frames
and re-arms one timer. So the same object runs on the simulated bus, on the hub and on SocketCAN,
and a test can drive two of them with plain function calls.
"""

from collections.abc import Sequence
from typing import Final, Protocol

from rfms_can.wire.frame import Frame

NOTHING: Final[tuple[Frame, ...]] = ()
"""Return value of a node that has nothing to send."""


class Node(Protocol):
    """Interface of a node to the bus."""

    @property
    def name(self) -> str:
        """The node's name in logs, tables and errors, e.g. ``"joint 3"``."""

    @property
    def accepts(self) -> frozenset[int]:
        """Identifiers the node receives; the bus delivers only these."""

    def on_frame(self, frame: Frame, now_ns: int) -> Sequence[Frame]:
        """Receive one frame; return frames to send. Never raises on received data."""

    def on_time(self, now_ns: int) -> Sequence[Frame]:
        """Handle deadlines up to ``now_ns`` (monotonic, ns); return frames to send."""

    def next_deadline_ns(self) -> int | None:
        """When ``on_time`` is to be called next (monotonic, ns); None if never."""


def hears_itself(node: Node) -> bool:
    """Whether a node is told of its own frames when they have gone out, where it accepts them.

    That is the transmit confirmation of a controller. Joints and gripper set ``echo`` to False:
    what they hear under an identifier of theirs comes from another node.
    """
    return bool(getattr(node, "echo", True))

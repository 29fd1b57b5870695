"""The third node on our lines: it speaks bytes, they speak frames."""

from collections.abc import Sequence

from third_node.node import Node

from rfms_can.node.protocol import NOTHING
from rfms_can.wire.frame import Frame


class ThirdNode:
    """The node protocol around ``third_node.Node``.

    Args:
        joint: its number.
        boot_id: that it drew at power-on.

    Attributes:
        node: the joint.
    """

    def __init__(self, joint: int, boot_id: int = 1) -> None:
        self.node = Node(joint, boot_id)
        self.name = f"third joint {joint}"
        self.accepts = frozenset((0, *self.node.receivers))
        self._booted = False

    def on_frame(self, frame: Frame, now_ns: int) -> Sequence[Frame]:
        """A frame comes; what the node sends."""
        if frame.id not in self.accepts:
            return NOTHING
        return _frames(self.node.receive(frame.id, frame.data, now_ns, frame.fd))

    def on_time(self, now_ns: int) -> Sequence[Frame]:
        """Time passes; what the node sends."""
        if not self._booted:
            self._booted = True
            return _frames(self.node.start())
        return _frames(self.node.tick(now_ns))

    def next_deadline_ns(self) -> int | None:
        """When ``on_time`` is due next."""
        return self.node.deadline_ns if self._booted else 0


def _frames(sent: list[tuple[int, bytes]]) -> list[Frame]:
    return [Frame(can_id, data) for can_id, data in sent]

"""A tap at a node: sees each frame the node hears and sends, changes it, or takes the node away.

It stands in front of any node on any bus; the node itself has no test code.
"""

from collections.abc import Callable, Iterable, Sequence

from rfms_can.node.protocol import NOTHING, Node, hears_itself
from rfms_can.wire.frame import Frame

Tamper = Callable[[Frame], Iterable[Frame]]
"""What is heard, or goes out, instead of a frame."""


def unchanged(frame: Frame) -> Iterable[Frame]:
    """The frame itself."""
    return (frame,)


class Tap:
    """A node behind a tap.

    Args:
        node: the node.

    Attributes:
        node: the same; exchange it for one that starts again.
        into, out: what is made of each frame that it hears, and sends.
        hung: it hears nothing, does nothing and sends nothing.
    """

    def __init__(self, node: Node) -> None:
        self.node = node
        self.into: Tamper = unchanged
        self.out: Tamper = unchanged
        self.hung = False

    @property
    def name(self) -> str:
        """The node's."""
        return self.node.name

    @property
    def accepts(self) -> frozenset[int]:
        """The node's."""
        return self.node.accepts

    @property
    def echo(self) -> bool:
        """The node's; see ``hears_itself``."""
        return hears_itself(self.node)

    def on_frame(self, frame: Frame, now_ns: int) -> Sequence[Frame]:
        """What the node answers to what it hears instead."""
        if self.hung:
            return NOTHING
        answers: list[Frame] = []
        for heard in self.into(frame):
            answers += self.node.on_frame(heard, now_ns)
        return self._sent(answers)

    def on_time(self, now_ns: int) -> Sequence[Frame]:
        """What the node sends at its deadline."""
        return NOTHING if self.hung else self._sent(self.node.on_time(now_ns))

    def next_deadline_ns(self) -> int | None:
        """The node's; a hung one has none."""
        return None if self.hung else self.node.next_deadline_ns()

    def _sent(self, frames: Sequence[Frame]) -> Sequence[Frame]:
        return [sent for frame in frames for sent in self.out(frame)]

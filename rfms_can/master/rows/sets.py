"""Sets of rows on the bus: numbered, sent, heard back, and then named by SYNC.

Rows act one SYNC after they have gone out: so there are two sets at a time, the newest one made and
the one in force.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from rfms_can.arm import Load
from rfms_can.arm.load import NOTHING
from rfms_can.master.rows.compliance import Compliance
from rfms_can.master.rows.math_processor import MathProcessor, RowSet
from rfms_can.wire.contract import LAST_SET, NO_SET
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.protection import Sender
from rfms_can.wire.records import Rows

MakeSender = Callable[[type[NamedTuple], int | None], Sender[Any]]


class RowSets:
    """Sends the sets of rows, and knows which one is in force.

    Args:
        math: makes the rows.
        sends: makes a sender whose counter restarts with the others.
        q: joint angles, rad (6), of a first set that is not sent: SYNC names it before the others.

    Attributes:
        newest: made last, at the last joint angles that were measured of the whole arm.
        in_force: has gone out whole, so that SYNC names it.
    """

    __slots__ = ("_math", "_queued", "_senders", "in_force", "newest")

    def __init__(self, math: MathProcessor, sends: MakeSender, q: Sequence[float]) -> None:
        self._math = math
        self._senders = [sends(Rows, joint) for joint in JOINTS]
        self._queued: list[Frame] = []
        self.newest: RowSet = math.rows(NO_SET, q, Compliance(), NOTHING)
        self.in_force = self.newest

    def send(
        self, q: Sequence[float], compliance: Compliance, load: Load, out: list[Frame]
    ) -> None:
        """Make and send the next set.

        Args:
            q: measured joint angles, rad (6).
            compliance: what it is for.
            load: in the hand.
            out: takes the frames.
        """
        number = self.newest.number % LAST_SET + 1
        rows = self.newest = self._math.rows(number, q, compliance, load)
        self._queued = [
            sender.frame(*values) for sender, values in zip(self._senders, rows.values, strict=True)
        ]
        out.extend(self._queued)

    def gone_out(self, frame: Frame) -> bool:
        """A row was heard back; after the last of its set the set is in force.

        Returns:
            Whether it belongs to the set sent last; a crowded bus may still hold an older one.
        """
        if frame not in self._queued:
            return False
        self._queued.remove(frame)
        if not self._queued:
            self.in_force = self.newest
        return True

    @property
    def reported(self) -> Sequence[str]:
        """Singularities met while the arm complied, in words, each once."""
        return self._math.complying.reported

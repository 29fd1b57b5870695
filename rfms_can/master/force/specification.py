"""What a move asks of force control, and what the arm is doing about it."""

from typing import Final, NamedTuple

from rfms_can.arm import Load
from rfms_can.compliance.selection import Selection
from rfms_can.messages import Vector6
from rfms_can.transform import Transform

RIGID: Final = Selection()
NO_FORCE: Final[Vector6] = (0.0,) * 6
LAST_NUMBER: Final = 255


class Guard(NamedTuple):
    """What stops a move (stpsel and dissel of the thesis' MODE, VI.3.1).

    Attributes:
        force: N and N m along and about the axes of the compliance frame; 0 where none is asked.
        distance: m and rad that its frame has gone from where the move took over; likewise.
    """

    force: Vector6 = NO_FORCE
    distance: Vector6 = NO_FORCE

    @property
    def active(self) -> bool:
        """Whether anything stops the move."""
        return any(self.force) or any(self.distance)


NO_GUARD: Final = Guard()


class Specification(NamedTuple):
    """What a move asks for.

    Attributes:
        selection: directions that comply.
        bias: force and moment the arm exerts on what it touches, N and N m, in the compliance
            frame; zero where it is rigid.
        guard: what stops the move.
        load: what the hand holds from this move on; None: what it held before.
    """

    selection: Selection = RIGID
    bias: Vector6 = NO_FORCE
    guard: Guard = NO_GUARD
    load: Load | None = None


class Compliance(NamedTuple):
    """What complies now, and where: what a set of rows is made for.

    Attributes:
        number: counts the changes; 0 before the first, then 1 to 255 and over again.
        selection: directions that comply.
        frame: the compliance frame in T6.
    """

    number: int = 0
    selection: Selection = RIGID
    frame: Transform = Transform.identity()

    def changed(self, selection: Selection, frame: Transform) -> "Compliance":
        """The next one."""
        return Compliance(self.number % LAST_NUMBER + 1, selection, frame)

    @property
    def bits(self) -> int:
        """The selection as the wire has it."""
        return sum(1 << i for i, selected in enumerate(self.selection) if selected)

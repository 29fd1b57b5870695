"""What a move requests of force control."""

from collections.abc import Callable
from typing import Final, NamedTuple

from rfms_can.arm import Load
from rfms_can.compliance.selection import Selection
from rfms_can.master.rows.compliance import RIGID
from rfms_can.messages import Vector6
from rfms_can.transform import Transform

NO_FORCE: Final[Vector6] = (0.0,) * 6


class Guard(NamedTuple):
    """What stops a move (stpsel and dissel of the thesis' MODE, VI.3.1).

    Attributes:
        force: N and N m along and about the axes of the compliance frame; 0 for none.
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
    """What a move requests.

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


class ForceRequest(NamedTuple):
    """The move in progress, as force control sees it.

    Attributes:
        sequence: its number.
        specification: what it requests.
        frame: its compliance frame in T6, for a pose of T6.
        acceleration_time: t_acc, s.
    """

    sequence: int
    specification: Specification
    frame: Callable[[Transform], Transform]
    acceleration_time: float

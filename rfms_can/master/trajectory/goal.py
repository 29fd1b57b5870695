"""Goals as the world model solves them, and the moments at which they are evaluated."""

from typing import Final, NamedTuple, Protocol

from rfms_can.kinematics import Joints
from rfms_can.transform import Transform


class Moment(NamedTuple):
    """When a goal is evaluated: the motion parameters (h, t) of III.3.2, and the cycle.

    Attributes:
        tick: of the trajectory generator; counts from the first enable. Reference transforms
            are functions of it.
        h: segment parameter (3.15, 3.16): 0 where a segment starts, 1 at its goal.
        t: local time of the segment, s: -t_acc where its transition begins, t_seg at the goal.
            A feed-rate override slows it down with h; at rest at the goal it goes on.
    """

    tick: int
    h: float = 1.0
    t: float = 0.0


class Goal(Protocol):
    """A position equation solved for T6 = L D(r) R (3.20).

    D stands immediately left of the inverse tool, so that the tool's origin runs straight. All
    three are pure functions of the moment: what an observation changes of them is told between
    two ticks.
    """

    @property
    def constant(self) -> bool:
        """Whether all transforms are of type value: the same at every moment, and cached."""

    @property
    def cycle_s(self) -> float:
        """Time in which the goal shows all it does where the arm rests at it, s; 0 where it rests
        as well, or goes on for ever, or is observed."""

    def left(self, moment: Moment) -> Transform:
        """L: what stands left of the drive transform."""

    def right(self, moment: Moment) -> Transform:
        """R: what stands right of it."""

    def pose(self, moment: Moment) -> Transform:
        """L R: T6 at the goal."""


class FixedGoal:
    """A goal that never moves: T6 W(tool) = ``target``, L = ``target``, R = ``tool``^-1.

    Attributes:
        angles: of the joints, rad, if it is given in joint coordinates; T6 is theirs.
    """

    __slots__ = ("_left", "_pose", "_right", "angles")

    constant = True
    cycle_s = 0.0

    def __init__(
        self, target: Transform, tool: Transform | None = None, angles: Joints | None = None
    ) -> None:
        self.angles: Final = angles
        self._left = target
        self._right = Transform.identity() if tool is None else tool.inverse()
        self._pose = target if tool is None else target @ self._right

    def left(self, moment: Moment) -> Transform:
        """The target."""
        return self._left

    def right(self, moment: Moment) -> Transform:
        """The inverse tool."""
        return self._right

    def pose(self, moment: Moment) -> Transform:
        """T6 with the tool at the target."""
        return self._pose


def joint_coordinates(goal: Goal) -> Joints | None:
    """The joint angles, rad, that a goal is given by; None of one that is given by T6."""
    return goal.angles if isinstance(goal, FixedGoal) else None

"""The three tasks that all planners are given: the same places, times and limits.

A leg has the thesis' two times: t_seg from goal to goal, and t_acc of the transition into it, which
lasts from t_acc before the goal left behind to t_acc after it. A planner without transitions takes
t_seg from goal to goal all the same. Lengths grow with the arm, times do not.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

from rfms_can.arm import Arm
from rfms_can.kinematics import Configuration, Joints, configuration_of, direct
from rfms_can.transform import Transform, Vector3
from rfms_can.wire.vocabulary import Mode

UPPER_ARM: Final = 0.2032
"""Length of the upper arm that the places below are given for, m: the PUMA 260's."""

TOOL_LENGTH: Final = 0.1354
"""From T6 to the tip of the tool, m, on such an arm."""

_STILL: Final[Vector3] = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """One motion: where the tool goes, how, and how fast.

    Attributes:
        target: the tool's pose at the goal at time 0, base frame.
        mode: straight in space or in joint angles.
        segment_time: t_seg, s.
        acceleration_time: t_acc, s.
        velocity: of the goal, m/s, base frame.
    """

    target: Transform
    mode: Mode
    segment_time: float
    acceleration_time: float
    velocity: Vector3 = _STILL

    @property
    def moves(self) -> bool:
        """Whether the goal does."""
        return any(self.velocity)

    def goal(self, time: float) -> Transform:
        """The tool's pose at the goal at ``time``, s."""
        x, y, z = (component * time for component in self.velocity)
        return Transform.translation(x, y, z) @ self.target


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """Legs of one arm, from rest to rest in one configuration.

    Attributes:
        start: joint angles it rests at, rad.
        tool: the tool in T6.
        follow_time: how long the last goal is followed once it is reached, s.
    """

    name: str
    arm: Arm
    start: Joints
    tool: Transform
    legs: tuple[Leg, ...]
    follow_time: float = 0.0

    @property
    def configuration(self) -> Configuration:
        """The branch of the inverse solution it is all in."""
        return configuration_of(self.arm, self.start)

    @property
    def moves(self) -> bool:
        """Whether a goal does."""
        return any(leg.moves for leg in self.legs)

    def before(self, leg: int, time: float) -> Transform:
        """The tool's pose that ``leg`` starts from, were the goal before it reached at ``time``."""
        if leg == 0:
            return direct(self.arm, self.start) @ self.tool
        return self.legs[leg - 1].goal(time)


def corner(arm: Arm) -> Task:
    """Along one line and another at a right angle, the tool turning by 15 and by 30 degrees."""
    at = _Places(arm)
    first = at.moved(-0.02, 0.08, 0.0) @ Transform.rotation((0.0, 1.0, 0.0), math.radians(15.0))
    second = at.moved(0.06, 0.1, 0.0) @ Transform.rotation((0.6, 0.0, 0.8), math.radians(30.0))
    legs = (Leg(first, Mode.CARTESIAN, 0.9, 0.2), Leg(second, Mode.CARTESIAN, 0.9, 0.2))
    return at.task("corner", legs)


def pick(arm: Arm) -> Task:
    """Over to a part in joint angles, straight down to it, and away in joint angles."""
    at = _Places(arm)
    above = at.moved(0.02, 0.1, 0.02) @ Transform.rotation((0.0, 0.0, 1.0), math.radians(40.0))
    part = Transform.translation(0.0, 0.0, -0.05 * at.scale) @ above
    away = at.moved(-0.02, -0.04, 0.04)
    legs = (
        Leg(above, Mode.JOINT, 0.9, 0.2),
        Leg(part, Mode.CARTESIAN, 0.6, 0.1),
        Leg(away, Mode.JOINT, 1.0, 0.2),
    )
    return at.task("pick", legs)


def belt(arm: Arm) -> Task:
    """Straight to a place on a belt that runs, turning by 20 degrees, and along with it."""
    at = _Places(arm)
    place = at.moved(0.03, -0.02, -0.05) @ Transform.rotation((0.0, 0.6, 0.8), math.radians(20.0))
    velocity = (0.0, 0.05 * at.scale, 0.0)
    return at.task("belt", (Leg(place, Mode.CARTESIAN, 1.2, 0.2, velocity),), 0.5)


TASKS: Final[Mapping[str, Callable[[Arm], Task]]] = MappingProxyType(
    {"corner": corner, "pick": pick, "belt": belt}
)
"""By name: what makes the task for an arm."""


class _Places:
    """Places about the pose the arm is parked in, in proportion to its size."""

    def __init__(self, arm: Arm) -> None:
        self.scale: Final = arm.a2 / UPPER_ARM
        self._arm: Final = arm
        q1, q2, q3, q4, q5, q6 = arm.park
        self._park: Final[Joints] = (q1, q2, q3, q4, q5, q6)
        self._tool: Final = Transform.translation(0.0, 0.0, TOOL_LENGTH * self.scale)

    def moved(self, x: float, y: float, z: float) -> Transform:
        """The tool's pose at park moved along the base axes, m of the smaller arm."""
        scaled = Transform.translation(x * self.scale, y * self.scale, z * self.scale)
        return scaled @ direct(self._arm, self._park) @ self._tool

    def task(self, name: str, legs: tuple[Leg, ...], follow_time: float = 0.0) -> Task:
        """The task of ``legs`` from park."""
        return Task(name, self._arm, self._park, self._tool, legs, follow_time)

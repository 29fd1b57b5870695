"""A planner beside the trajectory generator and six joints: plans run as they are accepted."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rfms_can.arm import PUMA_260
from rfms_can.kinematics import Configuration, Joints, direct
from rfms_can.master.trajectory.goal import FixedGoal, Goal
from rfms_can.master.trajectory.planning import (
    MovePlanner,
    Plan,
    PlannedMode,
    PlannedPosition,
)
from rfms_can.master.trajectory.segment import Transition
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Blend, Mode
from support.trajectory import LEFT_DOWN, REST, TAU, Rig

Floats = npt.NDArray[np.float64]
TOOL = Transform.translation(0.0, 0.0, 0.1)


class Place(NamedTuple):
    """A position as the planner sees it."""

    name: str
    goal: Goal
    configuration: Configuration


class How(NamedTuple):
    """A mode as the planner sees it."""

    mode: Mode = Mode.JOINT
    acceleration_time: float = 0.2
    segment_time: float | None = None
    speed: float | None = None
    angular_speed: float | None = None
    joint_speed: float | None = None
    lengthen: bool = False
    lengthen_at_most: float = 10.0
    transition: Transition = Transition.JOINT
    deviation: float | None = None
    configuration: Configuration | None = None


def at_angles(q: Sequence[float]) -> Place:
    """The position of the arm with the joint angles ``q``."""
    q1, q2, q3, q4, q5, q6 = q
    return at_pose(direct(PUMA_260, (q1, q2, q3, q4, q5, q6)) @ TOOL)


def at_pose(tool: Transform) -> Place:
    """A position of the tool."""
    return at_goal(FixedGoal(tool, TOOL))


def at_goal(goal: Goal) -> Place:
    return Place("there", goal, LEFT_DOWN)


class PlannedRig(Rig):
    """A rig whose moves are planned first."""

    def __init__(self, q: Joints = REST, period_s: float = TAU) -> None:
        super().__init__(Blend.CONTINUOUS, period_s, q)
        self.planner = MovePlanner(PUMA_260, period_s)
        self.planner.reset(q)
        self.plans: list[Plan] = []

    def plan(self, place: PlannedPosition, how: PlannedMode) -> Plan:
        generator, sequence = self.generator, len(self.plans) + 1
        return self.planner.plan(generator.entry, place, how, sequence)

    def go(self, place: PlannedPosition, how: PlannedMode) -> Plan:
        """Plan a move and request it."""
        plan = self.plan(place, how)
        self.generator.request(*plan.moves)
        self.plans.append(plan)
        return plan

    def peaks(self, first: int = 0) -> tuple[Floats, Floats]:
        """Largest speed and acceleration of each joint from cycle ``first`` on: differences."""
        q = np.array(self.q[first:])
        speeds = np.abs(np.diff(q, axis=0)).max(axis=0) / self.period_s
        return speeds, np.abs(np.diff(q, n=2, axis=0)).max(axis=0) / self.period_s**2

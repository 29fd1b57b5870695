"""This package's own planner: the master's generator and the six joints' set-points.

Zhang (1986), III.3.4, as this package implements it: the same objects the master runs, with its
default, continuous blend (``ThesisPlanner``) or with the matching polynomial of the thesis, (3.17)
to (3.19) and row 3 of Table 3.3 (``as_printed``: what the joints do under ``--blend thesis``). The
corrections of the rest (turns, configurations, hand-overs in time, the rate of the start of a
Cartesian segment) hold for both. A cycle is one ``TrajectoryGenerator.tick`` and one
``CommandedTrajectory.check``, which solves all six joints and looks at their limits; what a part
of it costs in its node is less. Planning before a move is accepted is not in it.
"""

from typing import Final

from planners.planner import NotPossibleError
from planners.task import Leg, Task
from rfms_can.kinematics import Joints, direct
from rfms_can.master.trajectory.commanded import CommandedTrajectory
from rfms_can.master.trajectory.generator import TrajectoryGenerator
from rfms_can.master.trajectory.goal import FixedGoal, Goal, Moment
from rfms_can.master.trajectory.segment import Move, whole_ticks
from rfms_can.master.trajectory.states import Stage
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Blend


class MovingGoal:
    """T6 with the tool at a goal that moves at a constant velocity."""

    constant = False
    cycle_s = 0.0

    def __init__(self, leg: Leg, tool: Transform, period_s: float) -> None:
        self._leg: Final = leg
        self._right: Final = tool.inverse()
        self._period: Final = period_s

    def left(self, moment: Moment) -> Transform:
        """The goal in the base frame. Tick 0 is the first cycle, one period after time 0."""
        return self._leg.goal((moment.tick + 1) * self._period)

    def right(self, moment: Moment) -> Transform:
        """The inverse tool."""
        return self._right

    def pose(self, moment: Moment) -> Transform:
        """T6 with the tool at the goal."""
        return self.left(moment) @ self._right


class ThesisPlanner:
    """The generator and the joints of a task, all moves requested at the start."""

    def __init__(self, task: Task, period_s: float, blend: Blend = Blend.CONTINUOUS) -> None:
        self.leg = 0
        self.blending = False
        self._legs: Final = len(task.legs)
        self._generator: Final = TrajectoryGenerator(period_s, blend)
        self._joints: Final = CommandedTrajectory(task.arm, period_s, exact=True)
        self._joints.reset(task.start)
        self._generator.enable(direct(task.arm, task.start), task.configuration)
        for number, leg in enumerate(task.legs, 1):
            goal: Goal = FixedGoal(leg.target, task.tool)
            if leg.moves:
                goal = MovingGoal(leg, task.tool, period_s)
            segment = whole_ticks(leg.segment_time, period_s)
            acceleration = whole_ticks(leg.acceleration_time, period_s)
            self._generator.request(
                Move(number, goal, leg.mode, segment, acceleration, task.configuration)
            )

    def step(self) -> Joints:
        """One cycle of master and joints."""
        generator = self._generator
        refusal = self._joints.check(generator.tick())
        if refusal is not None:
            raise NotPossibleError(refusal)
        stage = generator.stage
        self.blending = stage is not Stage.LINEAR and stage is not Stage.PRE
        self.leg = self._legs if generator.at_rest else max(0, generator.sequence - 1)
        return self._joints.theta


def as_printed(task: Task, period_s: float) -> ThesisPlanner:
    """The same with the thesis' own blend: position and velocity are matched, no more."""
    return ThesisPlanner(task, period_s, Blend.THESIS)

"""Goals that time moves: left where they will be, and looked at for all they do at rest."""

import math

import numpy as np
import pytest
from support.planning import TOOL, How, PlannedRig, at_goal, at_pose
from support.trajectory import REST, WeavingGoal
from support.trajectory import TOOL as GOING_TOOL

from rfms_can.arm import PUMA_260
from rfms_can.errors import KinematicsError, MoveError
from rfms_can.kinematics import Joints, direct
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.trajectory.segment import Transition
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Mode


def near(*by: float) -> Joints:
    q1, q2, q3, q4, q5, q6 = (angle + more for angle, more in zip(REST, by, strict=True))
    return (q1, q2, q3, q4, q5, q6)


def tool_at(q: Joints, tool: Transform = TOOL) -> Transform:
    return direct(PUMA_260, q) @ tool


class Swinging(WeavingGoal):
    """A goal that swings by ``width`` along y in eight seconds, outwards first from 2.2 s on."""

    cycle_s = 8.0

    def left(self, moment: Moment) -> Transform:
        y = self._width * math.sin(2.0 * math.pi * (moment.t - 2.2) / self.cycle_s)
        return Transform.translation(0.0, y, 0.0) @ self._target


@pytest.mark.parametrize("mode", list(Mode))
def test_what_a_goal_does_while_the_arm_rests_there_is_looked_at(mode: Mode) -> None:
    """Reach ends 8 mm further out; the arm would be there four seconds after the move is made."""
    stretched = math.atan2(-PUMA_260.d4, PUMA_260.a3)
    q = (math.pi / 2.0, 1.2, stretched - 0.3, 0.2, 0.8, 0.1)
    target = direct(PUMA_260, q) @ GOING_TOOL
    how = How(mode, 0.2, 1.5, lengthen=True)
    with pytest.raises(KinematicsError, match=r"move 1: the goal: .*too_far"):
        PlannedRig(q).plan(at_goal(Swinging(target, 0.02)), how)
    rig = PlannedRig(q)
    rig.go(at_goal(Swinging(target, 0.005)), how)
    rig.finish()
    rig.run(round(Swinging.cycle_s / rig.period_s))
    assert np.isfinite(rig.q).all()


@pytest.mark.parametrize("waits", [0, 40, 100, 170, 230])
@pytest.mark.parametrize("transition", list(Transition))
@pytest.mark.parametrize("mode", list(Mode))
def test_a_move_that_leaves_a_goal_that_goes_on_does_what_was_planned(
    mode: Mode, transition: Transition, waits: int
) -> None:
    rig = PlannedRig()
    weaving = WeavingGoal(tool_at(near(0.3, 0.1, 0.2, 0.3, 0.2, 0.1), GOING_TOOL), 0.02, 0.0)
    rig.go(at_goal(weaving), How(Mode.JOINT, 0.2, 1.5))
    rig.finish()
    rig.run(waits)
    first = len(rig.q)
    plan = rig.go(
        at_pose(tool_at(near(-0.2, 0.0, 0.1, 0.1, 0.1, 0.3))),
        How(mode, 0.15, 1.2, transition=transition, lengthen=True),
    )
    rig.run_to_rest()
    speeds, accelerations = rig.peaks(first + 2)
    assert np.all(speeds <= 1.05 * np.array(plan.peak_speeds) + 0.02)
    assert np.all(accelerations <= 1.1 * np.array(plan.peak_accelerations) + 0.3)


@pytest.mark.parametrize("seed", range(8))
def test_a_move_by_way_of_a_goal_that_goes_on_does_what_was_planned(seed: int) -> None:
    """D(1) is fixed a transition before that goal is reached, and starts from where it is then."""
    draw = np.random.default_rng(seed)
    rig = PlannedRig()
    rig.run(12)
    first, second = (near(*draw.uniform(-0.25, 0.25, 6)) for _ in range(2))
    weaving = WeavingGoal(tool_at(first, GOING_TOOL), 0.02, 0.0)
    rig.go(at_goal(weaving), How(Mode.CARTESIAN, 0.2, 1.5, lengthen=True))
    rig.run(20)
    plan = rig.go(at_pose(tool_at(second)), How(Mode.CARTESIAN, 0.2, 1.2, lengthen=True))
    rig.run_to_rest()
    speeds, accelerations = rig.peaks(rig.starts()[1])
    assert np.all(speeds <= 1.05 * np.array(plan.peak_speeds) + 0.02)
    assert np.all(accelerations <= 1.1 * np.array(plan.peak_accelerations) + 0.3)


@pytest.mark.parametrize("seed", [3, 11, 37])
def test_a_segment_is_not_lengthened_far_beyond_what_it_needs(seed: int) -> None:
    draw = np.random.default_rng(seed)
    rig = PlannedRig()
    how = How(Mode.CARTESIAN, 0.1, 0.3, lengthen=True, lengthen_at_most=100.0)
    target = at_pose(tool_at(near(*draw.uniform(-0.8, 0.8, 6))))
    plan = rig.plan(target, how)
    assert plan.segment_time > 0.3
    with pytest.raises(MoveError):
        rig.plan(target, how._replace(lengthen=False, segment_time=plan.segment_time / 1.3))

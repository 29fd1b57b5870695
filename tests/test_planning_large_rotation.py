"""Rotations over 0.8 pi: moved in two parts, without a visible difference."""

import math

import pytest
from pytest import approx
from support.planning import TOOL, How, PlannedRig, at_goal, at_pose
from support.trajectory import LEFT_DOWN, REST, TAU, WeavingGoal

from rfms_can.arm import PUMA_260
from rfms_can.errors import MoveError
from rfms_can.kinematics import direct
from rfms_can.master.trajectory.admission import MAX_ROTATION
from rfms_can.master.trajectory.goal import FixedGoal, Moment
from rfms_can.master.trajectory.planning import PartGoal
from rfms_can.master.trajectory.planning.large_rotation import in_parts
from rfms_can.master.trajectory.segment import Move, Segment, Transition
from rfms_can.master.trajectory.states import Stage
from rfms_can.setpoint.blend import blend_parameter, segment_derivatives
from rfms_can.transform import DriveTransform, Transform
from rfms_can.wire.vocabulary import Mode

START = direct(PUMA_260, REST) @ TOOL
ASIDE = Transform.translation(0.02, 0.03, -0.02)
T_ACC = 0.2


def turned(angle: float) -> Transform:
    """A tool pose a little aside, turned by ``angle`` about an axis joint 6 can follow."""
    return START @ ASIDE @ Transform.rotation((0.0, 0.02, 1.0), angle)


def apart(a: Transform, b: Transform) -> float:
    return max(abs(x - y) for x, y in zip(a, b, strict=True))


@pytest.mark.parametrize("angle", [0.81 * math.pi, 2.9, math.pi - 1e-9, math.pi])
@pytest.mark.parametrize("segment_time", [3.0, 3.005])
def test_the_run_in_parts_is_the_straight_path_of_one_segment(
    angle: float, segment_time: float
) -> None:
    rig = PlannedRig()
    rig.run(2)
    goal = turned(angle)
    plan = rig.go(at_pose(goal), How(Mode.CARTESIAN, T_ACC, segment_time))
    assert plan.segment_time == approx(segment_time)
    assert len(plan.moves) == 2
    rig.finish()
    drive = DriveTransform(goal.inverse() @ START)
    assert drive.psi == approx(angle, abs=1e-7)

    def h(t: float) -> float:
        left = segment_time - t
        if left > T_ACC:
            return segment_derivatives(t, T_ACC, segment_time)[0]
        p = (T_ACC - left) / (2.0 * T_ACC)
        return 1.0 - T_ACC / segment_time * blend_parameter(1.0 - p)

    first = next(k for k, stage in enumerate(rig.stages) if stage is not Stage.IDLE)
    ticks = round((segment_time + 2 * T_ACC) / TAU)
    for k in range(ticks + 1):
        expected = goal @ drive.at(1.0 - h(k * TAU - T_ACC)) @ TOOL.inverse()
        q1, q2, q3, q4, q5, q6 = rig.q[first + k]
        assert apart(direct(PUMA_260, (q1, q2, q3, q4, q5, q6)), expected) < 1e-9
    assert rig.generator.completed == 1


def test_parts_turn_equally_and_their_times_add_up() -> None:
    rig = PlannedRig()
    how = How(Mode.CARTESIAN, T_ACC, 3.005, transition=Transition.JOINT)
    first, second = rig.plan(at_pose(turned(3.0)), how).moves
    assert (first.segment_ticks, second.segment_ticks) == (300, 301)
    assert (first.last, second.last) == (False, True)
    assert (first.transition, second.transition) == (Transition.JOINT, Transition.CARTESIAN)
    assert first.sequence == second.sequence == 1
    via, goal = first.target, second.target
    moment = Moment(0)
    whole = DriveTransform(turned(3.0).inverse() @ START)
    into = DriveTransform.between(via.left(moment), START @ TOOL.inverse(), via.right(moment))
    on = DriveTransform.between(goal.left(moment), via.pose(moment), goal.right(moment))
    assert into.psi == approx(whole.psi * 300 / 601, abs=1e-12)
    assert on.psi == approx(whole.psi * 301 / 601, abs=1e-12)
    assert into.axis == approx(on.axis, abs=1e-12)
    assert max(into.psi, on.psi) < MAX_ROTATION


def test_a_rotation_of_up_to_0_8_pi_is_one_part() -> None:
    rig = PlannedRig()
    plan = rig.plan(at_pose(turned(0.799 * math.pi)), How(Mode.CARTESIAN, T_ACC, 3.0))
    assert len(plan.moves) == 1


def test_in_joint_mode_nothing_is_split() -> None:
    rig = PlannedRig()
    assert len(rig.plan(at_pose(turned(3.0)), How(Mode.JOINT, T_ACC, 3.0)).moves) == 1


def test_the_time_must_hold_the_transitions_of_both_parts() -> None:
    rig = PlannedRig()
    place = at_pose(turned(3.0))
    with pytest.raises(MoveError, match=r"0\.7 s is under .* 0\.82 s: a rotation of 3 rad .* two"):
        rig.plan(place, How(Mode.CARTESIAN, T_ACC, 0.7))
    assert rig.plan(place, How(Mode.CARTESIAN, T_ACC, 0.7, lengthen=True)).segment_time >= 0.82
    slow = rig.plan(place, How(Mode.CARTESIAN, T_ACC, angular_speed=2.0))
    assert slow.segment_time == approx(1.5)


def test_parts_follow_and_are_followed_like_any_move() -> None:
    rig = PlannedRig()
    how = How(Mode.CARTESIAN, T_ACC, 2.5)
    rig.go(at_pose(START @ ASIDE), how)
    rig.go(at_pose(turned(3.0)), how)
    plan = rig.go(at_pose(turned(2.8) @ ASIDE), how)
    assert plan.via_deviation is not None and plan.via_rotation is not None
    rig.finish()
    assert rig.generator.completed == 3
    q1, q2, q3, q4, q5, q6 = rig.q[-1]
    reached = direct(PUMA_260, (q1, q2, q3, q4, q5, q6)) @ TOOL
    assert apart(reached, turned(2.8) @ ASIDE) < 1e-9


def test_motion_parameters_are_those_of_the_whole_path() -> None:
    goal = WeavingGoal(turned(3.0))
    move = Move(1, goal, Mode.CARTESIAN, 601, 40, LEFT_DOWN)
    drive = DriveTransform(turned(3.0).inverse() @ START)
    first, second = in_parts(move, drive, TAU)
    assert isinstance(first.target, PartGoal) and isinstance(second.target, PartGoal)
    assert first.target.whole is goal and not second.target.constant
    goal.moments.clear()
    for part, h, t in ((first, 0.0, -0.2), (first, 1.0, 1.5), (second, 0.0, 0.0), (second, 1.0, 2)):
        part.target.left(Moment(7, h, t))
    share = 300 / 601
    assert goal.moments == [(7, 0.0, -0.2), (7, share, 1.5), (7, share, 1.5), (7, 1.0, 3.5)]


def test_where_the_parts_meet_is_one_pose_of_the_path_at_every_share() -> None:
    whole = FixedGoal(turned(3.0), TOOL)
    drive = DriveTransform(turned(3.0).inverse() @ START)
    for share in (0.3, 0.5, 0.7):
        via = PartGoal(whole, drive, 0.0, share, 0.0)
        expected = turned(3.0) @ drive.at(1.0 - share) @ TOOL.inverse()
        assert via.constant
        assert apart(via.pose(Moment(0)), expected) < 1e-12
        move = Move(1, via, Mode.CARTESIAN, 300, 40, LEFT_DOWN)
        part = Segment.towards(move, START @ TOOL.inverse(), Moment(0, 0.0))
        for r in (0.25, 0.5, 0.75):
            on_path = turned(3.0) @ drive.at(1.0 - share + r * share) @ TOOL.inverse()
            assert apart(part.pose(Moment(0), r), on_path) < 1e-12


def test_a_goal_that_weaves_is_reached_in_parts_without_a_step() -> None:
    rig = PlannedRig()
    rig.run(12)
    rig.go(at_goal(WeavingGoal(turned(3.0), 0.001)), How(Mode.CARTESIAN, T_ACC, 3.0))
    rig.run(740)
    assert rig.generator.completed == 1
    assert rig.difference(2) < 10.0  # one velocity stepped by 0.1 rad/s would make it 20

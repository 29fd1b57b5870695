"""The master's shadow of the six joints: it sees what must not be sent."""

import pytest
from pytest import approx
from support.trajectory import HOME, LEFT_DOWN, TAU, Rig, over_the_wire

from rfms_can.arm import PUMA_260
from rfms_can.kinematics import direct
from rfms_can.master.trajectory.braking import Brake
from rfms_can.master.trajectory.commanded import GUARD, LEAP, CommandedTrajectory
from rfms_can.master.trajectory.goal import FixedGoal
from rfms_can.master.trajectory.segment import Move
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Mode


def shadow() -> CommandedTrajectory:
    commanded = CommandedTrajectory(PUMA_260, TAU)
    commanded.reset(HOME)
    return commanded


def move_to(pose: Transform, mode: Mode = Mode.JOINT, segment_ticks: int = 400) -> Move:
    return Move(1, FixedGoal(pose), mode, segment_ticks, 40, LEFT_DOWN)


def shifted(q: tuple[float, ...], joint: int, by: float) -> Transform:
    """T6 with one joint of ``q`` turned by ``by``, rad."""
    angles = list(q)
    angles[joint - 1] += by
    q1, q2, q3, q4, q5, q6 = angles
    return direct(PUMA_260, (q1, q2, q3, q4, q5, q6))


STAY = Move(0, FixedGoal(direct(PUMA_260, HOME)), Mode.JOINT, 1, 1, LEFT_DOWN)


def test_the_shadow_is_what_six_nodes_compute() -> None:
    """It runs on the float32 numbers of the wire, as they do; test_random_programs has it to the
    last digit, with what the joints are told."""
    commanded, rig = shadow(), Rig(wire=True)
    rig.move(Mode.JOINT, "W1", 1.2, 0.2)
    rig.move(Mode.CARTESIAN, "W2", 2.0, 0.2)
    for _ in range(700):
        q = rig.tick()
        assert commanded.check(rig.setpoints[-1]) is None
        assert commanded.theta == approx(q, abs=1e-6)
        assert commanded.rate == approx([joint.rate for joint in rig.joints], abs=1e-4)
        assert commanded.acceleration == approx(
            [joint.acceleration for joint in rig.joints], abs=0.05
        )


def test_nodes_behind_float32_stay_within_a_hundredth_of_a_milliradian() -> None:
    commanded, rig = shadow(), Rig(wire=True)
    rig.move(Mode.CARTESIAN, "W1", 1.2, 0.2)
    rig.move(Mode.CARTESIAN, "W2", 2.0, 0.2)
    exact = Rig()
    exact.move(Mode.CARTESIAN, "W1", 1.2, 0.2)
    exact.move(Mode.CARTESIAN, "W2", 2.0, 0.2)
    for _ in range(700):
        exact.tick()
        assert commanded.check(exact.setpoints[-1]) is None
        assert commanded.theta == approx(rig.tick(), abs=1e-5)
        assert over_the_wire(exact.setpoints[-1]) == rig.setpoints[-1]


def test_a_pose_out_of_reach_is_refused_and_nothing_moved() -> None:
    commanded, rig = shadow(), Rig()
    rig.run(1)
    good = rig.setpoints[-1]
    assert commanded.check(good) is None
    before = commanded.theta
    far = Transform.translation(2.0, 0.0, 0.0)
    reason = commanded.check(good._replace(T6_1=far))
    assert reason is not None and "too_far" in reason
    reason = commanded.check(good._replace(T6_2=far))
    assert reason is not None and "too_far" in reason
    assert commanded.theta == before
    assert commanded.check(good) is None


def test_a_set_point_too_fast_names_joint_number_and_bound() -> None:
    commanded, rig = shadow(), Rig()
    rig.run(1)
    setpoint = rig.setpoints[-1]
    assert commanded.check(setpoint) is None
    speed = place = 0.0
    while speed < 2.39:  # over the limits, under what may be: the joint lags behind
        speed = min(speed + 10.1 * TAU, 2.39)
        place += speed * TAU
        assert commanded.check(setpoint._replace(T6_1=shifted(HOME, 1, place))) is None
    fast = shifted(HOME, 1, place + 2.42 * TAU)
    reason = commanded.check(setpoint._replace(T6_1=fast))
    assert reason == "puma260: joint 1: set-point speed 2.42 rad/s exceeds 2 rad/s"


def test_a_set_point_that_leaps_names_joint_number_and_bound_and_changes_nothing() -> None:
    commanded, rig = shadow(), Rig()
    rig.run(1)
    setpoint = rig.setpoints[-1]
    assert commanded.check(setpoint) is None
    before = commanded.theta, [joint.mark() for joint in commanded._joints]
    reason = commanded.check(setpoint._replace(T6_1=shifted(HOME, 2, 1.01 * LEAP)))
    assert reason is not None
    assert reason.startswith("puma260: joint 2: set-point acceleration 202 rad/s2 exceeds 10")
    assert (commanded.theta, [joint.mark() for joint in commanded._joints]) == before
    assert commanded.check(setpoint._replace(T6_1=shifted(HOME, 2, 0.99 * LEAP))) is None


def test_a_set_point_that_cannot_follow_is_our_own_bug() -> None:
    commanded, rig = shadow(), Rig()
    rig.move(Mode.JOINT, "W1", 1.2, 0.2)
    rig.run(3)
    with pytest.raises(AssertionError, match="joint 1: a BLEND set-point cannot follow the last"):
        commanded.check(rig.setpoints[-1])


def test_a_set_point_that_could_not_come_to_rest_in_the_range_is_refused_in_time() -> None:
    """Joint 1 ends at 2.53 rad; at 2 rad/s it takes 0.2 rad to stop."""
    q = (2.0, *HOME[1:])
    commanded, rig = CommandedTrajectory(PUMA_260, TAU), Rig(q=q)
    commanded.reset(q)
    rig.run(1)
    setpoint = rig.setpoints[-1]
    reason = commanded.check(setpoint)
    speed = place = 0.0
    while reason is None:
        speed = min(speed + 10.0 * TAU, 2.0)
        place += speed * TAU
        reason = commanded.check(setpoint._replace(T6_1=shifted(q, 1, place)))
    assert "can no longer come to rest inside" in reason
    upper = PUMA_260.joint_limits[0][1]
    brake = Brake(PUMA_260, commanded.theta, commanded.steps, commanded.bend_limits)
    while not brake.over:
        theta = brake.step()
    # a stop of its node's own, at half the limit, would end at the guard: twice as far from there
    rests = upper + GUARD - speed**2 / 20.0
    assert theta[0] == approx(rests, abs=speed * TAU)

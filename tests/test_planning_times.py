"""How long a segment takes that is given speeds, and curves its joints run along."""

import math

import numpy as np
import pytest
from pytest import approx
from support.planning import TOOL, How, PlannedRig, at_angles, at_pose
from support.trajectory import REST, TAU

from rfms_can.arm import PUMA_260
from rfms_can.errors import MoveError
from rfms_can.kinematics import Joints, direct
from rfms_can.master.trajectory.planning.curve import FADED, SHORTEST, Curve, Floats
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Mode

START = direct(PUMA_260, REST) @ TOOL
ACROSS = Transform.translation(-0.06, 0.0, -0.08) @ START
TURNED = START @ Transform.rotation((0.0, 0.0, 1.0), 0.7)
A_LITTLE = START @ Transform.rotation((0.0, 0.0, 1.0), 0.1)
BOTH = ACROSS @ Transform.rotation((0.0, 0.0, 1.0), 0.7)
QUICK = 0.05
LEAST = 2 * QUICK + 2 * TAU


@pytest.mark.parametrize("mode", Mode)
def test_the_longest_of_the_times_that_speeds_ask_for(mode: Mode) -> None:
    rig = PlannedRig()

    def time(
        goal: Transform, speed: float | None = None, angular_speed: float | None = None
    ) -> float:
        how = How(mode, QUICK, speed=speed, angular_speed=angular_speed)
        return rig.plan(at_pose(goal), how).segment_time

    assert time(ACROSS, speed=0.1) == approx(1.0)
    assert time(TURNED, angular_speed=0.7) == approx(1.0)
    assert time(BOTH, speed=0.1, angular_speed=0.35) == approx(2.0)
    assert time(BOTH, speed=0.05, angular_speed=0.35) == approx(2.0)
    assert time(A_LITTLE, speed=0.1) == approx(LEAST)


def test_a_part_of_the_joints_speeds_asks_for_what_the_slowest_of_them_needs() -> None:
    rig = PlannedRig()
    goal = at_angles((REST[0] + 0.8, REST[1] - 0.3, *REST[2:]))
    assert rig.plan(goal, How(joint_speed=0.5)).segment_time == approx(0.8)
    assert rig.plan(goal, How(joint_speed=0.5, speed=0.1)).segment_time > 1.0
    twice = rig.plan(goal, How(Mode.CARTESIAN, joint_speed=0.25)).segment_time
    assert twice == approx(1.6)


def test_times_from_speeds_are_rounded_up_and_given_times_to_the_nearest() -> None:
    rig = PlannedRig()
    goal = at_pose(ACROSS)
    assert rig.plan(goal, How(speed=0.0999)).segment_time == approx(1.005)
    assert rig.plan(goal, How(segment_time=1.002)).segment_time == approx(1.0)


def test_no_way_takes_the_time_of_the_transitions() -> None:
    rig = PlannedRig()
    assert rig.plan(at_pose(START), How(acceleration_time=QUICK, speed=0.1)).segment_time == approx(
        LEAST
    )


def test_a_given_time_under_that_of_the_transitions_is_refused_or_lengthened() -> None:
    rig = PlannedRig()
    with pytest.raises(MoveError, match=r"segment time 0\.3 s is under .* 0\.41 s"):
        rig.plan(at_pose(START), How(segment_time=0.3))
    assert rig.plan(at_pose(START), How(segment_time=0.3, lengthen=True)).segment_time == approx(
        0.41
    )


def test_a_speed_that_takes_forever_is_refused() -> None:
    rig = PlannedRig()
    with pytest.raises(MoveError, match=r"segment of 1000 s, over 100 s"):
        rig.plan(at_pose(ACROSS), How(speed=1e-4))


# --- Curves -----------------------------------------------------------------------------------


def wave(frequency: float) -> Curve:
    def angles(x: float, previous: Joints) -> Joints:
        return (math.sin(frequency * x), 2.0, x, x * x, math.exp(x), math.cos(x))

    return Curve(angles, (0.5, 2.0), (0.0,) * 6)


@pytest.mark.parametrize(("frequency", "degree"), [(1.0, 16), (10.0, 32), (60.0, 128)])
def test_a_curve_knows_values_and_derivatives(frequency: float, degree: int) -> None:
    curve, w = wave(frequency), frequency
    x = np.linspace(0.5, 2.0, 77)
    assert curve.resolved and curve.degree == degree
    exact = (np.sin(w * x), w * np.cos(w * x), -w * w * np.sin(w * x), -(w**3) * np.cos(w * x))
    for order, (got, expected) in enumerate(zip(curve.derivatives(x, 0.004), exact, strict=True)):
        bound = FADED * (2.0 * degree**2) ** order
        assert np.abs(got[:, 0] - expected).max() < bound
    assert curve.last == (math.sin(w * 2.0), 2.0, 2.0, 4.0, math.exp(2.0), math.cos(2.0))


def test_samples_continue_the_turns_of_their_neighbours() -> None:
    """Angles that come back modulo a turn make a curve of one piece."""

    def angles(x: float, previous: Joints) -> Joints:
        turn = math.remainder(4.0 * x - previous[0], math.tau) + previous[0]
        return (turn, *previous[1:])

    curve = Curve(angles, (0.0, 5.0), (0.0,) * 6)
    assert curve.resolved
    assert curve.last[0] == approx(20.0)


def test_a_leap_is_not_resolved_and_keeps_its_size() -> None:
    def angles(x: float, previous: Joints) -> Joints:
        return (0.0, 0.0, 3.0 if x > 0.4 else 0.0, 0.0, 0.0, 0.0)

    curve = Curve(angles, (0.0, 1.0), (0.0,) * 6)
    assert not curve.resolved
    assert curve.largest_step.tolist() == [0.0, 0.0, 3.0, 0.0, 0.0, 0.0]


@pytest.mark.parametrize("near", [1e-2, 1e-3, 3e-4])
def test_a_curve_next_to_a_singularity_is_cut_until_its_pieces_have_faded(near: float) -> None:
    """theta4 as a wrist passes by: half a turn within a few times ``near`` of the way."""
    poses = 0

    def angle(x: Floats) -> Floats:
        return np.arctan((x - 0.37) / near)

    def angles(x: float, previous: Joints) -> Joints:
        nonlocal poses
        poses += 1
        return (0.0, 0.0, 0.0, math.atan((x - 0.37) / near), x, 0.0)

    curve, tau = Curve(angles, (0.0, 1.0), (0.0,) * 6), 0.004
    assert curve.resolved and not curve.whole
    assert poses < 1000
    x = np.linspace(0.0, 1.0, 4001)
    value, first, second, third = curve.derivatives(x, tau)[:, :, 3]
    assert np.abs(value - angle(x)).max() < FADED
    inner = (x >= tau) & (x <= 1.0 - tau)
    before, there, after = (angle(x[inner] + k * tau) for k in (-1, 0, 1))
    assert np.abs(first[inner] - (after - before) / (2 * tau)).max() < 2 * FADED / tau
    assert np.abs(second[inner] - (after - 2 * there + before) / tau**2).max() < 5 * FADED / tau**2
    assert not third.any()


def test_where_a_curve_in_pieces_stands_differences_are_taken_over_little() -> None:
    """At its ends a path moves by next to nothing in a period, however steep it is there."""

    def angles(x: float, previous: Joints) -> Joints:
        return (math.atan(x / 1e-3), 0.0, 0.0, 0.0, 0.0, 0.0)

    curve = Curve(angles, (0.0, 1.0), (0.0,) * 6)
    first = curve.derivatives(np.array([0.0, 1.0]), np.zeros(2))[1, :, 0]
    assert first[0] == approx(1e3, rel=1e-3)
    assert first[1] == approx(1e-3, abs=2 * FADED / SHORTEST)

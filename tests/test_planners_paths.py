"""Paul's and Taylor's methods in the bench: what they promise, and what they are known to lack."""

import math

import numpy as np
import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st
from planners import paul, taylor
from planners.deviation import apart, deviation
from planners.double_turn import DoubleTurn
from planners.planner import NotPossibleError
from planners.run import Run
from planners.task import Leg, Task
from pytest import approx
from support.programs.planner_tasks import BELT, CORNER, PICK, TAU, order, straight

from rfms_can.arm import PUMA_260
from rfms_can.errors import KinematicsError
from rfms_can.kinematics import InverseKinematics, Joints, direct
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Mode

# --- Paul -----------------------------------------------------------------------------------------

angles = st.floats(-3.0, 3.0)


@given(angles, angles, angles, st.floats(-1.0, 1.0))
def test_the_two_turns_place_any_pose(a: float, b: float, c: float, x: float) -> None:
    place = Transform.translation(x, 0.2, -x) @ Transform.euler(a, b, c)
    assert tuple(DoubleTurn.of(place).transform()) == approx(tuple(place), abs=1e-12)


@given(*(angles for _ in range(6)))
def test_one_sense_of_two_axes_names_the_same_places(
    a: float, b: float, c: float, d: float, e: float, f: float
) -> None:
    """The axis of one leg is then at most a quarter turn from that of the other."""
    given_ahead, given_behind = (DoubleTurn.of(Transform.euler(*x)) for x in ((a, b, c), (d, e, f)))
    ahead, behind = DoubleTurn.in_one_sense(given_ahead, given_behind)
    assert abs(ahead.psi - behind.psi) <= math.pi / 2.0 + 1e-9
    assert tuple(ahead.transform()) == approx(tuple(given_ahead.transform()), abs=1e-8)
    assert tuple(behind.transform()) == approx(tuple(given_behind.transform()), abs=1e-8)


@given(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
def test_the_quartic_leaves_one_line_and_joins_the_other(ahead: float, behind: float) -> None:
    """Value, rate and, to the step's own error, acceleration: zero at both ends."""
    step = 1e-4

    def at(p: float) -> float:
        return paul.quartic(ahead, behind, p)

    assert (at(0.0), at(1.0)) == approx((behind, ahead))
    for p, rate in ((0.0, -2.0 * behind), (1.0, 2.0 * ahead)):
        before, here, after = (at(p + k * step) for k in (-1, 0, 1))
        assert (after - before) / (2.0 * step) == approx(rate, abs=1e-6)
        assert (after - 2.0 * here + before) / step**2 == approx(0.0, abs=1e-3)


@pytest.mark.parametrize("mode", Mode)
def test_transitions_of_one_mode_are_continuous_up_to_acceleration(mode: Mode) -> None:
    task = straight((0.0, 0.08, 0.0, 0.0), (0.06, 0.08, 0.0, 25.0), mode=mode)
    assert order(paul.PaulPlanner, task) == 2


def test_a_tool_that_turns_on_both_legs_steps_in_velocity() -> None:
    """psi runs evenly from the axis of one leg to that of the next, and stands outside."""
    assert order(paul.PaulPlanner, CORNER) == 0


def test_a_change_of_mode_steps_in_velocity() -> None:
    """The motion left is taken for one of the new mode."""
    assert order(paul.PaulPlanner, PICK) == 0


def test_his_straight_motion_follows_a_goal_and_his_joint_motion_does_not() -> None:
    off = deviation(Run(paul.PaulPlanner, BELT, TAU))
    assert off.line is not None
    assert off.line.distance < 1e-9
    moving = Leg(BELT.legs[0].target, Mode.JOINT, 1.2, 0.2, (0.0, 0.05, 0.0))
    with pytest.raises(NotPossibleError, match="does not follow"):
        Run(paul.PaulPlanner, Task("j", PUMA_260, BELT.start, BELT.tool, (moving,)), TAU)


# --- Taylor ---------------------------------------------------------------------------------------

near_park = st.tuples(*(st.floats(q - 0.35, q + 0.35) for q in CORNER.start))
BOUNDS = taylor.Bounds(0.5e-3, 5e-3)


def planned(first: Joints, last: Joints, bounds: taylor.Bounds) -> list[taylor.Knot]:
    task = Task("line", PUMA_260, first, CORNER.tool, ())
    return taylor.bounded_deviation(task, line(first, last), first, last, bounds)


def line(first: Joints, last: Joints) -> taylor.Line:
    start, goal = (direct(PUMA_260, q) @ CORNER.tool for q in (first, last))
    return taylor.Line(start, goal)


@settings(max_examples=60)
@given(near_park, near_park)
def test_the_joint_path_stays_within_its_bound_of_the_line(first: Joints, last: Joints) -> None:
    """The method looks at midpoints, where the largest deviation nearly is; a tenth is for nearly.

    Rounded by parabolas the path leaves the knots too, to the same side and no further.
    """
    try:
        knots = planned(first, last, BOUNDS)
    except KinematicsError:
        reject()
    path, ideal = taylor.JointPath(knots), line(first, last)
    offs = [
        apart(ideal.at(h), direct(PUMA_260, path.at(h)) @ CORNER.tool)
        for h in np.linspace(0.0, 1.0, 400).tolist()
    ]
    assert max(off.distance for off in offs) < 1.1 * BOUNDS.position
    assert max(off.angle for off in offs) < 1.1 * BOUNDS.rotation


def test_a_fourth_of_the_bound_takes_twice_the_knots() -> None:
    """Deviation goes with the square of the interval."""
    first, last = CORNER.start, (0.5, 1.2, -3.0, 0.4, -1.0, 0.3)
    counts = [len(planned(first, last, taylor.Bounds(b, 1.0))) - 1 for b in (8e-3, 2e-3, 5e-4)]
    assert counts[0] >= 2
    assert counts[1] == approx(2 * counts[0], abs=1)
    assert counts[2] == approx(2 * counts[1], abs=2)


def test_knots_lie_on_the_line_and_share_one_branch() -> None:
    planner = taylor.TaylorPlanner(CORNER, TAU)
    solve = InverseKinematics(PUMA_260).solve
    for number, knots in enumerate(planner.knots):
        ideal = taylor.Line(CORNER.before(number, 0.0), CORNER.legs[number].target)
        for knot in knots:
            place = ideal.at(knot.h)
            assert apart(place, direct(PUMA_260, knot.q) @ CORNER.tool).distance < 1e-12
            t6 = place @ CORNER.tool.inverse()
            assert solve(t6, CORNER.configuration, knot.q) == approx(knot.q, abs=1e-9)


@pytest.mark.parametrize("task", [CORNER, PICK], ids=lambda task: task.name)
def test_parabolas_are_continuous_up_to_velocity(task: Task) -> None:
    assert order(taylor.TaylorPlanner, task) == 1

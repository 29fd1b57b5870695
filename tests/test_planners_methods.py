"""Each planner of the bench keeps what its method promises, and shows what it is known to lack."""

import math
import sys
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st
from pytest import approx

from rfms_can.analysis.planners import jerk_limited, paul, taylor, thesis, whitney
from rfms_can.analysis.planners.bench import FINE_PERIODS
from rfms_can.analysis.planners.deviation import Off, apart, deviation
from rfms_can.analysis.planners.double_turn import DoubleTurn
from rfms_can.analysis.planners.planner import Method, NotPossibleError
from rfms_can.analysis.planners.run import Run
from rfms_can.analysis.planners.smoothness import continuity, differences, peak
from rfms_can.analysis.planners.task import TASKS, Leg, Task
from rfms_can.arm import PUMA_260, PUMA_560, Arm
from rfms_can.errors import KinematicsError
from rfms_can.kinematics import InverseKinematics, Joints, direct
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Mode

TAU = 0.004
CORNER, PICK, BELT = (TASKS[name](PUMA_260) for name in ("corner", "pick", "belt"))


def order(method: Method, task: Task) -> int:
    coarse, fine = (Run(method, task, period) for period in FINE_PERIODS)
    return continuity(coarse, fine)


def straight(*legs: tuple[float, float, float, float], mode: Mode = Mode.CARTESIAN) -> Task:
    """Legs of the corner task: metres in the base frame, and a turn in degrees about one axis."""
    place = CORNER.before(0, 0.0)
    made = []
    for x, y, z, degrees in legs:
        turn = Transform.rotation((0.6, 0.0, 0.8), math.radians(degrees))
        made.append(Leg(Transform.translation(x, y, z) @ place @ turn, mode, 0.9, 0.2))
    return Task("straight", CORNER.arm, CORNER.start, CORNER.tool, tuple(made))


# --- All of them --------------------------------------------------------------------------------


@pytest.mark.parametrize("arm", [PUMA_260, PUMA_560], ids=lambda arm: arm.name)
@pytest.mark.parametrize("task", TASKS)
@pytest.mark.parametrize(
    ("method", "close"),
    [
        (thesis.ThesisPlanner, 1e-9),
        (paul.PaulPlanner, 1e-9),
        (taylor.TaylorPlanner, 1e-9),
        (whitney.closed_loop, 2e-5),
        (jerk_limited.RuckigPlanner, 5e-5),
    ],
)
def test_the_last_goal_is_reached_within_the_joint_ranges(
    method: Method, close: float, task: str, arm: Arm
) -> None:
    try:
        run = Run(method, TASKS[task](arm), TAU)
    except NotPossibleError:
        assert (method, task) in {(taylor.TaylorPlanner, "belt"), (whitney.closed_loop, "pick")}
        return
    assert deviation(run).goal.distance < close
    lower, upper = np.array(arm.joint_limits).T
    assert np.all((run.q > lower) & (run.q < upper))
    assert np.all(np.abs(differences(run, 1)) < np.array(arm.speed_limits))


@pytest.mark.parametrize("task", [CORNER, PICK, BELT], ids=lambda task: task.name)
def test_the_thesis_planner_is_continuous_up_to_jerk(task: Task) -> None:
    assert order(thesis.ThesisPlanner, task) == 3


def test_the_thesis_planner_is_what_the_master_sends() -> None:
    """On a line in space it stays on it, outside transitions, and no joint is past its limit."""
    off = deviation(Run(thesis.ThesisPlanner, CORNER, TAU))
    assert off.line == approx(Off(0.0, 0.0), abs=1e-7)
    assert off.corner is not None
    assert 1e-3 < off.corner.distance < 5e-3


def test_a_leg_too_fast_for_the_arm_is_not_possible() -> None:
    fast = Task("fast", PUMA_260, CORNER.start, CORNER.tool, (
        Leg(CORNER.legs[0].target, Mode.CARTESIAN, 0.05, 0.01),
    ))  # fmt: skip
    with pytest.raises(NotPossibleError, match="exceeds"):
        Run(thesis.ThesisPlanner, fast, 0.001)


# --- Whitney --------------------------------------------------------------------------------------


def drift(method: Method, period_s: float) -> float:
    return deviation(Run(method, straight((-0.02, 0.08, 0.0, 40.0)), period_s)).goal.distance


def test_the_drift_of_resolved_rates_shrinks_with_the_period_and_no_faster() -> None:
    """The integral's error is of first order; the second is what is left of the ratio to 2."""
    drifts = [drift(whitney.open_loop, period) for period in (0.004, 0.002, 0.001)]
    assert drifts[0] > 2e-5
    for longer, shorter in pairwise(drifts):
        assert longer / shorter == approx(2.0, abs=0.1)


def test_the_loop_closed_each_sample_takes_the_drift_out() -> None:
    assert drift(whitney.closed_loop, TAU) < 0.05 * drift(whitney.open_loop, TAU)


@pytest.mark.parametrize("method", [whitney.open_loop, whitney.closed_loop])
def test_resolved_rates_step_from_leg_to_leg(method: Method) -> None:
    assert order(method, CORNER) == 0


def test_what_resolved_rates_cannot_do_is_said() -> None:
    with pytest.raises(NotPossibleError, match="no joint motion"):
        Run(whitney.closed_loop, PICK, TAU)
    with pytest.raises(NotPossibleError, match="aims at the goal once"):
        Run(whitney.open_loop, BELT, TAU)


def test_resolved_rates_stop_at_a_singularity() -> None:
    """J has no inverse there: |S5| under its bound."""
    q = (0.1, 1.4, -3.3, 0.1, 0.0, 0.1)
    place = direct(PUMA_260, q) @ CORNER.tool
    leg = Leg(Transform.translation(0.0, 0.02, 0.0) @ place, Mode.CARTESIAN, 0.9, 0.2)
    with pytest.raises(NotPossibleError, match="wrist singularity"):
        Run(whitney.closed_loop, Task("wrist", PUMA_260, q, CORNER.tool, (leg,)), TAU)


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


# --- Ruckig ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("arm", [PUMA_260, PUMA_560], ids=lambda arm: arm.name)
@pytest.mark.parametrize("name", TASKS)
def test_ruckig_keeps_velocity_acceleration_and_jerk_limits(name: str, arm: Arm) -> None:
    """Differences are means of the derivative over a period or more: they never exceed its peak."""
    task = TASKS[name](arm)
    run = Run(jerk_limited.RuckigPlanner, task, TAU)
    for degree, limits in (
        (1, arm.speed_limits),
        (2, arm.acceleration_limits),
        (3, jerk_limited.jerk_limits(task)),
    ):
        most = np.max(np.abs(differences(run, degree)), axis=0)
        assert np.all(most <= np.array(limits) * (1 + 1e-6))
    assert peak(run, 3) > 0.9 * max(jerk_limited.jerk_limits(task))


@pytest.mark.parametrize("task", [CORNER, PICK, BELT], ids=lambda task: task.name)
def test_ruckig_is_continuous_up_to_acceleration(task: Task) -> None:
    assert order(jerk_limited.RuckigPlanner, task) == 2


def test_ruckig_passes_the_via_points() -> None:
    run = Run(jerk_limited.RuckigPlanner, CORNER, TAU)
    via = int(np.argmax(run.leg == 1))
    tool = direct(PUMA_260, run.q[via].tolist()) @ CORNER.tool
    passed = apart(CORNER.legs[0].target, tool).distance
    assert passed < 0.2 * TAU  # within a period at 0.2 m/s


def test_without_the_library_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ruckig", None)
    with pytest.raises(NotPossibleError, match=r"pip install 'rfms_can\[bench\]'"):
        Run(jerk_limited.RuckigPlanner, CORNER, TAU)

"""Each planner of the bench keeps what its method promises, and shows what it is known to lack."""

import sys
from itertools import pairwise

import numpy as np
import pytest
from planners import jerk_limited, paul, taylor, thesis, whitney
from planners.deviation import Off, apart, deviation
from planners.planner import Method, NotPossibleError
from planners.run import Run
from planners.smoothness import differences, peak
from planners.task import TASKS, Leg, Task
from pytest import approx
from support.programs.planner_tasks import BELT, CORNER, PICK, TAU, order, straight

from rfms_can.arm import PUMA_260, PUMA_560, Arm
from rfms_can.kinematics import direct
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Mode

# --- All of them --------------------------------------------------------------------------------


@pytest.mark.parametrize("arm", [PUMA_260, PUMA_560], ids=lambda arm: arm.name)
@pytest.mark.parametrize("task", TASKS)
@pytest.mark.parametrize(
    ("method", "close"),
    [
        (thesis.ThesisPlanner, 1e-9),
        (thesis.as_printed, 1e-9),
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


@pytest.mark.parametrize(
    ("task", "continuous"), [(CORNER, 1), (PICK, 2), (BELT, 1)], ids=["corner", "pick", "belt"]
)
def test_the_thesis_own_blend_steps_where_a_straight_line_or_a_moving_goal_is_left(
    task: Task, continuous: int
) -> None:
    assert order(thesis.as_printed, task) == continuous


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

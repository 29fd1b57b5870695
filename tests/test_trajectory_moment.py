"""The motion parameters h and t that goals are told (thesis III.3.2)."""

import itertools

import numpy as np
import pytest
from pytest import approx
from support.trajectory import POSITIONS, TAU, TOOL, Rig, WeavingGoal

from rfms_can.arm import PUMA_260
from rfms_can.kinematics import direct
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.trajectory.segment import Transition
from rfms_can.master.trajectory.states import Stage
from rfms_can.wire.vocabulary import Blend, Mode

JOINT, CARTESIAN = Mode.JOINT, Mode.CARTESIAN


def told(goal: WeavingGoal, h: float | None = None) -> list[Moment]:
    """One moment of each tick at which ``goal`` was asked, of those with this ``h``."""
    moments = [m for m in goal.moments if h is None or m.h == h]
    return [next(group) for _, group in itertools.groupby(moments, key=lambda m: m.tick)]


@pytest.mark.parametrize("mode", Mode)
@pytest.mark.parametrize("feed", [1.0, 0.5])
def test_t_is_local_time_from_minus_t_acc_and_h_its_segment_parameter(
    mode: Mode, feed: float
) -> None:
    rig, goal = Rig(), WeavingGoal(POSITIONS["W1"])
    rig.generator.set_feed(feed)
    rig.move_to(mode, goal, 1.0, 0.2)
    rig.run_to(Stage.START)
    goal.moments.clear()
    begin = rig.generator.tick_count
    rig.run(150)
    for moment, setpoint in zip(told(goal), rig.setpoints[begin:], strict=True):
        assert moment.h == setpoint.h
        assert moment.t == approx(setpoint.n * TAU)
    assert goal.moments[-1].t == approx(-0.2 + 150 * feed * TAU)


@pytest.mark.parametrize("feed", [1.0, 0.5, 0.3])
@pytest.mark.parametrize("mode", Mode)
def test_ahead_of_its_start_a_segment_is_at_h_0_and_t_counts_up_to_minus_t_acc(
    mode: Mode, feed: float
) -> None:
    rig, first, goal = Rig(), WeavingGoal(POSITIONS["W1"]), WeavingGoal(POSITIONS["W2"])
    rig.generator.set_feed(feed)
    rig.move_to(JOINT, first, 1.2, 0.2)
    rig.run_to(Stage.LINEAR)
    rig.move_to(mode, goal, 1.0, 0.2)
    goal.moments.clear()
    rig.run_to(Stage.START)
    watched = told(goal)[1:]  # without the moment D(1) was solved at
    start = rig.setpoints[-1]
    assert {moment.h for moment in watched} == {0.0}
    assert np.diff([moment.t for moment in watched]) == approx(feed * TAU)
    assert watched[-1].t == approx((start.n) * TAU)
    assert start.n == approx(-40 + start.p * 80)
    assert len(watched) >= 10


@pytest.mark.parametrize("transition", Transition)
def test_to_rest_the_goal_is_at_h_1_and_t_goes_on_there_and_at_rest(transition: Transition) -> None:
    rig, goal = Rig(), WeavingGoal(POSITIONS["W1"])
    rig.move_to(CARTESIAN, goal, 1.0, 0.2, transition=transition)
    rig.run_to(Stage.LINEAR)
    goal.moments.clear()
    before = rig.setpoints[-1].n * TAU
    rig.finish()
    by_tick = {moment.tick: moment for moment in goal.moments}
    times = [moment.t for _, moment in sorted(by_tick.items())]
    assert np.diff([before, *times]) == approx(TAU)
    assert all(moment.h == 1.0 for moment in told(goal)[-80:])
    assert rig.stages[-1] is Stage.IDLE
    here = direct(PUMA_260, tuple(rig.q[-1])) @ TOOL
    assert here == approx(goal.left(Moment(0, 1.0, times[-1])), abs=1e-9)


def test_b_of_a_hand_over_is_the_goal_left_at_h_1_and_its_t() -> None:
    rig, goal = Rig(), WeavingGoal(POSITIONS["W1"])
    rig.move_to(JOINT, goal, 1.0, 0.2)
    rig.move(JOINT, "W2", 1.0, 0.2)
    rig.run_to(Stage.PRE)
    rig.tick()
    assert rig.stages[-1] is Stage.START
    assert approx(goal.pose(Moment(0, 1.0, 0.8)), abs=1e-12) == rig.setpoints[-1].T6_1


def test_feed_slows_h_and_t_but_not_goals_that_move_by_themselves() -> None:
    rig, goal = Rig(), WeavingGoal(POSITIONS["W1"])
    rig.move_to(JOINT, goal, 1.0, 0.2)
    rig.run_to(Stage.LINEAR)
    rig.generator.pause()
    rig.run(120)
    goal.moments.clear()
    rig.run(10)
    moments = told(goal)
    assert len({(moment.h, moment.t) for moment in moments}) == 1
    assert [moment.tick for moment in moments] == list(range(moments[0].tick, moments[0].tick + 10))


@pytest.mark.parametrize("mode", Mode)
def test_functions_of_h_and_t_are_entered_and_left_without_a_step_of_jerk(mode: Mode) -> None:
    rigs = []
    for period in (0.005, 0.0025):
        rig = Rig(Blend.CONTINUOUS, period)
        rig.run(20)
        rig.move_to(mode, WeavingGoal(POSITIONS["W1"]), 1.0, 0.2)
        rig.move_to(JOINT, WeavingGoal(POSITIONS["W2"]), 1.0, 0.25)
        rig.move_to(mode, WeavingGoal(POSITIONS["W1"]), 1.2, 0.2)
        rig.finish()
        rigs.append(rig)
    coarse, fine = rigs
    assert fine.difference(4) < 1.2 * coarse.difference(4)
    for a, b in zip(coarse.starts(), fine.starts(), strict=True):
        assert fine.difference(4, b) < 1.5 * coarse.difference(4, a)

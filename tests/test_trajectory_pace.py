"""Feed rate, pause and resume: when the arm is where changes, where it goes does not."""

import itertools

import pytest
from pytest import approx
from support.trajectory import LEFT_DOWN, POSITIONS, Rig, WeavingGoal, deviation

from rfms_can.arm import PUMA_260
from rfms_can.errors import MoveError
from rfms_can.kinematics import direct
from rfms_can.master.trajectory.states import Stage
from rfms_can.wire.vocabulary import Blend, Mode, TrajectoryState

JOINT, CARTESIAN = Mode.JOINT, Mode.CARTESIAN

JOINT_MOVES = ((JOINT, "W1", 1.0, 0.2), (JOINT, "W2", 1.0, 0.25), (JOINT, "W3", 0.9, 0.2))
MIXED_MOVES = ((CARTESIAN, "W1", 1.0, 0.2), (CARTESIAN, "W2", 1.0, 0.25), (JOINT, "W3", 0.9, 0.2))


Moves = tuple[tuple[Mode, str, float, float], ...]


def loaded(moves: Moves, blend: Blend = Blend.CONTINUOUS) -> Rig:
    rig = Rig(blend)
    rig.run(20)
    for move in moves:
        rig.move(*move)
    return rig


def finished(rig: Rig) -> Rig:
    rig.finish(50000)
    return rig


def run_until_it_stands(rig: Rig, limit: int = 2000) -> int:
    for ticks in range(limit):
        if rig.generator.feed == 0.0:
            return ticks
        rig.tick()
    raise AssertionError(f"not at a standstill after {limit} ticks")


# --- The path ---------------------------------------------------------------------------------


@pytest.mark.parametrize("feed", [0.5, 0.3, 1 / 7, 0.05])
@pytest.mark.parametrize("blend", Blend)
def test_a_joint_path_is_the_same_at_any_feed_rate(feed: float, blend: Blend) -> None:
    slow = loaded(JOINT_MOVES)
    slow.generator.set_feed(feed)
    assert deviation(finished(slow), finished(loaded(JOINT_MOVES))) < 1e-7
    assert slow.generator.completed == 3
    assert slow.q[-1] == approx(finished(loaded(JOINT_MOVES)).q[-1], abs=1e-12)


@pytest.mark.parametrize("feed", [0.5, 0.3, 0.05])
def test_leaving_a_straight_line_differs_by_what_the_joints_estimate(feed: float) -> None:
    """The window of the estimate spans less of the path the slower it is run."""
    slow = loaded(MIXED_MOVES)
    slow.generator.set_feed(feed)
    assert deviation(finished(slow), finished(loaded(MIXED_MOVES))) < 5e-5


def test_half_the_feed_rate_takes_twice_the_time_and_matches_over_twice_t_acc() -> None:
    half, whole = loaded(JOINT_MOVES), finished(loaded(JOINT_MOVES))
    half.generator.set_feed(0.5)
    finished(half)
    begin, *_, end = half.starts()
    first, *_, last = whole.starts()
    assert end - begin == 2 * (last - first)
    starts = [half.setpoints[k].acceleration_time for k in half.starts()]
    assert starts == approx([0.4, 0.5, 0.4, 0.4])


@pytest.mark.parametrize("moves", [JOINT_MOVES, MIXED_MOVES])
def test_a_feed_rate_that_changes_all_the_time_keeps_the_path(
    moves: Moves,
) -> None:
    nominal, rig = finished(loaded(moves)), loaded(moves)
    feeds = itertools.cycle((0.4, 1.0, 0.7, 0.2, 0.9))
    for k in itertools.count():
        if k % 61 == 0:
            rig.generator.set_feed(next(feeds))
        rig.tick()
        if rig.generator.at_rest:
            break
    assert rig.generator.completed == 3
    assert deviation(rig, nominal) < (1e-7 if moves is JOINT_MOVES else 5e-5)
    assert rig.difference(2) < 1.3 * nominal.difference(2)


@pytest.mark.parametrize("at", range(2, 600, 41))
@pytest.mark.parametrize("moves", [JOINT_MOVES, MIXED_MOVES])
def test_a_pause_anywhere_stands_soon_and_keeps_the_path(moves: Moves, at: int) -> None:
    nominal, rig = finished(loaded(moves)), loaded(moves)
    rig.run(at)
    rig.generator.pause()
    assert rig.generator.paused
    assert run_until_it_stands(rig) <= 4 * 50 + 32
    rig.tick()
    stood = rig.q[-1]
    rig.run(150)
    assert rig.q[-1] == rig.q[-150] == stood
    assert all(joint.rate == joint.acceleration == 0.0 for joint in rig.joints)
    rig.generator.resume()
    assert not rig.generator.paused
    finished(rig)
    assert rig.generator.completed == 3
    assert deviation(rig, nominal) < (1e-7 if moves is JOINT_MOVES else 5e-5)
    assert rig.difference(2) < 1.5 * nominal.difference(2)


def test_the_feed_ramps_without_a_step_of_acceleration_or_jerk() -> None:
    growth = []
    for period in (0.005, 0.0025):
        rig = Rig(period_s=period)
        rig.move(JOINT, "W1", 3.0, 0.2)
        rig.run(round(0.5 / period))
        rig.generator.set_feed(0.3)
        rig.run(round(0.6 / period))
        rig.generator.pause()
        rig.run(round(0.6 / period))
        rig.generator.resume()
        rig.run(round(0.6 / period))
        growth.append(rig.difference(4, round(1.2 / period), round(0.9 / period)))
    assert growth[1] < 1.2 * growth[0]  # a step of jerk would double it


# --- At rest ----------------------------------------------------------------------------------


def test_at_rest_a_pause_acts_at_once_and_keeps_a_queued_move_from_departing() -> None:
    rig = Rig()
    rig.run(1)
    rig.generator.pause()
    rig.move(JOINT, "W1", 1.0, 0.2)
    rig.run(100)
    assert set(rig.stages) == {Stage.IDLE}
    assert rig.generator.feed == 0.0
    rig.generator.resume()
    rig.run(2)
    assert rig.stages[-1] is Stage.START
    rig.finish()
    assert rig.generator.completed == 1


def test_a_move_that_watches_its_moving_goal_is_held_back_by_a_pause() -> None:
    rig = Rig()
    rig.move(JOINT, "W1", 1.0, 0.2, (0.0, 0.01, 0.0))
    rig.run(5)
    rig.generator.pause()
    rig.run(100)
    assert set(rig.stages) == {Stage.IDLE}
    assert rig.generator.waiting == 1
    rig.generator.resume()
    rig.finish()
    assert rig.generator.completed == 1
    assert rig.difference(2) < 20.0


def test_a_goal_that_is_a_function_of_t_slows_down_evenly_also_at_rest() -> None:
    rig = Rig()
    rig.move_to(JOINT, WeavingGoal(POSITIONS["W1"]), 1.0, 0.2)
    rig.finish()
    before = rig.difference(3, len(rig.q) - 12)
    rig.generator.pause()
    first = len(rig.q)
    run_until_it_stands(rig)
    rig.run(5)
    assert rig.q[-1] == rig.q[-2]
    rig.generator.resume()
    rig.run(120)
    assert rig.difference(3, first + 100, 110) < 4.0 * max(before, 1.0)


# --- Hand-overs -------------------------------------------------------------------------------


def test_a_change_too_near_to_a_hand_over_waits_until_it_is_past() -> None:
    rig = loaded(JOINT_MOVES)
    rig.run_to(Stage.LINEAR, 120)  # hands over at n = 150
    rig.generator.pause()
    rig.run_to(Stage.START)
    assert rig.generator.feed == 1.0
    assert rig.setpoints[-1].acceleration_time == 0.25
    run_until_it_stands(rig)
    assert rig.stages[-1] is Stage.BLEND
    assert 0.0 < rig.setpoints[-1].p < 1.0


def test_after_a_pause_near_a_hand_over_the_arm_crawls_across_it() -> None:
    rig = loaded(JOINT_MOVES)
    rig.run_to(Stage.LINEAR, 90)
    rig.generator.pause()
    run_until_it_stands(rig)
    assert rig.stages[-1] is Stage.LINEAR
    rig.generator.resume()
    rig.run_to(Stage.START)
    assert 0.25 <= rig.generator.feed < 1.0
    assert rig.setpoints[-1].acceleration_time == approx(0.25 / rig.generator.feed)
    rig.run_to(Stage.LINEAR)
    assert rig.generator.feed == 1.0


@pytest.mark.parametrize("late", [0, 5, 20])
def test_a_move_requested_while_the_pace_changes_starts_late_or_from_rest(late: int) -> None:
    rig = Rig()
    rig.move(JOINT, "W1", 1.0, 0.2)
    rig.run_to(Stage.LINEAR, 60)
    rig.generator.set_feed(0.3)
    rig.run(40 + late)
    rig.move(JOINT, "W2", 1.5, 0.5)  # due at n = 100
    finished(rig)
    assert rig.generator.completed == 2
    nominal = Rig()
    nominal.move(JOINT, "W1", 1.0, 0.2)
    nominal.move(JOINT, "W2", 1.5, 0.5)
    nominal.finish()
    assert rig.difference(2) < 1.5 * nominal.difference(2)


# --- A controlled stop ------------------------------------------------------------------------


def enable_here(rig: Rig) -> None:
    q1, q2, q3, q4, q5, q6 = rig.q[-1]
    rig.generator.enable(direct(PUMA_260, (q1, q2, q3, q4, q5, q6)), LEFT_DOWN)


@pytest.mark.parametrize("at", [30, 60, 90, 140, 250, 560])
def test_a_stop_in_a_pause_moves_nothing_and_the_next_move_starts_from_rest(at: int) -> None:
    rig = loaded(JOINT_MOVES)
    rig.run(at)
    rig.generator.pause()
    run_until_it_stands(rig)
    rig.run(5)
    stood, under_way = rig.q[-1], rig.generator.sequence
    assert rig.generator.stop() == tuple(range(under_way, 4))
    rig.run(2)
    assert rig.q[-1] == stood
    assert rig.generator.stopped
    with pytest.raises(MoveError, match="the arm is stopping: wait until it rests"):
        rig.move(JOINT, "W1", 1.0, 0.2)
    rig.generator.resume()
    enable_here(rig)
    rig.move(JOINT, "W0", 1.0, 0.2)
    first = len(rig.q)
    rig.finish()
    assert rig.q[first] == approx(stood, abs=1e-12)
    assert rig.difference(2, first, 8) < 1.0
    assert rig.generator.completed == 5


def test_a_stop_slows_down_at_the_feed_rate_it_has() -> None:
    rig = loaded(JOINT_MOVES)
    rig.generator.set_feed(0.5)
    rig.run_to(Stage.LINEAR, 60)
    rig.generator.stop()
    ticks = 0
    while not rig.generator.stopped:
        rig.tick()
        ticks += 1
    assert ticks == 160
    assert rig.setpoints[-1].h == approx((60 + 40) / 200)
    assert rig.setpoints[-1].state is TrajectoryState.LINEAR


def test_a_pause_during_a_stop_ends_it_sooner() -> None:
    rig = loaded(JOINT_MOVES)
    rig.run_to(Stage.LINEAR, 60)
    rig.generator.stop()
    rig.run(10)
    rig.generator.pause()
    while not rig.generator.stopped:
        rig.tick()
    assert rig.setpoints[-1].h < (60 + 39) / 200
    assert rig.difference(2) < 60.0


# --- Refusals ---------------------------------------------------------------------------------


@pytest.mark.parametrize("rate", [0.0, -1.0, 0.049, 1.01, float("nan")])
def test_a_feed_rate_is_a_part_of_full_speed(rate: float) -> None:
    rig = Rig()
    with pytest.raises(MoveError, match=r"not in 0\.05 to 1: to stand still, pause"):
        rig.generator.set_feed(rate)
    assert rig.generator.feed == 1.0


def test_a_transition_longer_than_the_wire_can_say_is_refused() -> None:
    rig = Rig()
    rig.generator.set_feed(0.05)
    with pytest.raises(MoveError, match=r"6 s at a feed rate of 0\.05 would take 120 s, over 100"):
        rig.move(JOINT, "W1", 20.0, 6.0)
    rig.generator.set_feed(0.5)
    rig._sequence = 0
    rig.move(JOINT, "W1", 20.0, 6.0)
    with pytest.raises(MoveError, match=r"feed at 0\.06 or more"):
        rig.generator.set_feed(0.05)
    rig.run(1)
    assert rig.generator.feed == 0.5

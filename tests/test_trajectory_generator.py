"""The master's state machine: what is taken and refused, when it starts, how it stops."""

import itertools

import pytest
from pytest import approx
from support.trajectory import HOME, LEFT_DOWN, TAU, TOOL, Rig

from rfms_can.arm import PUMA_260
from rfms_can.errors import MoveError, RfmsError
from rfms_can.kinematics import Configuration, direct
from rfms_can.master.trajectory.generator import TrajectoryGenerator
from rfms_can.master.trajectory.goal import FixedGoal
from rfms_can.master.trajectory.queue import MAX_QUEUE
from rfms_can.master.trajectory.segment import Move, whole_ticks
from rfms_can.master.trajectory.states import TRANSITIONS, Event, Stage, following
from rfms_can.messages import Outcome
from rfms_can.setpoint.history import window_for
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Blend, Mode, TrajectoryState

JOINT, CARTESIAN = Mode.JOINT, Mode.CARTESIAN


def largest_step(rig: Rig, first: int, last: int) -> float:
    """Largest velocity change between neighbouring periods, rad/s."""
    return rig.difference(2, (first + last) // 2, (last - first) // 2) * rig.period_s


# --- The table --------------------------------------------------------------------------------


@pytest.mark.parametrize(("stage", "event"), list(itertools.product(Stage, Event)))
def test_an_event_missing_from_the_table_is_named(stage: Stage, event: Event) -> None:
    target = TRANSITIONS[stage].get(event)
    if target is not None:
        assert following(stage, event) is target
        return
    with pytest.raises(RfmsError, match=f"{event.name} cannot happen in {stage.name}"):
        following(stage, event)


def test_every_stage_can_be_reached_and_left() -> None:
    reached, before = {Stage.OFF}, set[Stage]()
    while reached != before:
        before = set(reached)
        reached |= {target for stage in before for target in TRANSITIONS[stage].values()}
    assert reached == set(Stage)
    assert all(Event.DISABLE in row for row in TRANSITIONS.values())


def test_off_there_is_no_set_point_and_no_move() -> None:
    generator = TrajectoryGenerator(TAU)
    with pytest.raises(RfmsError, match="STAY cannot happen in OFF"):
        generator.tick()
    with pytest.raises(MoveError, match="is off: enable it first"):
        generator.request(Move(1, FixedGoal(Transform.identity()), JOINT, 100, 20, LEFT_DOWN))


# --- A move from rest to rest -----------------------------------------------------------------


def test_a_move_runs_through_table_3_3_and_ends_on_its_target() -> None:
    rig = Rig()
    rig.move(JOINT, "W1", 1.0, 0.2)
    rig.finish()
    runs = [(stage, len(list(group))) for stage, group in itertools.groupby(rig.stages)]
    assert runs == [
        (Stage.IDLE, 1),
        (Stage.START, 1),
        (Stage.BLEND, 80),
        (Stage.LINEAR, 118),
        (Stage.PRE, 1),
        (Stage.START, 1),
        (Stage.BLEND, 80),
        (Stage.IDLE, 13),
    ]
    assert rig.generator.completed == 1
    at_target = direct(PUMA_260, tuple(rig.q[-1])) @ TOOL
    goal = rig.setpoints[-1].T6_1 @ TOOL
    assert at_target == approx(goal, abs=1e-12)


def test_rest_is_exactly_still() -> None:
    rig = Rig()
    rig.run(5)
    assert all(joint.rate == joint.acceleration == 0.0 for joint in rig.joints)
    rig.move(CARTESIAN, "W1", 1.0, 0.2)
    rig.finish()
    assert rig.q[-1] == rig.q[-2] == rig.q[-10]
    assert all(joint.rate == joint.acceleration == 0.0 for joint in rig.joints)


def test_a_move_to_where_the_arm_stands_moves_nothing() -> None:
    rig = Rig()
    rig.move(JOINT, "W1", 1.0, 0.2)
    rig.finish()
    before = rig.q[-1]
    for mode in Mode:
        rig.move(mode, "W1", 0.6, 0.2)
    first = len(rig.q)
    rig.finish()
    assert rig.generator.completed == 3
    assert all(q == approx(before, abs=1e-13) for q in rig.q[first:])


# --- The next move ----------------------------------------------------------------------------


def test_the_next_move_takes_over_at_its_own_acceleration_time_before_the_goal() -> None:
    rig = Rig()
    rig.move(JOINT, "W1", 1.0, 0.2)
    rig.move(CARTESIAN, "W2", 1.0, 0.3)
    rig.run_to(Stage.PRE)
    assert rig.setpoints[-1].n == 200 - 60 - 1
    assert rig.setpoints[-1].T6_2 is not None
    assert rig.generator.completed == 0
    rig.tick()
    assert rig.stages[-1] is Stage.START
    assert rig.setpoints[-1].sequence == 2
    assert rig.generator.completed == 1


@pytest.mark.parametrize("n", [138, 139, 146])
@pytest.mark.parametrize("blend", Blend)
def test_a_late_move_starts_late_and_repeats_no_set_point(blend: Blend, n: int) -> None:
    rig = Rig(blend)
    rig.move(JOINT, "W1", 1.0, 0.2)  # would come to rest from n = 159 on
    rig.run_to(Stage.LINEAR, n)
    rig.move(JOINT, "W2", 1.2, 0.3)  # due at n = 140, late by 8 ticks at most
    first = len(rig.q)
    rig.run(2)
    assert rig.stages[-2:] == [Stage.PRE, Stage.START]
    rig.run(10)
    assert rig.generator.completed == 1
    assert largest_step(rig, first - 5, first + 10) < 0.01
    assert all(a != b for a, b in itertools.pairwise(rig.q[first - 3 :]))


@pytest.mark.parametrize("late", [0, 8, 9])
def test_a_late_move_never_swings_past_the_goal_it_leaves(late: int) -> None:
    """The next goal is the same one, so that nothing but the transition moves the arm."""
    rig = Rig()
    rig.move(JOINT, "W1", 1.0, 0.2)
    rig.run_to(Stage.LINEAR, 138 + late)
    rig.move(JOINT, "W1", 1.2, 0.3)
    first = len(rig.q)
    rig.run(2)
    assert (rig.stages[-1] is Stage.START) == (late <= 8)
    rig.finish()
    goal = rig.q[-1]
    for before, q in zip(rig.q[first:], rig.q[first + 1 :], strict=False):
        for start, theta, end in zip(before, q, goal, strict=True):
            assert abs(end - theta) <= abs(end - start) + 1e-12
    assert rig.generator.completed == 2


@pytest.mark.parametrize(("stage", "n"), [(Stage.LINEAR, 158), (Stage.PRE, 159), (Stage.BLEND, 0)])
def test_a_move_too_late_even_for_that_starts_from_rest(stage: Stage, n: int) -> None:
    rig = Rig()
    rig.move(JOINT, "W1", 1.0, 0.2)
    rig.run_to(Stage.LINEAR, 158)
    if stage is not Stage.LINEAR:
        rig.run_to(stage, n)
    rig.move(JOINT, "W2", 1.0, 0.3)
    rig.run_to(Stage.IDLE)
    assert rig.generator.completed == 1
    rig.finish()
    assert rig.generator.completed == 2
    assert rig.difference(2) * TAU < 0.1


def test_the_goal_left_is_solved_in_the_old_configuration_and_the_next_in_the_new() -> None:
    rig = Rig()
    flipped = Configuration.parse("left down flip")
    rig.move(JOINT, "W1", 1.0, 0.2)
    rig.move(JOINT, "W1", 2.0, 0.2, configuration=flipped)
    rig.run_to(Stage.PRE)
    rig.tick()
    start = rig.setpoints[-1]
    assert (start.configuration_1, start.configuration_2) == (LEFT_DOWN, flipped)
    rig.finish()
    assert rig.setpoints[-1].configuration_1 == flipped
    assert rig.difference(2) * TAU < 0.1
    assert direct(PUMA_260, tuple(rig.q[-1])) == approx(rig.setpoints[-1].T6_1, abs=1e-12)


def test_a_move_is_complete_when_the_arm_rests_not_when_it_brakes() -> None:
    rig = Rig()
    rig.move(JOINT, "W1", 1.0, 0.2)
    rig.run_to(Stage.PRE)
    rig.run(81)
    assert (rig.stages[-1], rig.generator.completed) == (Stage.BLEND, 0)
    rig.tick()
    assert (rig.stages[-1], rig.generator.completed) == (Stage.IDLE, 1)


def test_a_moving_goal_is_watched_for_a_while_before_the_arm_joins_it() -> None:
    rig = Rig()
    for _ in range(2):
        first = len(rig.q)
        rig.move(JOINT, "W1", 1.0, 0.2, (0.0, 0.01, 0.0))
        rig.run_to(Stage.START)
        watched = rig.setpoints[first:-1]
        assert len(watched) == window_for(40) - 1 == 19
        assert all(setpoint.T6_2 is not None for setpoint in watched)
        rig.finish()


def test_a_moving_goal_is_followed_at_rest_too() -> None:
    rig = Rig()
    rig.move(CARTESIAN, "W1", 1.0, 0.2, (0.0, 0.05, 0.0))
    rig.finish()
    here = direct(PUMA_260, tuple(rig.q[-1])) @ TOOL
    before = direct(PUMA_260, tuple(rig.q[-2])) @ TOOL
    assert (here.py - before.py) / TAU == approx(0.05, rel=1e-6)


# --- A controlled stop ------------------------------------------------------------------------


def test_a_stop_stays_on_the_straight_line_and_ends_at_rest() -> None:
    rig = Rig()
    rig.move(CARTESIAN, "W1", 1.5, 0.2)
    rig.run_to(Stage.LINEAR, 150)
    rig.move(JOINT, "W2", 1.0, 0.2)
    assert rig.generator.stop() == (1, 2)
    first = len(rig.q)
    rig.run(79)
    assert not rig.generator.stopped
    rig.run(1)
    assert rig.generator.stopped
    assert rig.setpoints[-1].h == approx((150 + 40) / 300)
    assert all(setpoint.state is TrajectoryState.LINEAR for setpoint in rig.setpoints[first:])
    points = [direct(PUMA_260, tuple(q)) @ TOOL for q in rig.q[first - 40 :]]
    start, end = points[0], points[-1]
    along = [end[i] - start[i] for i in (3, 7, 11)]
    for point in points:
        offset = [point[i] - start[i] for i in (3, 7, 11)]
        share = sum(a * b for a, b in zip(along, offset, strict=True)) / sum(a * a for a in along)
        assert offset == approx([share * a for a in along], abs=1e-12)
    rig.run(3)
    assert rig.q[-1] == rig.q[-2]
    assert largest_step(rig, first - 5, len(rig.q)) < 0.02


def test_a_stopped_arm_is_enabled_where_it_stands_and_moves_on() -> None:
    rig = Rig()
    rig.move(JOINT, "W1", 1.0, 0.2)
    rig.run_to(Stage.BLEND)
    assert rig.generator.stop() == (1,)
    with pytest.raises(MoveError, match="the arm is stopping: wait until it rests"):
        rig.move(JOINT, "W2", 1.0, 0.2)
    assert rig.generator.stop() == ()
    rig.run_to(Stage.STOP)
    assert rig.setpoints[-1].n == 40, "the transition under way is finished first"
    rig.run(100)
    stood = rig.q[-1]
    rig.generator.enable(direct(PUMA_260, tuple(stood)), LEFT_DOWN)
    assert rig.generator.at_rest
    rig.move(JOINT, "W2", 1.0, 0.2)
    rig.run(2)
    assert rig.stages[-2:] == [Stage.IDLE, Stage.START]
    assert rig.q[-2] == approx(stood, abs=1e-12)
    assert rig.q[-1] == approx(stood, abs=1e-12)
    rig.run_to(Stage.LINEAR)
    rig.generator.stop()
    rig.run(79)
    assert not rig.generator.stopped
    rig.run(1)
    assert rig.generator.stopped
    assert rig.difference(2) * TAU < 0.1


def test_a_stop_overtakes_a_hand_over_that_is_settled_but_not_begun() -> None:
    rig = Rig()
    rig.move(JOINT, "W1", 1.0, 0.2)
    rig.move(JOINT, "W2", 1.0, 0.2)
    rig.run_to(Stage.PRE)
    assert rig.generator.stop() == (1, 2)
    rig.tick()
    assert rig.stages[-1] is Stage.STOP
    rig.run(80)
    assert rig.generator.stopped
    assert rig.difference(2) * TAU < 0.05


def test_at_rest_or_on_the_way_there_a_stop_only_drops_what_waits() -> None:
    rig = Rig()
    assert rig.generator.stop() == ()
    rig.move(JOINT, "W1", 1.0, 0.2)
    assert rig.generator.stop() == (1,)
    rig.run(10)
    assert rig.generator.at_rest
    rig.move(JOINT, "W1", 1.0, 0.2)
    rig.run_to(Stage.PRE)
    rig.move(JOINT, "W2", 1.0, 0.2)
    assert rig.generator.stop() == (3,)
    rig.finish()
    assert rig.generator.completed == 3
    outcomes = rig.generator.outcomes.of(1, 3)
    assert [outcome.how for outcome in outcomes] == [
        Outcome.STOPPED,
        Outcome.MADE,
        Outcome.STOPPED,
    ]


def test_disabling_ends_the_set_points_at_once() -> None:
    rig = Rig()
    rig.move(JOINT, "W1", 1.0, 0.2)
    rig.run_to(Stage.BLEND)
    rig.generator.disable()
    with pytest.raises(RfmsError, match="STAY cannot happen in OFF"):
        rig.tick()


# --- Refusals ---------------------------------------------------------------------------------


def test_a_segment_must_hold_both_its_transitions() -> None:
    rig = Rig()
    with pytest.raises(MoveError, match=r"move 1: segment time 0\.405 s .* two periods, 0\.41 s"):
        rig.move(JOINT, "W1", 0.405, 0.2)
    rig._sequence = 0
    rig.move(JOINT, "W1", 0.41, 0.2)
    with pytest.raises(MoveError, match=r"move 2: acceleration time 0\.205 s .* leaves 0\.2 s"):
        rig.move(JOINT, "W2", 1.0, 0.205)
    rig.move(JOINT, "W2", 1.0, 0.2)
    rig.finish()
    assert rig.generator.completed == 3
    assert rig.difference(2) * TAU < 0.25


def test_a_move_must_fit_the_one_that_is_settled_to_follow() -> None:
    rig = Rig()
    rig.move(JOINT, "W1", 2.0, 0.2)
    rig.move(JOINT, "W2", 0.5, 0.2)
    rig.run_to(Stage.PRE)
    assert rig.generator.waiting == 0
    with pytest.raises(MoveError, match=r"too long to leave move 2, .* leaves 0\.29 s"):
        rig.move(JOINT, "W1", 1.0, 0.3)


def test_a_segment_with_no_time_between_its_transitions_has_one_tick_between_them() -> None:
    rig = Rig()
    rig.move(JOINT, "W1", 0.41, 0.2)
    rig.move(JOINT, "W2", 1.0, 0.2)
    rig.run_to(Stage.PRE)
    assert (rig.stages[-2], rig.setpoints[-1].n) == (Stage.BLEND, 41)
    rig.tick()
    assert rig.stages[-1] is Stage.START


def test_a_refused_move_changes_nothing() -> None:
    rig, same = Rig(), Rig()
    for each in (rig, same):
        each.move(JOINT, "W1", 1.0, 0.2)
    for segment, acceleration in ((0.1, 0.2), (2.0, 0.9)):
        rig._sequence = 1
        with pytest.raises(MoveError):
            rig.move(JOINT, "W2", segment, acceleration)
    rig._sequence = 0
    with pytest.raises(MoveError, match="numbers must grow, the last was 1"):
        rig.move(JOINT, "W2", 1.0, 0.2)
    for each in (rig, same):
        each.finish()
    assert rig.q == same.q


def test_a_straight_line_keeps_its_configuration_and_turns_no_further_than_it_can() -> None:
    rig = Rig()
    with pytest.raises(MoveError, match="cannot change the configuration from 'left down noflip'"):
        rig.move(CARTESIAN, "W1", 1.0, 0.2, configuration=Configuration.parse("right up flip"))
    pose = direct(PUMA_260, HOME) @ Transform.rotation((0.0, 0.0, 1.0), 2.6)
    with pytest.raises(MoveError, match=r"rotation of 2\.6 rad exceeds 0\.8 pi = 2\.513 rad"):
        rig.generator.request(Move(3, FixedGoal(pose), CARTESIAN, 200, 40, LEFT_DOWN))
    rig.generator.request(Move(3, FixedGoal(pose), JOINT, 200, 40, LEFT_DOWN))


def test_the_queue_has_an_end() -> None:
    rig = Rig()
    for _ in range(MAX_QUEUE):
        rig.move(JOINT, "W1", 1.0, 0.2)
    with pytest.raises(MoveError, match=f"{MAX_QUEUE} moves wait already"):
        rig.move(JOINT, "W1", 1.0, 0.2)
    assert rig.generator.waiting == MAX_QUEUE


@pytest.mark.parametrize("duration", [0.0, -1.0, float("nan"), float("inf"), 0.001])
def test_a_time_is_a_whole_number_of_periods(duration: float) -> None:
    with pytest.raises(MoveError):
        whole_ticks(duration, 0.004)
    assert whole_ticks(1.0, 0.004) == 250
    assert whole_ticks(0.3, 0.004) == 75

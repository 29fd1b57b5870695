"""Cartesian transitions: T6 itself blends, jerk-continuous in space, and rests on the line."""

import itertools
from collections.abc import Callable

import numpy as np
import pytest
from pytest import approx
from support.trajectory import HOME, LEFT_DOWN, POSITIONS, TAU, TOOL, Rig, WeavingGoal, deviation

from rfms_can.arm import PUMA_260
from rfms_can.errors import MoveError
from rfms_can.kinematics import direct
from rfms_can.master.trajectory.goal import FixedGoal
from rfms_can.master.trajectory.segment import Move, Transition
from rfms_can.master.trajectory.states import Stage
from rfms_can.transform import DriveTransform, Transform
from rfms_can.wire.vocabulary import Blend, Mode, TrajectoryState

JOINT, CARTESIAN = Mode.JOINT, Mode.CARTESIAN
SLOW = (-0.01, -0.006, -0.006)  # m/s

Program = Callable[[Rig], None]


def seam(rig: Rig) -> None:
    rig.curve("W1", 1.0, 0.2)
    rig.curve("W2", 1.2, 0.25)
    rig.curve("W1", 1.0, 0.2)


def from_and_to_moving_goals(rig: Rig) -> None:
    rig.curve("W1", 1.0, 0.2, SLOW)
    rig.curve("W2", 1.2, 0.2)
    rig.curve("W1", 1.0, 0.25, SLOW)


def among_joint_transitions(rig: Rig) -> None:
    rig.move(CARTESIAN, "W1", 1.0, 0.2)
    rig.curve("W2", 1.2, 0.2)
    rig.move(CARTESIAN, "W1", 1.0, 0.25)
    rig.curve("W2", 1.0, 0.2, SLOW)
    rig.move(JOINT, "W3", 1.0, 0.2)


def along_functions_of_h_and_t(rig: Rig) -> None:
    times = (1.2, 0.2)
    rig.move_to(CARTESIAN, WeavingGoal(POSITIONS["W1"]), *times, transition=Transition.CARTESIAN)
    rig.move_to(CARTESIAN, WeavingGoal(POSITIONS["W2"]), *times, transition=Transition.CARTESIAN)
    rig.move(JOINT, "W3", 1.0, 0.2)


PROGRAMS = [seam, from_and_to_moving_goals, among_joint_transitions, along_functions_of_h_and_t]


def run(program: Program, period_s: float = TAU, feed: float = 1.0) -> Rig:
    rig = Rig(Blend.CONTINUOUS, period_s)
    rig.run(20)
    rig.generator.set_feed(feed)
    program(rig)
    rig.finish(50000)
    return rig


def tool_points(rig: Rig) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Where the tool is told to be, metres; one row a cycle."""
    poses = (setpoint.T6_1 @ TOOL for setpoint in rig.setpoints)
    return np.array([(pose.px, pose.py, pose.pz) for pose in poses])


def off_the_line(
    points: np.ndarray[tuple[int, int], np.dtype[np.float64]], start: Transform, end: Transform
) -> float:
    """Largest distance from the straight line between two tool poses, metres."""
    first = np.array((start.px, start.py, start.pz))
    along = np.array((end.px, end.py, end.pz)) - first
    along /= np.linalg.norm(along)
    offset = points - first
    return float(np.max(np.linalg.norm(offset - np.outer(offset @ along, along), axis=1)))


# --- Continuity -------------------------------------------------------------------------------


@pytest.mark.parametrize("program", PROGRAMS)
def test_a_cartesian_transition_is_continuous_up_to_jerk(program: Program) -> None:
    coarse, fine = run(program, 0.005), run(program, 0.0025)
    assert fine.difference(4) < 1.2 * coarse.difference(4)  # a step of jerk would double it
    for a, b in zip(changes(coarse), changes(fine), strict=True):
        assert fine.difference(4, b) < 1.5 * coarse.difference(4, a)


def changes(rig: Rig) -> list[int]:
    """Ticks at which a transition begins or ends."""
    moving = (Stage.START, Stage.CURVE, Stage.BLEND)
    pairs = enumerate(itertools.pairwise(rig.stages), 1)
    return [k for k, (a, b) in pairs if a is not b and (a in moving or b in moving)]


def test_cartesian_transitions_are_linear_set_points_on_the_wire() -> None:
    rig = run(seam)
    states = {setpoint.state for setpoint in rig.setpoints}
    assert states == {TrajectoryState.IDLE, TrajectoryState.LINEAR}
    assert rig.starts() == []
    assert rig.generator.completed == 3
    at_rest = rig.setpoints[-1].T6_1 @ TOOL
    assert at_rest == approx(POSITIONS["W1"], abs=1e-12)


def test_float32_on_the_wire_changes_nothing_but_rounding() -> None:
    exact, rounded = run(seam), Rig(wire=True)
    rounded.run(20)
    seam(rounded)
    rounded.finish()
    assert np.max(np.abs(np.array(exact.q) - np.array(rounded.q))) < 2e-6


# --- The path ---------------------------------------------------------------------------------


def test_from_rest_and_to_rest_the_tool_stays_on_the_line() -> None:
    rig = Rig()
    rig.run(5)
    start = rig.setpoints[-1].T6_1 @ TOOL
    rig.curve("W1", 1.0, 0.2)
    rig.finish()
    assert off_the_line(tool_points(rig), start, POSITIONS["W1"]) < 2e-11  # twelve digits
    jumps = np.linalg.norm(np.diff(tool_points(rig), axis=0), axis=1)
    length = np.linalg.norm(tool_points(rig)[-1] - tool_points(rig)[0])
    assert np.sum(jumps) == approx(length, rel=1e-9), "it never turns back"


def test_a_joint_transition_to_rest_leaves_the_line_that_a_cartesian_one_keeps() -> None:
    rig = Rig()
    rig.run(5)
    start = rig.setpoints[-1].T6_1 @ TOOL
    rig.move(CARTESIAN, "W1", 1.0, 0.2)
    rig.finish()
    reached = [direct(PUMA_260, (q[0], q[1], q[2], q[3], q[4], q[5])) @ TOOL for q in rig.q]
    points = np.array([(pose.px, pose.py, pose.pz) for pose in reached])
    assert off_the_line(points, start, POSITIONS["W1"]) > 1e-5


@pytest.mark.parametrize("share", [0.5, 0.3])
def test_two_parts_of_one_line_and_turn_are_run_as_one(share: float) -> None:
    """What the parts of a rotation that is too large for one segment rely on."""
    begin = direct(PUMA_260, HOME) @ TOOL
    turn = Transform.rotation((1.0, 2.0, -1.0), 0.9)
    drive = DriveTransform(Transform.translation(0.05, -0.03, 0.02) @ turn)
    rig = Rig()
    rig.run(5)
    duration = 2.0
    for part, length in ((share, share), (1.0, 1.0 - share)):
        there = begin @ drive.at(part)
        times = (duration * length, 0.2)
        goal = FixedGoal(there, TOOL)
        rig.move_to(CARTESIAN, goal, *times, transition=Transition.CARTESIAN)
    rig.finish()
    ticks = round(duration * share / TAU)
    first = next(k for k, point in enumerate(rig.setpoints) if point.sequence == 2)
    across = range(first, first + 120)
    assert [rig.stages[k] for k in across] == [Stage.CURVE] * 80 + [Stage.LINEAR] * 40
    for k in across:
        n = ticks + rig.setpoints[k].n
        expected = begin @ drive.at(n * TAU / duration)
        pose = rig.setpoints[k].T6_1 @ TOOL
        assert pose == approx(tuple(expected), abs=1e-11)


@pytest.mark.parametrize("feed", [0.5, 0.3, 0.05])
def test_the_path_in_space_is_the_same_at_any_feed_rate(feed: float) -> None:
    assert deviation(run(seam, feed=feed), run(seam)) < 1e-7


def test_a_pause_in_a_cartesian_transition_keeps_the_path() -> None:
    nominal, rig = run(seam), Rig()
    rig.run(20)
    seam(rig)
    for at, stage in ((10, Stage.CURVE), (260, Stage.CURVE), (400, Stage.CURVE)):
        rig.run(at)
        rig.generator.pause()
        rig.run(150)
        assert rig.generator.feed == 0.0
        assert rig.stages[-1] in (stage, Stage.LINEAR)
        assert rig.q[-1] == rig.q[-2]
        rig.generator.resume()
    rig.finish()
    assert rig.generator.completed == 3
    assert deviation(rig, nominal) < 1e-7


# --- Late, stopped, refused -------------------------------------------------------------------


@pytest.mark.parametrize("late", [0, 3, 5])
def test_a_late_request_starts_late_on_the_path(late: int) -> None:
    rig = Rig()
    rig.curve("W1", 1.0, 0.2)
    rig.run_to(Stage.LINEAR, 154 + late)
    rig.curve("W2", 1.2, 0.2)
    first = len(rig.q)
    rig.run(30)
    assert rig.setpoints[-1].sequence == 2
    assert rig.difference(2, first, 20) < 8.0
    rig.finish()
    assert rig.generator.completed == 2


def test_a_stop_in_a_cartesian_transition_finishes_it_and_slows_down() -> None:
    rig = Rig()
    seam(rig)
    rig.run_to(Stage.CURVE, 0)
    assert rig.generator.stop() == (1, 2, 3)
    rig.run_to(Stage.STOP)
    assert rig.setpoints[-1].n == 40
    while not rig.generator.stopped:
        rig.tick()
    stood = rig.q[-1]
    pose = direct(PUMA_260, (stood[0], stood[1], stood[2], stood[3], stood[4], stood[5]))
    rig.generator.enable(pose, LEFT_DOWN)
    rig.curve("W1", 1.0, 0.2)
    rig.finish()
    assert rig.difference(2) < 10.0
    assert rig.generator.completed == 4


def test_a_stop_while_a_pause_holds_a_transition_moves_nothing() -> None:
    rig = Rig()
    seam(rig)
    rig.run(10)
    rig.generator.pause()
    rig.run(120)
    assert (rig.stages[-1], rig.generator.feed) == (Stage.CURVE, 0.0)
    stood = rig.q[-1]
    assert rig.generator.stop() == (1, 2, 3)
    assert rig.generator.stopped
    pose = direct(PUMA_260, (stood[0], stood[1], stood[2], stood[3], stood[4], stood[5]))
    rig.generator.enable(pose, LEFT_DOWN)
    rig.run(5)
    assert rig.q[-1] == approx(stood, abs=1e-12)


def test_from_and_into_joint_mode_it_needs_a_plan() -> None:
    rig = Rig()
    rig.move(JOINT, "W1", 1.0, 0.2, transition=Transition.CARTESIAN)
    with pytest.raises(MoveError, match="cannot leave move 1, which is in joint mode"):
        rig.curve("W2", 1.0, 0.2)
    rig.finish()
    rig.curve("W2", 1.0, 0.2)
    with pytest.raises(MoveError, match="cannot lead into move 4, which is in joint mode"):
        rig.move(JOINT, "W1", 1.0, 0.2, transition=Transition.CARTESIAN)
    rig.finish()
    assert rig.generator.completed == 3


# --- Parts of a move --------------------------------------------------------------------------


def part(number: int, name: str, *, last: bool, ticks: int = 200) -> Move:
    goal = FixedGoal(POSITIONS[name], TOOL)
    return Move(number, goal, CARTESIAN, ticks, 40, LEFT_DOWN, Transition.CARTESIAN, last)


def test_a_move_in_parts_is_complete_with_its_last() -> None:
    rig = Rig()
    rig.generator.request(part(1, "W1", last=False), part(1, "W2", last=True))
    assert rig.generator.waiting == 2
    assert rig.generator.last_accepted.move.last
    rig.run_to(Stage.LINEAR)
    assert rig.generator.active_goals == (rig.generator.active_goals[0],)
    rig.run(200)
    assert (rig.generator.waiting, rig.generator.completed) == (0, 0)
    rig.finish()
    assert rig.generator.completed == 1
    pose = rig.setpoints[-1].T6_1 @ TOOL
    assert pose == approx(tuple(POSITIONS["W2"]), abs=1e-12)


def test_a_stop_drops_all_parts_of_a_move_under_one_number() -> None:
    rig = Rig()
    rig.generator.request(part(1, "W1", last=False), part(1, "W2", last=True))
    rig.generator.request(part(2, "W1", last=False), part(2, "W2", last=True))
    rig.run_to(Stage.LINEAR)
    assert rig.generator.stop() == (1, 2)


def test_parts_are_taken_all_or_none() -> None:
    rig = Rig()
    with pytest.raises(MoveError, match="segment time"):
        rig.generator.request(part(1, "W1", last=False), part(1, "W2", last=True, ticks=50))
    with pytest.raises(MoveError, match="must have its number, not 1, 2"):
        rig.generator.request(part(1, "W1", last=False), part(2, "W2", last=True))
    with pytest.raises(MoveError, match="its last part, and no other"):
        rig.generator.request(part(1, "W1", last=True), part(1, "W2", last=True))
    with pytest.raises(MoveError, match="its last part, and no other"):
        rig.generator.request(part(1, "W1", last=False))
    with pytest.raises(MoveError, match="at least one part"):
        rig.generator.request()
    assert rig.generator.waiting == 0
    rig.generator.request(part(1, "W1", last=True))


def test_the_goals_under_way_and_next_are_told() -> None:
    rig = Rig()
    goals = [FixedGoal(POSITIONS[name], TOOL) for name in ("W1", "W2")]
    for goal in goals:
        rig.move_to(JOINT, goal, 1.0, 0.2)
    rig.run_to(Stage.LINEAR)
    assert rig.generator.active_goals == (goals[0],)
    rig.run_to(Stage.PRE)
    assert rig.generator.active_goals == tuple(goals)

"""Cartesian transitions from and into joint mode: T6 blends, the joints go on along their line."""

import itertools
from collections.abc import Callable

import numpy as np
import pytest
from pytest import approx
from support.planning import TOOL, How, Place, PlannedRig, at_angles, at_goal
from support.trajectory import LEFT_DOWN, REST, MovingGoal, WeavingGoal, deviation

from rfms_can.arm import PUMA_260
from rfms_can.errors import KinematicsError, MoveError
from rfms_can.kinematics import Joints, direct
from rfms_can.master.trajectory.goal import Goal
from rfms_can.master.trajectory.segment import Transition
from rfms_can.master.trajectory.states import Stage
from rfms_can.setpoint import JointSetpoint
from rfms_can.wire.vocabulary import Mode, TrajectoryState

JOINT, STRAIGHT = Mode.JOINT, Mode.CARTESIAN
A: Joints = (0.45, 1.3, -2.6, 0.5, 1.2, 0.1)
B: Joints = (0.1, 1.15, -2.75, 0.1, 0.9, -0.5)
Program = Callable[[PlannedRig], None]


def how(mode: Mode, transition: Transition = Transition.CARTESIAN, time: float = 1.0) -> How:
    return How(mode, 0.2, time, transition=transition)


def moving(q: Joints, period_s: float) -> Place:
    pose = direct(PUMA_260, q) @ TOOL
    goal: Goal = MovingGoal(pose, (-0.008, 0.004, -0.006), period_s)
    return at_goal(goal)


def weaving(q: Joints) -> Place:
    return at_goal(WeavingGoal(direct(PUMA_260, q) @ TOOL))


def in_turn(rig: PlannedRig) -> None:
    """Joint to straight, straight to joint, joint to joint, to rest."""
    for q, mode in ((A, JOINT), (B, STRAIGHT), (A, JOINT), (REST, JOINT), (B, STRAIGHT)):
        rig.go(at_angles(q), how(mode))


def to_goals_that_move(rig: PlannedRig) -> None:
    rig.go(moving(A, rig.period_s), how(JOINT))
    rig.go(moving(B, rig.period_s), how(STRAIGHT))
    rig.go(moving(A, rig.period_s), how(JOINT))
    rig.go(at_angles(REST), how(JOINT))


def among_joint_transitions(rig: PlannedRig) -> None:
    rig.go(at_angles(A), how(STRAIGHT, Transition.JOINT))
    rig.go(at_angles(B), how(JOINT))
    rig.go(at_angles(A), how(JOINT, Transition.JOINT))
    rig.go(at_angles(REST), how(STRAIGHT))
    rig.go(at_angles(A), how(JOINT))
    rig.go(at_angles(B), how(STRAIGHT, Transition.JOINT))


def along_functions_of_h_and_t(rig: PlannedRig) -> None:
    rig.go(weaving(A), how(STRAIGHT))
    rig.go(weaving(B), how(JOINT))
    rig.go(weaving(A), how(JOINT))
    rig.go(at_angles(REST), how(JOINT, Transition.JOINT))


PROGRAMS = [in_turn, to_goals_that_move, among_joint_transitions, along_functions_of_h_and_t]


def run(
    program: Program, period_s: float = 0.005, feed: float = 1.0, *, wire: bool = False
) -> PlannedRig:
    rig = PlannedRig(period_s=period_s)
    rig.wire = wire
    rig.run(20)
    rig.generator.set_feed(feed)
    program(rig)
    rig.finish(50000)
    return rig


def changes(rig: PlannedRig) -> list[int]:
    """Ticks at which a transition begins or ends."""
    moving = (Stage.START, Stage.CURVE, Stage.BLEND, Stage.REJOIN)
    pairs = enumerate(itertools.pairwise(rig.stages), 1)
    return [k for k, (a, b) in pairs if a is not b and (a in moving or b in moving)]


@pytest.mark.parametrize("program", PROGRAMS)
def test_it_is_continuous_up_to_jerk(program: Program) -> None:
    coarse, fine = run(program, 0.005), run(program, 0.0025)
    print(coarse.difference(4), fine.difference(4))
    for a, b in zip(changes(coarse), changes(fine), strict=True):
        print(
            coarse.stages[a - 1].name,
            coarse.stages[a].name,
            coarse.difference(4, a),
            fine.difference(4, b),
            fine.difference(4, b) / coarse.difference(4, a),
        )
    assert fine.difference(4) < 1.2 * coarse.difference(4)
    for a, b in zip(changes(coarse), changes(fine), strict=True):
        assert fine.difference(4, b) < 1.5 * coarse.difference(4, a)


def reached(rig: PlannedRig) -> Joints:
    j1, j2, j3, j4, j5, j6 = rig.q[-1]
    return (j1, j2, j3, j4, j5, j6)


def test_it_ends_where_it_was_told_and_runs_along_the_joint_line() -> None:
    rig = run(in_turn)
    assert rig.generator.completed == 5
    assert reached(rig) == approx(B, abs=1e-9)
    third = [k for k, setpoint in enumerate(rig.setpoints) if setpoint.sequence == 3]
    even = [k for k in third if rig.stages[k] is Stage.LINEAR]
    assert len(even) > 100
    for k in even:
        r = rig.setpoints[k].r
        line = [c + r * (b - c) for b, c in zip(B, A, strict=True)]
        assert rig.q[k] == approx(line, abs=1e-9)


def test_on_the_wire_the_line_is_told_by_start_at_the_end_of_the_transition() -> None:
    rig = run(in_turn)
    told = [k for k, stage in enumerate(rig.stages) if stage is Stage.REJOIN]
    assert len(told) == 2
    for k in told:
        states = [setpoint.state for setpoint in rig.setpoints[k - 1 : k + 5]]
        assert states == [
            TrajectoryState.LINEAR,
            TrajectoryState.START,
            *[TrajectoryState.BLEND] * 3,
            TrajectoryState.LINEAR,
        ]
        assert [setpoint.p for setpoint in rig.setpoints[k - 1 : k + 5]] == [1.0] * 5 + [0.0]
        assert rig.setpoints[k - 1].mode is STRAIGHT
        assert {setpoint.mode for setpoint in rig.setpoints[k : k + 5]} == {JOINT}


@pytest.mark.parametrize("program", PROGRAMS)
def test_float32_on_the_wire_changes_nothing_but_rounding(program: Program) -> None:
    exact, rounded = run(program), run(program, wire=True)
    assert np.max(np.abs(np.array(exact.q) - np.array(rounded.q))) < 2e-5


@pytest.mark.parametrize("feed", [0.5, 0.3, 0.05])
def test_the_path_is_the_same_at_any_feed_rate(feed: float) -> None:
    assert deviation(run(in_turn, feed=feed), run(in_turn)) < 1e-7


@pytest.mark.parametrize("at", [150, 190, 214, 224, 232, 280])
def test_a_pause_about_a_transition_keeps_the_path(at: int) -> None:
    nominal, rig = run(in_turn), PlannedRig()
    rig.run(20)
    in_turn(rig)
    rig.run(at)
    rig.generator.pause()
    rig.run(250)
    assert rig.generator.feed == 0.0
    assert rig.q[-1] == approx(rig.q[-2], abs=1e-12)
    rig.generator.resume()
    rig.finish()
    assert rig.generator.completed == 5
    assert deviation(rig, nominal) < 1e-7


@pytest.mark.parametrize("at", [395, 430, 473, 474, 476, 520])
def test_a_stop_about_a_transition_ends_on_the_path_and_goes_on(at: int) -> None:
    rig = PlannedRig()
    rig.run(20)
    in_turn(rig)
    rig.run(at)
    rig.generator.stop()
    while not rig.generator.stopped:
        rig.tick()
    assert rig.setpoints[-1].h <= 1.0
    stood = reached(rig)
    rig.generator.enable(direct(PUMA_260, stood), LEFT_DOWN)
    rig.planner.reset(stood)
    rig.go(at_angles(REST), how(JOINT))
    rig.finish()
    assert rig.difference(2) < 12.0
    assert reached(rig) == approx(REST, abs=1e-9)


def test_from_rest_into_joint_mode_the_joints_blend_and_from_it_to_rest() -> None:
    rigs = []
    for transition in Transition:
        rig = PlannedRig()
        rig.run(5)
        rig.go(at_angles(A), how(JOINT, transition))
        rig.finish()
        rigs.append(rig)
    assert rigs[0].q == rigs[1].q


def test_the_joints_stop_for_want_of_a_set_point_if_start_is_lost() -> None:
    """Before one comes that they would take for another angle."""
    rig = run(in_turn)
    told = rig.stages.index(Stage.REJOIN)
    joints = [JointSetpoint(rig.period_s, theta) for theta in REST]
    refused = 0
    for k, setpoint in enumerate(rig.setpoints[: told + 5]):
        if k == told:
            for joint in joints:
                joint.miss()
            continue
        angles = [
            joint.tick(setpoint, solver.solve)
            for joint, solver in zip(joints, rig.solvers, strict=True)
        ]
        refused += k < told + 4 and all(np.isnan(angles))
    assert refused == 3, "one is lost, and three in a row make a joint stop"


def test_a_joint_on_another_turn_than_its_goal_goes_on_from_where_it_is() -> None:
    """In joint mode the base is the goal's solution, which may be more than half a turn away."""
    far = (0.2, 1.2, -2.7, 0.3, 1.0, 3.9)
    rig = PlannedRig((0.2, 1.2, -2.7, 0.3, 1.0, -2.9))
    for name, q, mode in (("half", (*A[:5], 0.0), JOINT), ("far", far, STRAIGHT)):
        del name
        rig.go(at_angles(q), How(mode, 0.2, 3.0, transition=Transition.CARTESIAN))
    rig.finish()
    assert rig.difference(2) < 20.0


def flip(theta5: float) -> Place:
    """Near A, with the wrist on the other side."""
    other = at_angles((*A[:4], theta5, A[5]))
    return other._replace(configuration=LEFT_DOWN._replace(noflip=theta5 > 0.0))


def test_a_configuration_may_change_on_the_line_and_not_within_the_transition() -> None:
    rig = PlannedRig()
    rig.go(flip(0.9), how(STRAIGHT))
    rig.go(flip(-0.9), how(JOINT))
    rig.finish()
    assert reached(rig) == approx((*A[:4], -0.9, A[5]), abs=1e-9)
    assert rig.difference(2) < 20.0
    rig = PlannedRig()
    rig.go(flip(0.05), how(JOINT))
    with pytest.raises(
        KinematicsError,
        match=r"move 2: joint . .* Cartesian transition from move 1"
        r".*; use a joint transition, or accelerate in less time",
    ):
        rig.plan(flip(-0.9), how(JOINT))
    rig.go(flip(-0.9), how(JOINT, Transition.JOINT))


def test_a_joint_mode_move_that_was_not_planned_cannot_blend_in_space() -> None:
    rig = PlannedRig()
    rig.move(JOINT, "W1", 1.0, 0.2)
    with pytest.raises(MoveError, match="cannot leave move 1, which is in joint mode and was not"):
        rig.curve("W2", 1.0, 0.2)


@pytest.mark.parametrize("seed", range(12))
def test_random_programs_of_all_kinds_run_evenly_to_their_ends(seed: int) -> None:
    draw = np.random.default_rng(seed)
    rig = PlannedRig()
    rig.wire = bool(draw.integers(2))
    rig.run(12)
    bounds = [None, 0.001, 0.005]
    for _ in range(int(draw.integers(2, 6))):
        swing = draw.uniform(-1.0, 1.0, 6) * (0.3, 0.2, 0.2, 0.3, 0.3, 0.3)
        q1, q2, q3, q4, q5, q6 = (np.array(REST) + swing).tolist()
        last = (q1, q2, q3, q4, q5, q6)
        place = [at_angles(last), weaving(last)][draw.choice(2, p=(0.75, 0.25))]
        plan = rig.plan(
            place,
            How(
                list(Mode)[draw.integers(2)],
                draw.uniform(0.1, 0.3),
                draw.uniform(0.6, 1.2),
                transition=list(Transition)[draw.integers(2)],
                deviation=bounds[draw.integers(3) % len(bounds)],
                lengthen=True,
            ),
        )
        rig.generator.request(*plan.moves)
        rig.plans.append(plan)
        # What weaves by 2 mm while a path leaves it is not passed within 1 mm.
        bounds = [None, 0.001, 0.005] if place.goal.constant else [None]
        rig.run(int(draw.integers(0, 240) * draw.integers(2)))
        if draw.random() < 0.2:
            rig.generator.pause()
            rig.run(int(draw.integers(1, 250)))
            rig.generator.resume()
    rig.finish(20000)
    assert rig.generator.completed == len(rig.plans)
    assert np.isfinite(rig.q).all()
    assert np.all(rig.peaks(1)[1] <= 1.4 * np.array(PUMA_260.acceleration_limits))
    if place.goal.constant:
        assert reached(rig) == approx(last, abs=2e-5)

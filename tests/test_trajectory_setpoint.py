"""One joint's half of the generator: turns, refusals, missing set-points."""

import itertools
import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx
from support.trajectory import LEFT_DOWN, TAU, Rig

from rfms_can.kinematics import nearest_turn
from rfms_can.master.trajectory.states import Stage
from rfms_can.setpoint import FOLLOWS, JointSetpoint
from rfms_can.setpoint.blend import blend_parameter
from rfms_can.setpoint.cartesian import CartesianSetpoint
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Blend, Mode, TrajectoryState

IDLE, LINEAR, PRE, START, BLEND = (
    TrajectoryState.IDLE,
    TrajectoryState.LINEAR,
    TrajectoryState.PRE,
    TrajectoryState.START,
    TrajectoryState.BLEND,
)
HERE = Transform.identity()


def setpoint(
    state: TrajectoryState, *, r: float = 0.0, p: float = 0.0, second: bool = False
) -> CartesianSetpoint:
    """A set-point whose poses do not matter: solutions are given beside it."""
    return CartesianSetpoint(
        *(state, Mode.JOINT, Blend.CONTINUOUS, r, p, 0.1, HERE, LEFT_DOWN),
        *(HERE if second else None, LEFT_DOWN),
    )


def along(n: int, segment_ticks: int) -> CartesianSetpoint:
    """A joint segment of ``segment_ticks`` at local tick ``n``; t_acc is 20 ticks."""
    if n > 20:
        return setpoint(LINEAR, r=1.0 - n / segment_ticks)
    p = (n + 20) / 40
    return setpoint(BLEND, r=1.0 - blend_parameter(p) * 20 / segment_ticks, p=p)


def everything(joint: JointSetpoint) -> list[object]:
    """The state of ``joint``, down to the samples it remembers."""
    return [
        list(value._samples) if hasattr(value, "_samples") else value
        for value in (getattr(joint, name) for name in JointSetpoint.__slots__)
    ]


def at_goal(theta: float) -> JointSetpoint:
    joint = JointSetpoint(TAU, theta)
    joint.advance(setpoint(IDLE), theta)
    return joint


# --- Starting from the encoder ----------------------------------------------------------------


def test_the_first_set_point_is_no_velocity() -> None:
    """Appendix C starts from thold = 0: 200 rad/s where the joint stands at 1 rad."""
    joint = JointSetpoint(TAU, 1.0)
    assert joint.advance(setpoint(IDLE, second=True), 1.0 + 1e-7, 0.5) == 1.0 + 1e-7
    assert joint.rate == joint.acceleration == 0.0
    assert joint.advance(setpoint(START, r=1.0, second=True), 1.0 + 1e-7, 0.5) == 1.0 + 1e-7


@pytest.mark.parametrize("blend", Blend)
def test_a_move_on_the_very_first_tick_starts_from_the_encoder(blend: Blend) -> None:
    joint = JointSetpoint(TAU, 1.0)
    first = setpoint(START, r=1.0, second=True)._replace(blend=blend)
    assert joint.advance(first, 1.0, 2.0) == approx(1.0)
    assert joint.rate == approx(0.0)
    peak = max(
        abs(joint.advance(setpoint(BLEND, r=1.0, p=n / 40)._replace(blend=blend), 2.0) - 1.0)
        for n in range(1, 41)
    )
    assert peak < 1e-9


# --- Turns ------------------------------------------------------------------------------------


def test_solutions_continue_the_turn_they_were_on() -> None:
    """A wrist joint that passes 180 degrees, and the arc tangent that wraps there."""
    joint = at_goal(3.0)
    for k in range(1, 100):
        wrapped = math.remainder(3.0 + 0.005 * k, math.tau)
        solution = nearest_turn(wrapped, joint.turn_1(setpoint(IDLE)), -5.0, 5.0)
        assert joint.advance(setpoint(IDLE), solution) == approx(3.0 + 0.005 * k)


def test_a_goal_keeps_its_turn_while_the_joint_goes_the_long_way_round() -> None:
    """From 150 to -150 degrees with stops at +-160: 300 degrees back, not 60 ahead."""
    limits = (math.radians(-160.0), math.radians(160.0))
    start, goal = math.radians(150.0), math.radians(-150.0)
    joint = at_goal(start)

    def solve(angle: float, turn: float) -> float:
        return nearest_turn(angle, turn, *limits)

    first = setpoint(IDLE, second=True)
    joint.advance(first, solve(start, joint.turn_1(first)), solve(goal, joint.turn_2))
    begin = setpoint(START, r=1.0, second=True)
    joint.advance(begin, solve(start, joint.turn_1(begin)), solve(goal, joint.turn_2))
    angles = []
    for n in range(-19, 201):
        following = along(n, 200)
        angles.append(joint.advance(following, solve(goal, joint.turn_1(following))))
    assert angles[119] == approx(0.0, abs=1e-9)
    assert angles[-1] == approx(goal)
    assert all(-0.03 < b - a < 0.0 for a, b in itertools.pairwise(angles))


def test_a_goal_keeps_its_turn_while_the_joint_runs_away_from_it() -> None:
    """A wrist joint of +-310 degrees, the goal 2.88 rad ahead of it when the move begins.

    The joint still runs backwards, so that the same goal is soon nearer by the other way.
    """

    def solve(angle: float, turn: float) -> float:
        return nearest_turn(math.remainder(angle, math.tau), turn, -5.4, 5.4)

    joint = JointSetpoint(TAU, 0.2)
    for k in range(20):
        followed = setpoint(IDLE, second=k == 19)
        joint.advance(followed, 0.2 - 0.01 * k, solve(3.08, joint.turn_2))
    begin = setpoint(START, r=1.0, second=True)
    joint.advance(begin, solve(0.0, joint.turn_1(begin)), solve(3.08, joint.turn_2))
    angles = [joint.theta]
    for n in range(-19, 201):
        following = along(n, 200)
        angles.append(joint.advance(following, solve(3.08, joint.turn_1(following))))
        assert joint.turn_2 == joint.turn_1(following) == approx(3.08)
    assert min(angles) < 3.08 - math.pi
    assert angles[-1] == approx(3.08)
    assert all(abs(b - a) < 0.03 for a, b in itertools.pairwise(angles))


# --- What a transition takes over -------------------------------------------------------------


def jerk(k: int) -> float:
    """An angle with a jerk of 120 rad/s3 and, at k = 0, no velocity or acceleration."""
    return 20.0 * (k * TAU) ** 3


@pytest.mark.parametrize(("left", "entered"), [(jerk, None), (None, jerk), (jerk, jerk)])
def test_a_transition_takes_over_the_jerk_of_either_side(
    left: Callable[[int], float] | None, entered: Callable[[int], float] | None
) -> None:
    old = left or (lambda k: 0.0)
    new = entered or (lambda k: 0.0)
    joint = JointSetpoint(TAU, old(-20))
    angles = [joint.advance(setpoint(IDLE, second=True), old(k), new(k)) for k in range(-20, 0)]
    angles.append(joint.advance(setpoint(START, r=1.0, second=True), 0.0, new(0)))
    for k in range(1, 4):  # h is still zero to six digits
        angles.append(joint.advance(setpoint(BLEND, r=1.0, p=k / 40), new(k)))
    third = np.diff(angles, 3) / TAU**3
    assert np.max(np.abs(np.diff(third[-6:]))) < 60.0  # a step of 120 would be 80 in one tick


# --- Refusals ---------------------------------------------------------------------------------


@given(st.sampled_from(TrajectoryState), st.sampled_from([math.nan, math.inf, -math.inf]))
def test_a_set_point_without_solution_changes_nothing(state: TrajectoryState, bad: float) -> None:
    joint = at_goal(0.5)
    before = everything(joint)
    for solutions in ((bad, 0.5), (0.5, bad)):
        assert math.isnan(joint.advance(setpoint(state, second=True), *solutions))
        assert everything(joint) == before


@pytest.mark.parametrize("state", TrajectoryState)
@pytest.mark.parametrize("last", TrajectoryState)
def test_a_state_that_cannot_follow_is_refused(
    last: TrajectoryState, state: TrajectoryState
) -> None:
    joint = at_goal(0.5)
    route = {
        IDLE: [],
        START: [START],
        BLEND: [START, BLEND],
        LINEAR: [START, BLEND, LINEAR],
        PRE: [START, BLEND, PRE],
    }[last]
    for step in route:
        assert joint.advance(setpoint(step, second=True), 0.5, 0.5) == approx(0.5)
    before = everything(joint)
    theta = joint.advance(setpoint(state, second=True), 0.5, 0.5)
    if last in FOLLOWS[state] and (last, state) != (IDLE, LINEAR):
        assert theta == approx(0.5)
    else:
        assert math.isnan(theta)
        assert everything(joint) == before


@pytest.mark.parametrize(("mode", "p"), list(itertools.product(Mode, (0.0, 0.1))))
def test_straight_from_rest_only_a_cartesian_transition_begins(mode: Mode, p: float) -> None:
    joint = at_goal(0.5)
    theta = joint.advance(setpoint(LINEAR, r=0.9, p=p)._replace(mode=mode), 0.6)
    if mode is Mode.CARTESIAN and p:
        assert theta == 0.6
    else:
        assert math.isnan(theta)


def test_a_joint_move_whose_goal_was_lost_is_refused() -> None:
    joint = at_goal(0.5)
    before = everything(joint)
    assert math.isnan(joint.advance(setpoint(START, r=1.0), 0.5))
    assert everything(joint) == before


# --- Missing set-points -----------------------------------------------------------------------


@pytest.mark.parametrize("blend", Blend)
@pytest.mark.parametrize("mode", Mode)
@pytest.mark.parametrize("lost", [1, 2])
def test_set_points_missed_before_a_hand_over_do_not_shake_it(
    mode: Mode, lost: int, blend: Blend
) -> None:
    """The set-point is held, the histories are not: the transition starts with the true rate."""
    rigs = Rig(blend), Rig(blend)
    for rig in rigs:
        rig.move(mode, "W1", 1.0, 0.2)
        rig.move(Mode.JOINT, "W2", 1.0, 0.2)
        rig.run(200 - lost)
    whole, holed = rigs
    for _ in range(lost):
        whole.tick()
        holed.generator.tick()
        held = [joint.theta for joint in holed.joints]
        assert [joint.miss() for joint in holed.joints] == held
    for _ in range(83):
        assert holed.tick() == approx(whole.tick(), abs=5e-5)
        assert [joint.rate for joint in holed.joints] == approx(
            [joint.rate for joint in whole.joints], abs=5e-3
        )
    assert whole.starts() == [1, 201]


def test_set_points_missed_while_a_moving_goal_is_watched_do_not_shake_the_transition() -> None:
    rigs = Rig(), Rig()
    for rig in rigs:
        rig.move(Mode.JOINT, "W1", 1.0, 0.2)
        rig.move(Mode.JOINT, "W2", 1.0, 0.2, (-0.05, -0.03, -0.03))
        rig.run_to(Stage.PRE)
        rig.run(5)
    whole, holed = rigs
    for _ in range(2):
        whole.tick()
        holed.generator.tick()
        for joint in holed.joints:
            joint.miss()
    for _ in range(90):
        assert holed.tick() == approx(whole.tick(), abs=2e-5)


def test_a_lost_start_is_noticed_at_the_next_set_point() -> None:
    rig = Rig()
    rig.move(Mode.JOINT, "W1", 1.0, 0.2)
    rig.run(1)
    rig.generator.tick()
    for joint in rig.joints:
        joint.miss()
    assert all(math.isnan(theta) for theta in rig.tick())

"""The master verifies: commanded against MEASURE, MEASURE against ERROR; what may be, may be."""

import numpy as np
import pytest
from support.fleet import Fleet

from rfms_can.arm import ARMS, PUMA_260, PUMA_560
from rfms_can.joint_nodes.joint import JointNode
from rfms_can.kinematics import JointSolver
from rfms_can.master.phases import Phase
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.master.verification import (
    AGREEMENT,
    COMPLYING_FACTOR,
    CYCLES,
    LEAST,
    MOST,
    Verification,
    following_bounds,
)
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import JointError, Measure, Setpoint
from rfms_can.wire.vocabulary import NodeState, Parameter

PARAMETERS = all_parameters(PUMA_560, "corke", 0.004)
AT = (0.3, -0.4, 0.5, 0.1, 0.7, -0.2)
ZERO = (0.0,) * 6
ALL = 0b111111


def only(joint: int, value: float) -> tuple[float, ...]:
    return tuple(value * (k == joint) for k in JOINTS)


def less(a: tuple[float, ...], b: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(x - y for x, y in zip(a, b, strict=True))


@pytest.fixture
def verification() -> Verification:
    return Verification(PARAMETERS)


# --- bounds --------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ARMS)
def test_bounds_are_half_of_what_a_joint_can_do_within_two_limits(name: str) -> None:
    parameters = all_parameters(ARMS[name], "corke", 0.004)
    for joint, bound in zip(JOINTS, following_bounds(parameters, modelled=True), strict=True):
        p = parameters[joint]
        half = 0.5 * p[Parameter.TORQUE_LIMIT] / p[Parameter.KP]
        assert bound == pytest.approx(min(MOST, max(LEAST, half)))
        assert 2.0 * bound <= p[Parameter.FOLLOWING_ERROR_LIMIT] + 1e-6


def test_without_a_model_a_soft_servo_has_wider_bounds() -> None:
    soft = all_parameters(PUMA_560, "corke", 0.02)
    with_model, without = (following_bounds(soft, modelled=known) for known in (True, False))
    factor = (30.0 / soft[1][Parameter.NATURAL_FREQUENCY]) ** 2
    assert max(with_model) <= MOST
    assert min(without) >= LEAST * factor * (1.0 - 1e-6)
    stiff = following_bounds(PARAMETERS, modelled=False)
    assert stiff == following_bounds(PARAMETERS, modelled=True)


def test_one_bound_may_be_asked_for() -> None:
    assert Verification(PARAMETERS, largest=0.05).bounds == (0.05,) * 6


# --- one cycle after the other -------------------------------------------------------------------


@pytest.mark.parametrize("joint", JOINTS)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_joint_beyond_its_bound_for_three_cycles_does_not_follow(
    verification: Verification, joint: int, sign: float
) -> None:
    off = only(joint, sign * 1.01 * verification.bounds[joint - 1])
    for _ in range(CYCLES - 1):
        assert verification.check(AT, None, less(AT, off), off) is None
    reason = verification.check(AT, None, less(AT, off), off)
    assert reason is not None
    assert reason.words.startswith(f"joint {joint} does not follow: MEASURE_{joint} is ")
    assert f"{AT[joint - 1]:.6f} rad was commanded" in reason.words
    assert f"{off[joint - 1]:.4f} rad, bound {verification.bounds[joint - 1]:g} rad" in reason.words


def test_just_inside_its_bound_it_goes_on(verification: Verification) -> None:
    off = tuple(0.99 * bound for bound in verification.bounds)
    assert all(verification.check(AT, None, less(AT, off), off) is None for _ in range(50))


def test_two_cycles_and_a_good_one_are_forgiven(verification: Verification) -> None:
    off = only(2, 0.5)
    for _ in range(20):
        for _ in range(CYCLES - 1):
            assert verification.check(AT, None, less(AT, off), off) is None
        assert verification.check(AT, None, AT, ZERO) is None


@pytest.mark.parametrize("joint", JOINTS)
def test_an_error_that_is_not_that_of_the_encoder_is_told(
    verification: Verification, joint: int
) -> None:
    off = only(joint, 3.0 * AGREEMENT)
    for _ in range(CYCLES - 1):
        assert verification.check(AT, None, less(AT, off), ZERO) is None
    reason = verification.check(AT, None, less(AT, off), ZERO)
    assert reason is not None
    assert reason.words.startswith(f"joint {joint}: ERROR_{joint} tells 0.000000 rad, but MEASURE_")
    assert "another set-point" in reason.words
    assert (reason.culprit.sender, reason.culprit.frame) == (f"joint {joint}", f"ERROR_{joint}")
    assert reason.culprit.bound == AGREEMENT


def test_what_several_joints_tell_at_once_is_the_set_points_doing(
    verification: Verification,
) -> None:
    off = tuple(3.0 * AGREEMENT if joint in (2, 5) else 0.0 for joint in JOINTS)
    for _ in range(CYCLES):
        reason = verification.check(AT, None, less(AT, off), ZERO, cycle=7)
    assert reason is not None
    assert reason.words.startswith("master: SETPOINT_1 is another one for joint 2 and 1 more")
    assert (reason.culprit.sender, reason.culprit.frame) == ("master", "SETPOINT_1")
    assert reason.culprit.cycle == 7


@pytest.mark.parametrize(("altered", "sender"), [(0, "joint 1"), (2, "master")])
def test_one_joint_is_not_to_blame_for_a_set_point_that_went_out_altered(
    verification: Verification, altered: int, sender: str
) -> None:
    off = only(1, 3.0 * AGREEMENT)
    verification.check(AT, None, AT, ZERO, altered=2)  # long ago: that set-point did no harm
    for number in range(CYCLES):
        seen = 2 + min(altered, number + 1)
        reason = verification.check(AT, None, less(AT, off), ZERO, altered=seen)
    assert reason is not None and reason.culprit.sender == sender


def test_the_displacement_of_comply_belongs_to_what_was_commanded(
    verification: Verification,
) -> None:
    shift = (0.2, -0.1, 0.3, 0.05, 0.5, 0.1)
    measured = less(AT, tuple(-x for x in shift))
    assert all(verification.check(AT, shift, measured, ZERO) is None for _ in range(10))
    for _ in range(CYCLES):
        reason = verification.check(AT, None, measured, ZERO)
    assert reason is not None


def test_what_was_not_heard_is_not_judged(verification: Verification) -> None:
    stale = only(4, 0.2)
    for _ in range(20):
        assert verification.check(AT, None, less(AT, stale), ZERO, ALL & ~0b1000) is None


def test_after_a_cycle_without_error_a_transition_may_differ_a_little_until_rest(
    verification: Verification,
) -> None:
    slightly = only(3, 0.001)
    verification.check(AT, None, AT, ZERO, ALL & ~0b100)
    for _ in range(20):
        assert verification.check(AT, None, less(AT, slightly), ZERO) is None
    verification.rested()
    reasons = [verification.check(AT, None, less(AT, slightly), ZERO) for _ in range(CYCLES)]
    assert reasons[-1] is not None and reasons[-1].words.startswith("joint 3: ERROR_3")


def test_no_doubt_covers_more_than_a_cycle_at_the_speed_limit(verification: Verification) -> None:
    far = only(3, 1.1 * PARAMETERS[3][Parameter.SPEED_LIMIT] * 0.004)
    verification.check(AT, None, AT, ZERO, ALL & ~0b100)
    for _ in range(CYCLES):
        reason = verification.check(AT, None, less(AT, far), ZERO)
    assert reason is not None


# --- compliance ----------------------------------------------------------------------------------


def test_while_it_complies_only_what_is_held_is_bounded(verification: Verification) -> None:
    """Joint 5 is let go, the others are held."""
    held = np.diag([1.0, 1.0, 1.0, 1.0, 0.0, 1.0])
    off = only(5, 0.6)
    for _ in range(20):
        assert verification.check(AT, None, less(AT, off), off, ALL, held) is None
    off = only(3, 1.01 * COMPLYING_FACTOR * verification.bounds[2])
    for _ in range(CYCLES):
        reason = verification.check(AT, None, less(AT, off), off, ALL, held)
    assert reason is not None
    assert reason.words.startswith("joint 3 does not follow")
    assert "held part off by" in reason.words


def test_a_law_that_parts_no_directions_bounds_nothing_while_it_complies() -> None:
    verification = Verification(PARAMETERS, parts_directions=False)
    off = only(3, 0.5)
    for _ in range(20):
        assert verification.check(AT, None, less(AT, off), off, ALL, np.eye(6)) is None
    for _ in range(CYCLES):
        reason = verification.check(AT, None, less(AT, off), ZERO, ALL, np.eye(6))
    assert (
        reason is not None and "ERROR_3 tells" in reason.words
    )  # what it says is held to all the same


# --- with nodes ----------------------------------------------------------------------------------


def test_lost_set_points_and_samples_in_motion_make_no_joint_a_liar(wire: Wire) -> None:
    """Each of three messages is lost now and then while the arm goes through transitions."""
    for record, node in ((Setpoint, 1), (Measure, 3), (JointError, 3)):
        fleet = Fleet(wire).enable()
        identifier = fleet.id(record, node)
        seen = [0]

        def now_and_then(frame: object, receiver: object, seen: list[int] = seen) -> bool:
            if getattr(frame, "id", None) != identifier or receiver is fleet.pump.nodes[0]:  # noqa: B023
                return False
            seen[0] += 1
            return seen[0] % 101 == 0

        fleet.pump.lose(now_and_then)
        for k in range(4):
            fleet.move((0.1 * (-1) ** k, 0.05, -0.1, 0.2, 0.1, -0.2), 0.6)
        fleet.run(700)
        fault = fleet.master.fault or ""  # a joint that misses START cannot go on by itself
        assert "tells" not in fault and "follow" not in fault, fault
        assert fleet.master.statistics.incomplete > 2


def test_a_wrong_solution_is_found_in_motion_and_a_reset_does_not_hide_it(
    wire: Wire, monkeypatch: pytest.MonkeyPatch
) -> None:
    fleet = Fleet(wire).enable()
    controller = fleet.joints[2].controller
    assert controller is not None
    form = controller._solver._form
    assert isinstance(form, JointSolver)
    solve = controller._solver.solve
    monkeypatch.setattr(controller._solver, "solve", lambda *way: 1.02 * solve(*way))
    fleet.move((0.0, 0.0, 0.1, 0.0, 0.0, 0.0), 0.4)
    reason = fleet.halted()
    assert reason.startswith(("joint 3: ERROR_3 tells", "joint 3: SETPOINT_STEP"))
    assert fleet.joints[2].state is NodeState.QUICKSTOP
    assert fleet.master.phase is Phase.HALT


# --- homing that does not end --------------------------------------------------------------------


def tells_homing(monkeypatch: pytest.MonkeyPatch, node: JointNode) -> None:
    """From now on its HEARTBEAT does not say that it is READY."""
    monkeypatch.setattr(
        node, "_announce", lambda: node._beat(NodeState.HOMING, 0, node.config_hash)
    )


def test_a_joint_that_never_tells_ready_is_named_when_the_time_is_over(
    wire: Wire, monkeypatch: pytest.MonkeyPatch
) -> None:
    fleet = Fleet(wire)
    fleet.reach(Phase.HOME)
    tells_homing(monkeypatch, fleet.joints[2])
    reason = fleet.halted()
    limit = fleet.master.bring_up.homing_cycles
    assert reason.startswith(f"not READY after {limit} cycles of homing: joint 3 (HOMING)")
    parameters = all_parameters(PUMA_260, "corke", 0.004)
    longest = max(p[Parameter.HOMING_TIME] for p in parameters.values())
    assert limit * 0.004 == pytest.approx(1.5 * longest, abs=0.1)


def test_a_master_that_finds_no_index_names_the_joint(
    wire: Wire, monkeypatch: pytest.MonkeyPatch
) -> None:
    fleet = Fleet(wire)
    fleet.reach(Phase.HOME)
    monkeypatch.setattr(fleet.master.arm_state, "reference", lambda _joint, _reference: None)
    assert "joint 1 (no index in REFERENCE_1), joint 2 (no index" in fleet.halted()


def test_a_reset_does_not_wait_for_ever(wire: Wire, monkeypatch: pytest.MonkeyPatch) -> None:
    fleet = Fleet(wire).enable()
    fleet.master.lose("a test")
    fleet.run(200)
    fleet.master.reset()
    fleet.reach(Phase.HOME)
    tells_homing(monkeypatch, fleet.joints[4])
    assert "cycles of homing: joint 5 (HOMING)" in fleet.halted()

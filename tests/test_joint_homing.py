"""Homing: the encoder's zero from index pulse and coarse position, to the count."""

import math
from itertools import pairwise

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from support.joint_bench import JointBench

from rfms_can.arm import ARMS, Arm
from rfms_can.joint_nodes.homing import Homing
from rfms_can.joint_nodes.servo import Servo
from rfms_can.master.arm_state import ArmState
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.node.encoder_reference import AMBIGUITY, EncoderReference
from rfms_can.plant.board import Board
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import Measure, Reference
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState, Parameter

PERIOD_S = 0.004
PARAMETERS = {name: all_parameters(arm, "corke", PERIOD_S) for name, arm in ARMS.items()}

arms = st.sampled_from(sorted(ARMS))
joints = st.sampled_from(JOINTS)
parts = st.floats(0.0, 1.0)
"""Where a joint powers up, as a part of its range."""


def angle_at(arm: Arm, joint: int, part: float) -> float:
    lower, upper = arm.joint_limits[joint - 1]
    return lower + part * (upper - lower)


def true_zero_counts(arm: Arm, joint: int, power_up: float) -> int:
    """What the board counts at joint angle 0, when it counts from power-up."""
    return -math.floor(power_up * arm.drives[joint - 1].counts_per_radian + 0.5)


class Bench:
    """One real board that is moved by hand, and frames of it as the plant would send them."""

    def __init__(self, arm: Arm, joint: int, power_up: float) -> None:
        self.board = Board(arm, joint - 1, power_up)
        self.q = power_up

    def frames(self, q: float) -> tuple[Measure, Reference]:
        self.q = q
        self.board.observe(q, 0.0)
        counts, current, speed, seen = self.board.sample()
        latched = self.board.latched_index_counts
        reference = Reference(self.board.coarse(q), latched or 0, int(latched is not None), 0)
        return Measure(counts, current, speed, 0, int(seen), 0), reference


@settings(max_examples=300)
@given(arms, joints, parts)
@example("puma260", 1, 0.0)
@example("puma560", 6, 1.0)
def test_the_zero_is_exact_to_the_count_wherever_the_joint_powers_up(
    name: str, joint: int, part: float
) -> None:
    arm = ARMS[name]
    power_up = angle_at(arm, joint, part)
    bench = Bench(arm, joint, power_up)
    encoder = EncoderReference(PARAMETERS[name][joint])
    step = math.copysign(0.01, angle_at(arm, joint, 0.5) - power_up)
    q = power_up
    while (result := encoder.find(*bench.frames(q))) is None:
        q += step
    assert result is True
    assert encoder.zero_counts == true_zero_counts(arm, joint, power_up)
    assert encoder.residual < AMBIGUITY
    measure, _ = bench.frames(q)
    assert encoder.angle(measure.counts) == pytest.approx(
        q, abs=0.51 / abs(arm.drives[joint - 1].counts_per_radian) + 1e-6
    )


@settings(max_examples=100)
@given(arms, joints, parts, st.sampled_from((0.5, -0.5, 0.45, -0.45)))
def test_a_potentiometer_off_by_half_an_interval_is_found_out(
    name: str, joint: int, part: float, off: float
) -> None:
    """Half an interval off it could name either pulse: the encoder stays unreferenced."""
    arm = ARMS[name]
    power_up = angle_at(arm, joint, 0.1 + 0.8 * part)
    bench = Bench(arm, joint, power_up)
    values = dict(PARAMETERS[name][joint])
    values[Parameter.COARSE_ZERO] += off * arm.drives[joint - 1].index_interval
    encoder = EncoderReference(values)
    bench.frames(power_up)
    frames = bench.frames(power_up + 1.1 * arm.drives[joint - 1].index_interval)
    assert encoder.find(*frames) is False
    assert encoder.zero_counts is None
    assert encoder.residual > AMBIGUITY


@given(arms, joints, parts, st.floats(-0.1, 0.1))
def test_later_samples_agree_with_the_first(name: str, joint: int, part: float, way: float) -> None:
    arm = ARMS[name]
    power_up = angle_at(arm, joint, 0.2 + 0.6 * part)
    bench = Bench(arm, joint, power_up)
    encoder = EncoderReference(PARAMETERS[name][joint])
    interval = arm.drives[joint - 1].index_interval
    bench.frames(power_up)
    zeros = set()
    for turned in (1.0, 1.3, 1.3 + way, 2.6, 0.2):
        assert encoder.find(*bench.frames(power_up + turned * interval)) is True
        zeros.add(encoder.zero_counts)
    assert len(zeros) == 1


def test_without_an_index_nothing_is_known() -> None:
    encoder = EncoderReference(PARAMETERS["puma260"][1])
    assert encoder.find(Measure(0, 0, 0, 0, 0, 0), Reference(2048, 0, 0, 0)) is None
    assert encoder.zero_counts is None


@settings(max_examples=60)
@given(arms, st.lists(parts, min_size=6, max_size=6))
def test_the_master_finds_the_same_zeros_in_the_same_frames(name: str, places: list[float]) -> None:
    arm, parameters = ARMS[name], PARAMETERS[name]
    state = ArmState({joint: parameters[joint] for joint in JOINTS})
    assert not state.referenced
    for joint, part in zip(JOINTS, places, strict=True):
        power_up = angle_at(arm, joint, 0.1 + 0.8 * part)
        bench, encoder = Bench(arm, joint, power_up), EncoderReference(parameters[joint])
        interval = arm.drives[joint - 1].index_interval
        measure, reference = bench.frames(power_up)
        state.measure(joint, measure)
        state.reference(joint, reference)
        coarse_error = arm.board_scale(joint - 1).coarse_error
        assert state.q[joint - 1] == pytest.approx(power_up, abs=coarse_error)
        q = power_up + 1.1 * interval
        measure, reference = bench.frames(q)
        state.measure(joint, measure)
        state.reference(joint, reference)
        assert encoder.find(measure, reference)
        assert state.zero_counts[joint - 1] == encoder.zero_counts
        assert state.q[joint - 1] == encoder.angle(measure.counts)
    assert state.referenced


# --- the motion --------------------------------------------------------------------------------


@pytest.mark.parametrize("part", [0.05, 0.45, 0.55, 0.95])
@pytest.mark.parametrize("name", ARMS)
def test_a_joint_searches_slowly_towards_the_middle_and_then_holds(name: str, part: float) -> None:
    """A joint that follows its torque's set-point ideally: what the search asks for."""
    arm, joint = ARMS[name], 3
    p = PARAMETERS[name][joint]
    power_up = angle_at(arm, joint, part)
    bench, encoder = Bench(arm, joint, power_up), EncoderReference(p)
    servo = Servo({**p, Parameter.KI: 0.0}, joint)
    homing = Homing(p, encoder, servo)
    q, path = power_up, [power_up]
    while not homing.found:
        torque = homing.step(*bench.frames(q), 0.0, 0.0)
        wanted = p[Parameter.HOMING_SPEED] if part < 0.5 else -p[Parameter.HOMING_SPEED]
        friction = servo.friction.rigid(wanted)
        if not homing.found:
            q += (torque - friction - p[Parameter.KD] * wanted) / p[Parameter.KP]
            path.append(q)
    assert homing.found
    steps = [b - a for a, b in pairwise(path)]
    limit = p[Parameter.HOMING_SPEED] * PERIOD_S + 2.0 / abs(p[Parameter.COUNTS_PER_UNIT])
    assert max(map(abs, steps)) <= limit
    assert abs(path[-1] - power_up) <= arm.drives[joint - 1].index_interval + 2 * limit
    assert (path[-1] - power_up) * (0.5 - part) > 0.0
    held = [homing.step(*bench.frames(q), 0.0, 0.0) for _ in range(5)]
    assert max(held) == pytest.approx(min(held))


def test_a_joint_that_knows_its_zero_homes_at_once_again(wire: Wire) -> None:
    bench = JointBench(wire).enable()
    zero = bench.controller.sensing.encoder.zero_counts
    assert zero == -bench.POWER_UP_COUNTS
    bench.command(Command.STOP)
    bench.command(Command.RESET)
    bench.command(Command.HOME)
    bench.sync(NodeState.HOMING)
    bench.measure()
    bench.say(Reference, bench.number, 0, 0, 0, bench.cycle & 0xFF)  # no index, nor needed
    assert bench.state is NodeState.READY
    assert bench.controller.sensing.encoder.zero_counts == zero


def test_wrong_potentiometer_fails_homing_and_keeps_the_arm_disabled(wire: Wire) -> None:
    bench = JointBench(wire)
    bench.configure()
    bench.command(Command.HOME)
    bench.rows(0)
    bench.sync(NodeState.HOMING)
    bench.measure()
    answers = bench.reference(coarse_error=0.5 * bench.arm.drives[bench.index].index_interval)
    (emergency,) = bench.emergencies(answers)
    assert emergency.fault == FaultCode.HOMING_FAILED
    assert emergency.value == pytest.approx(0.5, abs=0.1)
    assert [dac.current_dac for dac in bench.dacs(answers)] == [0]
    for command in (Command.HOME, Command.START):
        bench.command(command)
    assert bench.state is NodeState.FAULT


def test_a_homed_joint_holds_until_it_is_started(wire: Wire) -> None:
    bench = JointBench(wire)
    bench.configure()
    bench.home()
    for _ in range(5):
        bench.sync(NodeState.HOMING)
        assert len(bench.dacs(bench.measure() + bench.reference())) == 1
    bench.sync(NodeState.READY)
    assert bench.dacs(bench.measure()) == []  # the bus is homed: brakes may hold it


def test_reference_of_another_cycle_is_ignored(wire: Wire) -> None:
    bench = JointBench(wire)
    bench.configure()
    bench.command(Command.HOME)
    bench.sync(NodeState.HOMING)
    bench.measure()
    bench.cycle -= 1
    assert bench.reference() == []
    bench.cycle += 1
    assert bench.node.ignored["stale REFERENCE"] == 1
    assert bench.state is NodeState.HOMING


@settings(max_examples=60, deadline=None)
@given(arms, joints, st.floats(0.1, 0.9))
def test_an_encoder_that_counts_backwards_ends_homing_before_the_joint_has_gone_far(
    name: str, joint: int, part: float
) -> None:
    """The servo drives away from its goal; the coarse position tells."""
    arm, p = ARMS[name], PARAMETERS[name][joint]
    power_up = angle_at(arm, joint, part)
    bench = Bench(arm, joint, power_up)
    homing = Homing(p, EncoderReference(p), Servo(p, joint))
    towards = math.copysign(1.0, angle_at(arm, joint, 0.5) - power_up)
    q = power_up
    for _ in range(400):
        measure, reference = bench.frames(q)
        backwards = measure._replace(counts=-measure.counts)
        homing.step(backwards, reference._replace(index_counts=-reference.index_counts), 0.0, 0.0)
        if homing.failure is not None:
            break
        q += towards * 0.002
    assert homing.failure is not None
    assert homing.failure.value > homing.failure.bound
    assert abs(q - power_up) < 0.3 * arm.drives[joint - 1].index_interval


# --- homing that does not end -------------------------------------------------------------------


def search(bench: JointBench, index_valid: int, moves: bool) -> list[FaultCode]:
    """Search until the node gives up; faults it tells of. The joint follows, or stands."""
    p = bench.parameters
    middle = 0.5 * (p[Parameter.POSITION_MIN] + p[Parameter.POSITION_MAX])
    bench.configure()
    bench.command(Command.HOME)
    bench.rows(0)
    towards = math.copysign(p[Parameter.HOMING_SPEED], middle - bench.q[bench.index])
    for _ in range(10_000):
        bench.sync(NodeState.HOMING)
        bench.measure()
        coarse = (bench.q[bench.index] - p[Parameter.COARSE_ZERO]) / p[Parameter.COARSE_PER_CODE]
        answers = bench.say(
            *(Reference, bench.number, round(coarse), 0, index_valid, bench.cycle & 0xFF)
        )
        if bench.state is not NodeState.HOMING:
            assert [dac.current_dac for dac in bench.dacs(answers)] == [0]
            break
        if moves:
            bench.speed = towards
    return [FaultCode(emergency.fault) for emergency in bench.emergencies()]


def test_an_encoder_that_stands_still_under_full_torque_ends_homing(wire: Wire) -> None:
    bench = JointBench(wire)
    assert search(bench, 0, moves=False) == [FaultCode.HOMING_FAILED]
    (emergency,) = bench.emergencies()
    assert emergency.frame == wire.id(Measure, bench.number)
    assert emergency.bound == pytest.approx(bench.parameters[Parameter.STUCK_TIME])
    assert bench.cycle * PERIOD_S < 0.5  # the torque has grown to its limit, and 0.1 s there


def test_an_index_that_never_comes_ends_homing_in_its_time(wire: Wire) -> None:
    """A short range is walked through slowly here: there is no end of it in the test."""
    bench = JointBench(wire, changes={Parameter.HOMING_TIME: 0.6})
    assert search(bench, 0, moves=True) == [FaultCode.HOMING_FAILED]
    (emergency,) = bench.emergencies()
    assert emergency.frame == wire.id(Reference, bench.number)
    assert emergency.bound == pytest.approx(0.6, abs=1e-6)
    assert bench.cycle * PERIOD_S == pytest.approx(0.6, abs=3 * PERIOD_S)


@pytest.mark.parametrize("name", ARMS)
def test_the_time_of_homing_is_four_times_what_two_indexes_take(name: str) -> None:
    arm = ARMS[name]
    for joint in JOINTS:
        p = PARAMETERS[name][joint]
        to_pass_one = arm.drives[joint - 1].index_interval / p[Parameter.HOMING_SPEED]
        assert p[Parameter.HOMING_TIME] == pytest.approx(8.0 * to_pass_one, rel=1e-6)
        assert p[Parameter.HOMING_TIME] > 4.0 * p[Parameter.STUCK_TIME]

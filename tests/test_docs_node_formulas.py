"""The formulas of docs/node.md and its pages, line for line, beside our joint on random inputs."""

import math
import random
from typing import NamedTuple

import numpy as np
import pytest
from node_book import configuration, kinematics, protection, setpoints
from node_book.pump import JOINT, PERIOD_S, parameters
from pytest import approx
from support.plain_node.alone import PlainHoming, PlainStop
from support.plain_node.kinematics import link, solve_all, turn
from support.plain_node.law import PlainLaw
from support.plain_node.receiver import PlainReceiver
from support.plain_node.setpoint import PlainSetpoint

from rfms_can.arm import PUMA_260, PUMA_560
from rfms_can.joint_nodes.compliance import RowSets
from rfms_can.joint_nodes.homing import Homing
from rfms_can.joint_nodes.servo import Servo
from rfms_can.joint_nodes.stop_ramp import StopRamp
from rfms_can.kinematics import configuration_of, direct
from rfms_can.kinematics.configuration import CONFIGURATIONS
from rfms_can.kinematics.limits import nearest_turn
from rfms_can.node.encoder_reference import EncoderReference
from rfms_can.setpoint import JointSetpoint
from rfms_can.wire.configuration import configuration_hash
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.records import Measure, Nmt, Reference, Rows
from rfms_can.wire.vocabulary import Blend, Mode, Parameter, TrajectoryState

SEEDS = range(8)
BY_NAME = {parameter.name: value for parameter, value in parameters().items()}


def test_the_crc_of_the_page_is_that_of_every_frame_and_hash(wire: Wire) -> None:
    assert protection.crc(protection.CHECK) == 0x29B1
    for record, node, values, counter in protection.VECTORS:
        codec = wire.codec(record, node)
        data = protection.frame_with(wire.sender(record, node), values, counter).data
        assert codec.data_id == 0x5200 + codec.id
        assert data[2] == counter
        covered = data[2:] + codec.data_id.to_bytes(2, "little")
        assert data[:2] == protection.crc(covered).to_bytes(2, "little")
    hashed = protection.crc(configuration.hashed_bytes(parameters()))
    assert (hashed or 1) == configuration_hash(parameters())


@pytest.mark.parametrize("seed", SEEDS)
def test_the_rule_of_the_counters_takes_what_a_receiver_takes(wire: Wire, seed: int) -> None:
    rng = random.Random(seed)
    receiver, plain = wire.receiver(Nmt), PlainReceiver()
    frames = [frame for frame in _all_counters(wire)]
    counter, taken = rng.randrange(256), 0
    for _ in range(3000):
        step = rng.choice((1, 1, 1, 1, 0, 2, 16, 17, 40, 200, rng.randrange(256)))
        counter = (counter + step) % 256
        got = receiver.take(frames[counter]) is not None
        assert got == plain.take(counter)
        taken += got
    assert 100 < taken < 2900


def _all_counters(wire: Wire) -> list[Frame]:
    sender = wire.sender(Nmt)
    return [sender.frame(0, 0, 0) for _ in range(256)]


# kinematics


@pytest.mark.parametrize("arm", [PUMA_260, PUMA_560], ids=lambda arm: arm.name)
@pytest.mark.parametrize("seed", SEEDS)
def test_the_solution_of_the_page_is_ours_and_reproduces_the_pose(arm, seed) -> None:  # type: ignore[no-untyped-def]
    rng = random.Random(seed)
    known = kinematics.geometry(arm)
    lengths = (known.a2, known.a3, known.d4, known.shoulder_offset)
    q1, q2, q3, q4, q5, q6 = (rng.uniform(-3.0, 3.0) for _ in range(6))
    elements = kinematics.sent(direct(arm, (q1, q2, q3, q4, q5, q6)))
    pose = kinematics.received(elements)
    for code in range(8):
        plain = solve_all(lengths, elements[0:3], elements[3:6], elements[6:9], code)
        ours = kinematics.solve(known, pose, CONFIGURATIONS[code])
        assert [turn(x, 0.0, -10.0, 10.0) for x in plain] == approx(ours, abs=1e-9)
        matrix = np.eye(4)
        for (alpha, a, d), theta in zip(arm.dh, ours, strict=True):
            matrix = matrix @ link(a, d, alpha, theta)
        assert matrix[:3, 1:].T.flatten() == approx(elements, abs=2e-6)


def test_the_frame_at_zero_is_as_the_page_says() -> None:
    for arm in (PUMA_260, PUMA_560):
        known = kinematics.geometry(arm)
        pose = direct(arm, (0.0,) * 6)
        place = (known.a2 + known.a3, -known.shoulder_offset, known.d4)
        assert (pose.px, pose.py, pose.pz) == approx(place)
        assert (pose.nx, pose.oy, pose.az) == approx((1.0, 1.0, 1.0))


@pytest.mark.parametrize("seed", SEEDS)
def test_turns_are_chosen_as_the_page_says(seed: int) -> None:
    rng = random.Random(seed)
    for _ in range(500):
        low, high = sorted((rng.uniform(-8, 8), rng.uniform(-8, 8)))
        angle, previous = rng.uniform(-7, 7), rng.uniform(-12, 12)
        taken = nearest_turn(angle, previous, low, high)
        assert turn(angle, previous, low, high) == approx(taken, nan_ok=True)


def test_a_straight_wrist_holds_theta4_as_the_page_says() -> None:
    known = kinematics.geometry(PUMA_560)
    lengths = (known.a2, known.a3, known.d4, known.shoulder_offset)
    q = (0.3, 0.5, 2.0, 1.0, 0.0, 0.2)
    elements, branch = kinematics.sent(direct(PUMA_560, q)), configuration_of(PUMA_560, q)
    plain = solve_all(lengths, elements[0:3], elements[3:6], elements[6:9], branch.code, held=0.7)
    ours = kinematics.solve(known, kinematics.received(elements), branch, 0.7)
    assert [turn(x, 0.0, -10.0, 10.0) for x in plain] == approx(ours, abs=1e-9)
    assert plain[3] == approx(0.7)


# the set-point


def _compare(rows: list[setpoints.Row], start: float, t_acc: float, blend: Blend) -> None:
    ours, plain = JointSetpoint(PERIOD_S, start), PlainSetpoint(PERIOD_S, start)
    for row in rows:
        if row.state is None:
            ours.miss()
            plain.miss()
        else:
            told = setpoints.received(row, blend)._replace(acceleration_time=t_acc)
            taken = not math.isnan(ours.advance(told, row.q1, row.q2 or 0.0))
            words = {"state": row.state.name, "mode": row.mode.name, "blend": blend.name}
            numbers = {"r": told.r, "p": told.p, "t_acc": t_acc, "q1": row.q1, "q2": row.q2}
            assert plain.cycle(**words, **numbers) == taken, row  # type: ignore[arg-type]
        assert plain.theta == approx(ours.theta, abs=1e-9, rel=1e-7), row
        assert plain.rate == approx(ours.rate, abs=1e-6, rel=1e-6), row
        assert plain.acceleration == approx(ours.acceleration, abs=1e-3, rel=1e-6), row


@pytest.mark.parametrize("blend", Blend)
def test_the_traces_of_the_page_follow_from_its_formulas(blend: Blend) -> None:
    _compare(setpoints.joint_segments(), 0.3, setpoints.T_ACC, blend)
    _compare(setpoints.lines(), 0.8, setpoints.T_ACC, blend)


@pytest.mark.parametrize("blend", Blend)
@pytest.mark.parametrize("t_acc", [0.02, 0.2, 1.1])
@pytest.mark.parametrize("seed", SEEDS)
def test_random_sequences_of_states_give_the_same(blend: Blend, t_acc: float, seed: int) -> None:
    """Also sequences that no master sends: refused alike, missed alike."""
    rng = random.Random(seed)
    rows, angle, goal = [], 0.5, 0.6
    states = (*TrajectoryState, *[None], TrajectoryState.BLEND, TrajectoryState.LINEAR)
    for _ in range(300):
        angle += rng.uniform(-0.002, 0.002)
        goal += rng.uniform(-0.002, 0.002)
        numbers = (rng.random(), rng.choice((0.0, rng.random(), 1.0)), angle)
        second = rng.choice((None, goal))
        rows.append(setpoints.Row(rng.choice(states), rng.choice(tuple(Mode)), *numbers, second))
    _compare(rows, 0.5, t_acc, blend)


def test_a_long_history_is_fitted_as_the_page_says() -> None:
    line = [
        setpoints.Row(TrajectoryState.BLEND, Mode.CARTESIAN, 0.5, 0.5, 0.3 + 1e-3 * math.sin(k / 9))
        for k in range(200)
    ]
    start = setpoints.Row(TrajectoryState.START, Mode.CARTESIAN, 1.0, 0.0, 0.3)
    linear = setpoints.Row(TrajectoryState.LINEAR, Mode.CARTESIAN, 0.5, 0.0, 0.3)
    idle = setpoints.Row(TrajectoryState.IDLE, Mode.CARTESIAN, 0.0, 0.0, 0.3)
    for t_acc in (0.2, 2.0, 6.0, 12.0):  # windows of 10, 25, 128; no jerk, no acceleration
        for count in (5, 9, 50, 140):
            moving = [row._replace(state=TrajectoryState.LINEAR, p=0.0) for row in line[:count]]
            rows = [idle, start, line[0], *moving, linear, start, *line[:4]]
            _compare(rows, 0.3, t_acc, Blend.CONTINUOUS)


# the law


class Cycle(NamedTuple):
    """What a cycle gives to the plain law."""

    e: tuple[float, ...]
    v: tuple[float, ...]
    a: tuple[float, ...]
    R: tuple[float, ...]
    M: tuple[float, ...]
    G: float
    law: int
    mu: float
    selection: int
    specification: int


@pytest.mark.parametrize("seed", range(24))
def test_the_law_of_the_page_is_ours_over_many_cycles(seed: int) -> None:
    rng = random.Random(seed)
    changes = {Parameter.DITHER_FRACTION: rng.choice((0.0, 0.5))}
    if seed % 3 == 2:
        changes |= {Parameter.NATURAL_FREQUENCY: 0.0, Parameter.COULOMB_NEGATIVE: 0.0}
    used = {**parameters(), **changes}
    servo, rows = Servo(used, JOINT), RowSets(JOINT)
    plain = PlainLaw({p.name: v for p, v in used.items()}, JOINT)

    def six(size: float) -> tuple[float, ...]:
        return tuple(rng.uniform(-size, size) for _ in range(6))

    cycle = Cycle(six(1e-3), six(0.1), six(1.0), six(1.0), six(0.3), 0.5, 0, 0.0, 0, 0)
    saturated = 0
    for k in range(640):
        if k % 40 == 0:  # other rows; the specification changes once
            selection = rng.choice((0, 4))
            size = (1e-4, 1e-3, 2.0)[(k // 40 + seed) % 3]
            law, gravity = rng.choice((0, 1)), rng.uniform(-1.0, 1.0)
            told = (gravity, law, 4.0 * bool(selection), selection, k // 320)
            cycle = Cycle(six(size), six(0.1), six(1.0), six(1.0), six(0.3), *told)
        cycle = cycle._replace(e=tuple(x + rng.uniform(-1e-5, 1e-5) for x in cycle.e))
        desired, speed = rng.choice((0.0, 0.1, -0.1)), rng.choice((0.0, 0.001, -0.2))
        bias = rng.choice((0.0, 0.0, 0.5, -9.0))
        more = (1, cycle.law, cycle.mu, cycle.selection, cycle.specification)
        rows.activate(Rows._make((*cycle.R, *cycle.M, cycle.G, *more, 0)))
        delivered = servo.deliverable_bias(bias)
        friction = (
            servo.friction.complying(desired, speed, servo.state.intended_speed, k)
            if cycle.selection
            else servo.friction.rigid(desired)
        )
        ours = servo.torque(cycle.e, cycle.v, cycle.a, rows, rows.gravity, friction, delivered)
        theirs = plain.torque(cycle, k, desired, speed, bias)
        assert theirs == approx(ours, abs=1e-9), k
        assert plain.codes(theirs, delivered) == (servo.code(ours), servo.force_code(delivered))
        saturated += servo.state.at_limit
    assert saturated


@pytest.mark.parametrize("seed", SEEDS)
def test_the_stop_of_the_page_is_ours(seed: int) -> None:
    rng = random.Random(seed)
    position, speed = rng.uniform(-3.0, 0.9), rng.uniform(-2.0, 2.0)
    servo, plain = Servo(parameters(), JOINT), PlainLaw(BY_NAME, JOINT)
    stop = PlainStop(plain, position, speed)
    ramp = StopRamp(position, speed, stop.dec, BY_NAME["PERIOD"])
    theta = position
    for k in range(200):
        theta = theta + 1e-4 * rng.choice((0, 1, -1)) if k < 80 else theta
        measured = rng.uniform(-0.01, 0.01)
        ramp.step()
        ramp.watch(theta)
        friction, inertia = servo.friction.rigid(ramp.speed), 0.05 * ramp.acceleration
        error, rate = ramp.position - theta, ramp.speed - measured
        ours = servo.alone(error, rate, 0.8, friction, inertia)
        assert stop.cycle(theta, measured, 0.8, 0.05) == approx(ours, abs=1e-9), k


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("wrong", [None, "reversed", "frozen"])
def test_homing_of_the_page_is_ours(seed: int, wrong: str | None) -> None:
    """The joint is moved along; the encoder may be a wrong one."""
    rng = random.Random(seed)
    used, encoder, servo = parameters(), EncoderReference(parameters()), Servo(parameters(), JOINT)
    homing = Homing(used, encoder, servo)
    plain = PlainHoming(PlainLaw(BY_NAME, JOINT))
    theta, power_up = rng.uniform(-3.5, 0.5), 0.0
    per, per_code = BY_NAME["COUNTS_PER_UNIT"], BY_NAME["COARSE_PER_CODE"]
    power_up = theta
    step = math.copysign(0.0016, -1.6 - theta)
    for k in range(300):
        theta += step
        index = math.floor(theta * per / 1000.0) * 1000 - round(power_up * per)
        seen = math.floor(theta * per / 1000.0) != math.floor(power_up * per / 1000.0)
        told = {"reversed": 2 * power_up - theta, "frozen": power_up}.get(wrong or "", theta)
        counts = round((told - power_up) * per)
        coarse = round((theta - BY_NAME["COARSE_ZERO"]) / per_code)
        measure = Measure(counts, 0, 0, 0, 0, 0)
        reference = Reference(coarse, index if seen else 0, int(seen), 0)
        ours = homing.step(measure, reference, 0.0, 0.8)
        theirs = plain.cycle(counts, coarse, index if seen else None, 0.0, 0.8)
        assert plain.failed == (homing.failure is not None), k
        if plain.failed:
            break
        assert plain.found == bool(homing.found), k
        assert plain.zero == encoder.zero_counts
        assert theirs == approx(ours, abs=1e-9), k
    assert plain.failed == (wrong is not None)
    assert wrong is not None or plain.found

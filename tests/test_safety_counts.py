"""What a node counts and tells of its bus, and what the master says of a joint: to the number.

These numbers are what a fault is looked for by; a wrong one leads to the wrong node.
"""

from collections import Counter

import numpy as np
import pytest
from support.joint_bench import JointBench

from rfms_can.arm import PUMA_260, PUMA_560
from rfms_can.errors import EncodeError
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.master.verification import AGREEMENT, CYCLES, Verification, following_bounds
from rfms_can.plant.board import Board
from rfms_can.wire.contract import ESTOP_VALUES, Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import JOINTS, MASTER, PLANT
from rfms_can.wire.protection import Receiver, Refusal
from rfms_can.wire.records import Estop, Heartbeat, JointError, Measure, Sync
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState, Parameter

PARAMETERS = all_parameters(PUMA_560, "corke", 0.004)
AT = (0.3, -0.4, 0.5, 0.1, 0.7, -0.2)
ZERO = (0.0,) * 6


def off_by(joint: int, angle: float) -> tuple[float, ...]:
    """Measured angles where one joint is behind."""
    return tuple(at - angle * (k == joint) for k, at in zip(JOINTS, AT, strict=True))


# --- a node ---------------------------------------------------------------------------------------


@pytest.fixture
def bench(wire: Wire) -> JointBench:
    return JointBench(wire).enable()


def spoilt(frame: Frame) -> Frame:
    return Frame(frame.id, bytes([frame.data[0] ^ 1, *frame.data[1:]]))


def test_frames_that_are_refused_foreign_or_missed_are_each_counted_once(bench: JointBench) -> None:
    node = bench.node
    before = node.lost
    bench.give(Frame(0x7F0, b"\0" * 8))
    assert (node.foreign, node.discarded) == (1, 0)
    bench.sync()
    bench.give(spoilt(bench.sender(Measure, bench.number).frame(0, 0, 0, 0, 0, 0)))
    assert (node.discarded, node.refused[Refusal.CRC]) == (1, 1)
    assert node.bad_frames(PLANT) == Counter({Refusal.CRC: 1})
    assert node.bad_frames(MASTER) == Counter()
    bench.measure()
    assert node.lost == before + 1


def test_a_heartbeat_tells_the_node_and_its_counts(bench: JointBench) -> None:
    for _ in range(2):
        bench.give(spoilt(bench.sender(Measure, bench.number).frame(0, 0, 0, 0, 0, 0)))
    (beat,) = [h.values for h in bench.run(25) if h.name == f"HEARTBEAT_{bench.number}"][:1]
    assert beat == Heartbeat(
        state=NodeState.OPERATIONAL,
        bus_offs=0,
        error_register=0,
        boot_id=bench.node.boot_id,
        dbc_hash=bench.wire.dbc_hash,
        config_hash=bench.node.config_hash,
        discarded=2,
        overflows=0,
    )


def test_the_count_of_a_heartbeat_saturates(bench: JointBench) -> None:
    bench.node.refused[Refusal.CRC] = 70_000
    (beat,) = [h.values for h in bench.run(25) if h.name == f"HEARTBEAT_{bench.number}"][:1]
    assert beat.discarded == 0xFFFF


def test_what_a_node_accepts_is_what_it_hears(bench: JointBench) -> None:
    wire = bench.wire
    assert {wire.id(Sync), wire.id(Estop), wire.id(Measure, 2)} <= bench.node.accepts
    assert wire.id(Measure, 3) not in bench.node.accepts


def test_an_emergency_stop_tells_no_number_and_no_culprit(bench: JointBench) -> None:
    (emergency,) = bench.emergencies(bench.say(Estop, None, *ESTOP_VALUES))
    told = (emergency.fault, emergency.culprit, emergency.frame, emergency.value, emergency.bound)
    assert told == (FaultCode.EMERGENCY_STOP, 0, 0, 0.0, 0.0)


def test_a_start_begins_its_own_counters_at_0(bench: JointBench) -> None:
    bench.run(5)
    bench.command(Command.STOP)
    bench.command(Command.START)
    bench.cycle = -1
    bench.sync()
    bench.setpoint()
    frame = bench.sender(Measure, bench.number).frame(
        *(bench.counts(), 0, 0, bench.cycle & 0xFF, 0, 0)
    )
    sent = bench.node.on_frame(frame, bench.now_ns)
    assert [frame.data[2] for frame in sent] == [0]


# --- receivers ------------------------------------------------------------------------------------


def test_a_refusal_counts_once_for_the_node_and_once_for_the_message(wire: Wire) -> None:
    shared: Counter[Refusal] = Counter()
    receiver: Receiver[Sync] = wire.receiver(Sync, None, shared)
    frame = wire.sender(Sync).frame(0, 4, 0, 0)
    assert receiver.take(spoilt(frame)) is None
    assert (shared, receiver.bad) == ({Refusal.CRC: 1}, {Refusal.CRC: 1})


def test_the_same_stray_again_and_again_is_taken_up_by_none(wire: Wire) -> None:
    """A sender that hangs repeats itself: that is no row of frames in step."""
    receiver: Receiver[Sync] = wire.receiver(Sync, None)
    sender = wire.sender(Sync)
    frames = [sender.frame(cycle, 4, 0, 0) for cycle in range(120)]
    for frame in frames[:20]:
        assert receiver.take(frame) is not None
    assert [receiver.take(frames[100]) for _ in range(30)] == [None] * 30
    assert receiver.leaps == 0
    assert receiver.take(frames[20]) is not None


# --- codec and board ------------------------------------------------------------------------------


def test_a_value_that_does_not_fit_is_told_with_its_bounds_and_its_unit(wire: Wire) -> None:
    with pytest.raises(EncodeError, match=r"^ERROR_3\.error: 99 does not fit -\S+\.\.\S+ rad"):
        wire.sender(JointError, 3).frame(99, 0.0, 0.0, 0)
    with pytest.raises(EncodeError, match=r"^SYNC\.cycle: -1 does not fit 0\.\.\d+$"):
        wire.sender(Sync).frame(-1, 4, 0, 0)


def test_a_board_that_has_just_powered_up_reads_nothing() -> None:
    board = Board(PUMA_260, 2, 0.7)
    assert (board.latched_index_counts, board.current) == (None, 0.0)
    assert board.sample() == (0, 0, 0, False)


# --- what the master says -------------------------------------------------------------------------


def test_a_good_cycle_forgives_an_untrue_error_whole() -> None:
    verification = Verification(PARAMETERS)
    for _ in range(20):
        for _ in range(CYCLES - 1):
            assert verification.check(AT, None, off_by(2, 0.01), ZERO) is None
        assert verification.check(AT, None, AT, ZERO) is None


def test_the_bounds_that_are_told_are_those_that_were_broken() -> None:
    verification = Verification(PARAMETERS)
    reasons = [verification.check(AT, None, off_by(4, 0.01), ZERO) for _ in range(CYCLES)]
    assert reasons[-1] is not None and reasons[-1].words == (
        "joint 4: ERROR_4 tells 0.000000 rad, but MEASURE_4 is 0.090000 rad where 0.100000 rad "
        f"was commanded, which is 0.010000 rad (bound {AGREEMENT:g} rad, 3 cycles): its node "
        "computes another set-point (cycle 0)"
    )
    verification.reset()
    verification.check(AT, None, AT, ZERO, 0b110111)
    reasons = [verification.check(AT, None, off_by(4, 0.03), ZERO) for _ in range(CYCLES)]
    wide = AGREEMENT + PARAMETERS[4][Parameter.SPEED_LIMIT] * 0.004
    assert reasons[-1] is not None and f"(bound {wide:g} rad, 3 cycles)" in reasons[-1].words


@pytest.mark.parametrize("joint", JOINTS)
def test_the_joint_that_does_not_follow_is_named_rigid_or_held(joint: int) -> None:
    verification = Verification(PARAMETERS)
    bound = verification.bounds[joint - 1]
    told = tuple(0.2 * (k == joint) for k in JOINTS)
    for _ in range(CYCLES):
        reason = verification.check(AT, None, off_by(joint, 0.2), told)
    assert reason is not None
    assert f"joint {joint} does not follow" in reason.words
    assert f"(rigid off by 0.2000 rad, bound {bound:g} rad, 3 cycles)" in reason.words
    verification.reset()
    held = 0.9 * np.eye(6)
    for _ in range(CYCLES):
        reason = verification.check(AT, None, off_by(joint, 0.3), told_of(joint), 0b111111, held)
    assert reason is not None
    assert f"joint {joint} does not follow" in reason.words
    assert f"(held part off by 0.2700 rad, bound {2.0 * bound:g} rad, 3 cycles)" in reason.words


def told_of(joint: int) -> tuple[float, ...]:
    return tuple(0.3 * (k == joint) for k in JOINTS)


def test_without_a_model_bounds_widen_by_the_square_of_the_frequency() -> None:
    """Of each joint's natural frequency, whatever its damping; a stiff servo's stay."""
    changed = {
        joint: {**PARAMETERS[joint], Parameter.NATURAL_FREQUENCY: frequency, Parameter.KP: 0.0}
        for joint, frequency in zip(JOINTS, (15.0, 30.0, 60.0, 0.0, 10.0, 29.0), strict=True)
    }
    bounds = following_bounds(changed, modelled=False)
    assert bounds == pytest.approx((0.4, 0.1, 0.1, 0.1, 0.9, 0.1 * (30 / 29) ** 2))
    assert following_bounds(changed, modelled=True) == (0.1,) * 6

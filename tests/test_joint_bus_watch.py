"""What a joint finds wrong with its bus: a second master, bad frames, its port, a dead master."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.bench import PERIOD_NS
from support.joint_bench import JointBench

from rfms_can.joint_nodes.detectors.bus import BadFrames, PortWatch, SyncNumbers
from rfms_can.joint_nodes.ladder import Reaction
from rfms_can.node.port_counts import PortCounts
from rfms_can.wire.codec import MessageCodec
from rfms_can.wire.configuration import Clock
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import MASTER, PLANT
from rfms_can.wire.records import (
    Heartbeat,
    JointError,
    Measure,
    Reference,
    Rows,
    Setpoint,
    Sync,
)
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState, Parameter

U32 = 2**32


@pytest.fixture
def bench(wire: Wire) -> JointBench:
    return JointBench(wire).enable()


# --- a second master ------------------------------------------------------------------------------


@given(st.integers(0, U32 - 1), st.integers(-40, 40), st.integers(0, 25))
def test_a_master_counts_on_and_may_be_late_or_lose_a_few(last: int, off: int, missed: int) -> None:
    numbers = SyncNumbers()
    assert not numbers.is_foreign((last + off) % U32), "before the first any number is its own"
    numbers.last = last
    assert numbers.is_foreign((last + off) % U32, missed) is not (-4 <= off <= 4 + missed)
    numbers.reset()
    assert not numbers.is_foreign((last + 1000) % U32)


def foreign_sync(bench: JointBench, cycle: int, counter: int = 0) -> None:
    """A SYNC of a sender of its own, whose counter stands at ``counter``."""
    sender = bench.wire.sender(Sync)
    for _ in range(counter):
        sender.frame(0, 0, 0, 0)
    bench.give(sender.frame(cycle, NodeState.OPERATIONAL, bench.row_set, bench.wire.dbc_hash))


def counter_of(bench: JointBench) -> int:
    """Of the last SYNC of the bench's master."""
    return bench.sender(Sync)._buffer[2]


def stopped_by(bench: JointBench, frame: int, value: float, bound: float) -> None:
    (emergency,) = bench.emergencies()
    assert emergency.fault == FaultCode.FOREIGN_MASTER
    assert (emergency.culprit, emergency.frame) == (MASTER, frame)
    assert (emergency.value, emergency.bound) == (value, bound)
    assert (bench.state, bench.node.reaction) == (NodeState.QUICKSTOP, Reaction.STOP)


@pytest.mark.parametrize("off", [5, 100, -5, -20])
def test_a_sync_that_is_taken_and_far_off_stops_the_joint_and_has_no_other_effect(
    bench: JointBench, off: int
) -> None:
    bench.run(30)
    last = bench.cycle
    deadline = bench.node.next_deadline_ns()
    bench.now_ns += 1000
    foreign_sync(bench, last + off, counter=counter_of(bench) + 1)
    stopped_by(bench, bench.wire.id(Sync), last + off, last)
    assert bench.node.cycle == last
    assert bench.node.next_deadline_ns() == deadline


@pytest.mark.parametrize("off", [1, 4, -4])
def test_a_sync_a_few_cycles_off_may_be_of_the_same_master(bench: JointBench, off: int) -> None:
    bench.run(30)
    bench.cycle += off - 1
    bench.sync()
    assert bench.node.cycle == bench.cycle
    assert FaultCode.FOREIGN_MASTER not in bench.node.faults


def test_a_sync_that_is_refused_for_its_counter_tells_of_a_second_master(
    bench: JointBench,
) -> None:
    bench.run(60)
    discarded = bench.node.discarded
    foreign_sync(bench, 7, counter=5)
    assert bench.node.discarded == discarded + 1
    stopped_by(bench, bench.wire.id(Sync), 7, bench.cycle)


def test_a_sync_of_the_own_master_that_comes_twice_is_none(bench: JointBench) -> None:
    bench.run(30)
    frame = bench.sender(Sync).frame(bench.cycle, 4, bench.row_set, bench.wire.dbc_hash)
    for _ in range(2):
        bench.give(Frame(frame.id, bytes(frame.data)))
    assert bench.node.discarded == 1
    assert not bench.node.faults


def test_a_sync_with_a_bad_crc_tells_of_no_master(bench: JointBench) -> None:
    frame = bench.wire.sender(Sync).frame(5000, 4, 0, bench.wire.dbc_hash)
    bench.give(Frame(frame.id, bytes(frame.data[:-1]) + b"\x01"))
    assert bench.node.discarded == 1
    assert not bench.node.faults


@pytest.mark.parametrize("missed", range(1, 25))
def test_a_master_that_is_heard_again_is_no_second_one(bench: JointBench, missed: int) -> None:
    """Its SYNCs were lost; it has counted on."""
    bench.run(10)
    bench.miss_syncs(missed)
    bench.sync()
    assert FaultCode.FOREIGN_MASTER not in bench.node.faults
    assert bench.node.cycle == bench.cycle
    assert bench.node.ladder.misses[FaultCode.SYNC_MISSING] == 0


@pytest.mark.parametrize("command", [Command.START, Command.HOME])
def test_a_master_may_begin_with_any_number(wire: Wire, command: Command) -> None:
    bench = JointBench(wire)
    bench.configure()
    bench.home()
    bench.command(command)
    bench.cycle = 12345
    bench.sync(NodeState.HOMING)
    assert bench.node.cycle == 12346
    assert not bench.node.faults


def test_a_joint_that_does_not_drive_follows_any_sync(wire: Wire) -> None:
    bench = JointBench(wire)
    bench.configure()
    bench.home()
    bench.sync(NodeState.READY)
    bench.cycle = 5000
    bench.sync(NodeState.READY)
    assert bench.node.cycle == 5001
    assert not bench.node.faults


class Master:
    """A master that tells of itself."""

    def __init__(self, bench: JointBench, boot_id: int) -> None:
        self._bench = bench
        self._sender = bench.wire.sender(Heartbeat, MASTER)
        self._values = (NodeState.OPERATIONAL, 0, 0, boot_id, bench.wire.dbc_hash, 0, 0, 0)

    def beat(self) -> None:
        """HEARTBEAT, which no joint refuses."""
        discarded = self._bench.node.discarded
        self._bench.give(self._sender.frame(*self._values))
        assert self._bench.node.discarded == discarded


def test_a_heartbeat_of_a_second_master_stops_the_joint(bench: JointBench) -> None:
    first, second = Master(bench, 0xA), Master(bench, 0xB)
    first.beat()
    bench.run(3)
    first.beat()
    assert not bench.node.faults
    second.beat()
    assert set(bench.node.faults) == {FaultCode.FOREIGN_MASTER}
    stopped_by(bench, bench.wire.id(Heartbeat, MASTER), 0xB, 0xA)


def test_a_master_whose_reset_is_taken_is_the_one_known(wire: Wire) -> None:
    """In lockstep SYNC of the one that died is in time for seconds."""
    lockstep = {Parameter.CLOCK: float(Clock.LOCKSTEP)}
    bench = JointBench(wire, changes=lockstep).enable()
    first, second = Master(bench, 0xA), Master(bench, 0xB)
    first.beat()
    bench.run(3)
    bench.command(Command.QUICKSTOP)
    bench.command(Command.RESET)
    second.beat()
    bench.home()
    second.beat()
    bench.start()
    second.beat()
    assert (bench.state, bench.emergencies()) == (NodeState.OPERATIONAL, [])
    first.beat()
    stopped_by(bench, wire.id(Heartbeat, MASTER), 0xA, 0xB)


def test_before_its_first_sync_a_joint_knows_no_second_master(wire: Wire) -> None:
    bench = JointBench(wire)
    bench.configure()
    bench.home()
    bench.sync()
    first, second = Master(bench, 0xA), Master(bench, 0xB)
    first.beat()
    bench.command(Command.START)
    second.beat()
    assert not bench.node.faults
    bench.sync()
    second.beat()
    stopped_by(bench, wire.id(Heartbeat, MASTER), 0xB, 0xA)


# --- bad frames -----------------------------------------------------------------------------------


@given(
    st.integers(0, U32 - 1),
    st.lists(st.tuples(st.sampled_from((0x80, 0x140)), st.integers(0, 7)), max_size=30),
)
def test_three_in_ten_cycles_of_one_identifier_are_too_many(
    begin: int, refused: list[tuple[int, int]]
) -> None:
    watch, cycle = BadFrames(), 0
    came: dict[int, list[int]] = {0x80: [], 0x140: []}
    for identifier, later in refused:
        cycle += later
        came[identifier].append(cycle)
        last = came[identifier][-3:]
        expected = len(last) == 3 and cycle - last[0] < 10
        assert watch.too_many(identifier, (begin + cycle) % U32) is expected
    watch.reset()
    assert not watch.too_many(0x80, (begin + cycle) % U32)


def spoilt(bench: JointBench, record: type, node: int | None) -> None:
    """A frame of an identifier whose CRC is wrong."""
    codec: MessageCodec[Any] = bench.wire.codec(record, node)
    bench.give(Frame(codec.id, b"\xff" * codec.length))


def run_spoilt(bench: JointBench, at: tuple[int, ...], record: type, node: int | None) -> None:
    """Good cycles, with a bad frame in some of them."""
    for cycle in range(max(at) + 1):
        bench.run()
        for _ in range(at.count(cycle)):
            spoilt(bench, record, node)


SENDERS: list[tuple[type, int | None, int]] = [
    (Setpoint, 1, MASTER),
    (Sync, None, MASTER),
    (Rows, 2, MASTER),
    (Measure, 2, PLANT),
    (Reference, 2, PLANT),
    (JointError, 5, 5),
    (JointError, 2, 2),
]


@pytest.mark.parametrize(("record", "node", "culprit"), SENDERS)
def test_three_bad_frames_in_ten_cycles_stop_the_joint(
    bench: JointBench, record: type, node: int | None, culprit: int
) -> None:
    run_spoilt(bench, (0, 4, 9), record, node)
    (emergency,) = bench.emergencies()
    assert emergency.fault == FaultCode.BAD_FRAMES
    assert (emergency.culprit, emergency.frame) == (culprit, bench.wire.id(record, node))
    assert (emergency.value, emergency.bound) == (3, 10)
    assert (bench.state, bench.node.reaction) == (NodeState.QUICKSTOP, Reaction.STOP)


def test_three_in_eleven_cycles_do_not(bench: JointBench) -> None:
    run_spoilt(bench, (0, 4, 10), Setpoint, 1)
    assert bench.node.discarded == 3
    assert not bench.node.faults


def test_three_in_one_cycle_do(bench: JointBench) -> None:
    run_spoilt(bench, (0, 0, 0), Setpoint, 1)
    assert bench.node.faults == {FaultCode.BAD_FRAMES: 1}


def test_frames_of_three_identifiers_do_not(bench: JointBench) -> None:
    bench.run()
    for record, node in ((Setpoint, 1), (Setpoint, 2), (Rows, 2)):
        for _ in range(2):
            spoilt(bench, record, node)
    assert bench.node.discarded == 6
    assert not bench.node.faults


def test_frames_refused_for_their_counter_do_not(bench: JointBench) -> None:
    bench.run(3)
    frame = bench.sender(JointError, 5).frame(0.0, 0.0, 0.0, 0)
    for _ in range(4):
        bench.give(Frame(frame.id, bytes(frame.data)))
    assert bench.node.discarded == 3
    assert not bench.node.faults


@pytest.mark.parametrize("command", [Command.START, Command.RESET])
def test_a_joint_that_begins_again_forgets_bad_frames(bench: JointBench, command: Command) -> None:
    run_spoilt(bench, (5, 5), Setpoint, 1)
    came = bench.node.cycle
    bench.command(Command.STOP)
    if command is Command.RESET:
        bench.command(Command.RESET)
        bench.home()
    bench.start()
    bench.run(came)  # to the cycle of the same number
    assert bench.node.cycle == came
    spoilt(bench, Setpoint, 1)
    assert not bench.node.faults


def test_a_joint_that_does_not_drive_counts_none(wire: Wire) -> None:
    bench = JointBench(wire)
    bench.configure()
    bench.home()
    for _ in range(5):
        spoilt(bench, Setpoint, 1)
    assert bench.node.discarded == 5
    assert not bench.node.faults


# --- the own port ---------------------------------------------------------------------------------


@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 3)), max_size=20))
def test_what_a_port_has_counted_since_is_told_once(counted: list[tuple[int, int]]) -> None:
    watch, total = PortWatch(), PortCounts()
    for bus_offs, overflows in counted:
        total = PortCounts(total.bus_offs + bus_offs, total.overflows + overflows)
        assert watch.news(total) == (bus_offs, overflows)
        assert watch.news(total) == (0, 0)


class Port:
    """What the bench's port has counted."""

    def __init__(self, bench: JointBench) -> None:
        self.bus_offs = self.overflows = 0
        bench.node.port_counts = lambda: PortCounts(self.bus_offs, self.overflows)


Next = Callable[[JointBench], object]
ASKED: dict[str, Next] = {
    "at SYNC": lambda bench: bench.sync(),
    "by the watchdog": lambda bench: bench.miss_syncs(1),
}


@pytest.mark.parametrize("asked", ASKED)
def test_a_controller_that_was_off_the_bus_damps_the_joint(bench: JointBench, asked: str) -> None:
    port = Port(bench)
    port.bus_offs = 2
    assert not bench.node.faults
    ASKED[asked](bench)
    (emergency,) = bench.emergencies()
    assert emergency.fault == FaultCode.BUS_OFF
    assert (emergency.culprit, emergency.frame) == (bench.number, 0)
    assert (emergency.value, emergency.bound) == (2, 0)
    assert (bench.state, bench.node.reaction) == (NodeState.FAULT, Reaction.DAMP)
    bench.run(3)
    assert bench.node.faults[FaultCode.BUS_OFF] == 1, "told once"


def test_bus_off_is_told_in_preop_too(wire: Wire) -> None:
    bench = JointBench(wire)
    bench.configure()
    Port(bench).bus_offs = 1
    bench.sync(NodeState.READY)
    assert [e.fault for e in bench.emergencies()] == [FaultCode.BUS_OFF]
    assert bench.state is NodeState.FAULT
    assert bench.dacs() == []


@pytest.mark.parametrize("asked", ASKED)
def test_frames_lost_in_three_cycles_in_a_row_stop_the_joint(bench: JointBench, asked: str) -> None:
    port = Port(bench)
    for _ in range(3):  # two in a row are none
        for _ in range(2):
            port.overflows += 5
            bench.run()
        bench.run()
    assert bench.node.faults == {FaultCode.QUEUE_OVERFLOW: 6}
    for lost in (1, 2):
        port.overflows += lost
        bench.run()
    port.overflows += 7
    assert bench.emergencies() == []
    ASKED[asked](bench)
    (emergency,) = bench.emergencies()
    assert emergency.fault == FaultCode.QUEUE_OVERFLOW
    assert (emergency.culprit, emergency.frame) == (bench.number, 0)
    assert (emergency.value, emergency.bound) == (7, 0)
    assert (bench.state, bench.node.reaction) == (NodeState.QUICKSTOP, Reaction.STOP)


def test_what_was_lost_while_the_joint_was_braked_counts_for_nothing(wire: Wire) -> None:
    bench = JointBench(wire)
    bench.configure()
    bench.home()
    port = Port(bench)
    for _ in range(5):
        port.overflows += 1
        bench.sync(NodeState.READY)
    assert not bench.node.faults


# --- a master that is dead, in lockstep -----------------------------------------------------------


def test_after_the_barrier_the_watchdog_runs_off_every_period(wire: Wire) -> None:
    changes = {Parameter.CLOCK: float(Clock.LOCKSTEP), Parameter.BARRIER: 0.5}
    bench = JointBench(wire, changes=changes).enable()
    for _ in range(2):
        armed_ns = bench.now_ns
        assert bench.node.next_deadline_ns() == armed_ns + 750_000_000
        bench.miss_syncs(1)
        assert bench.node.next_deadline_ns() == bench.now_ns + PERIOD_NS
        bench.miss_syncs(1)
        assert bench.state is NodeState.OPERATIONAL
        bench.sync()  # it was slow: the barrier holds again
    assert bench.node.next_deadline_ns() == bench.now_ns + 750_000_000
    bench.miss_syncs(3)
    assert bench.state is NodeState.QUICKSTOP
    (emergency,) = bench.emergencies()
    assert emergency.fault == FaultCode.SYNC_MISSING
    bench.miss_syncs(22)
    assert bench.node.reaction is Reaction.OFF

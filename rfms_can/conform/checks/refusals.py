"""Checks 5 to 11: what the node must not take."""

from collections.abc import Iterable

from rfms_can.conform.protection import sealed
from rfms_can.conform.samples import Message, at_the_bounds, flipped, heard, not_heard, out_of_range
from rfms_can.conform.tester import QUIET_S, Tester
from rfms_can.wire.frame import FD_LENGTHS, Frame
from rfms_can.wire.records import Config, Estop, Nmt, Sync
from rfms_can.wire.vocabulary import Command, NodeState, Parameter

BATCH = 32
"""Frames between two looks at what came."""
AHEAD = 8
"""How far ahead of the next counter a wrong frame is: in step for all HEARTBEATs that are asked for
meanwhile, so that only what is wrong with it can refuse it."""
ACTING = (Nmt, Sync, Config)
"""Messages that do something, or are answered, with a value at an end of its range."""


def refused(t: Tester, frames: Iterable[Frame], why: str) -> None:
    """The node must count each of these frames, and do nothing."""
    before, count = t.beat().discarded, 0
    batch: list[Frame] = []

    def give() -> None:
        t.only(t.give(*batch), (), why)
        batch.clear()
        if before + count < 0xFFFF:
            t.equal(t.beat().discarded - before, count, f"discarded frames, {why}")

    for frame in frames:
        batch.append(frame)
        count += 1
        if len(batch) == BATCH:
            give()
    if batch:
        give()


def ahead(t: Tester, message: Message, body: bytes | bytearray) -> Frame:
    """A frame with a CRC that is right and a counter in step, which is not used up by it."""
    codec = t.codec(*message)
    assert codec.data_id is not None, "all that a joint hears but ESTOP is protected"
    return sealed(codec.id, body, t.counter(*message) + AHEAD, codec.data_id)


def one_bit(t: Tester) -> None:
    """Each bit of each frame, one at a time."""
    t.to_preop()
    for message, values in heard(t).items():
        frame = ahead(t, message, t.body(*message, *values))
        wrong = (Frame(frame.id, data) for data in flipped(frame.data))
        refused(t, wrong, f"one bit of {t.codec(*message).name} flipped")
    t.only(t.elapse(QUIET_S), ())


def another_data_id(t: Tester) -> None:
    """A CRC that fits another identifier, and none at all."""
    t.to_preop()
    for message, values in heard(t).items():
        codec = t.codec(*message)
        assert codec.data_id is not None
        body, counter = t.body(*message, *values), t.counter(*message) + AHEAD
        wrong = [sealed(codec.id, body, counter, codec.data_id ^ 1 << bit) for bit in range(16)]
        bare = bytearray(body)
        bare[2] = counter & 0xFF
        refused(t, [*wrong, Frame(codec.id, bytes(bare))], f"{codec.name} of another data ID")


def wrong_length(t: Tester) -> None:
    """Longer and shorter than the contract has it, the CRC right; and classic frames."""
    t.to_preop()
    for message, values in heard(t).items():
        codec = t.codec(*message)
        assert codec.data_id is not None
        body = bytes(t.body(*message, *values))
        lengths = sorted(FD_LENGTHS)
        place = lengths.index(codec.length)
        wrong = []
        for length in lengths[max(0, place - 1) : place + 2]:
            if length != codec.length:
                longer = (body + bytes(64))[:length]
                wrong.append(ahead(t, message, longer))
        if codec.length <= 8:
            right = ahead(t, message, body)
            wrong.append(Frame(codec.id, right.data, fd=False))
        refused(t, wrong, f"{codec.name} of a wrong length, or classic")
    stop = t.codec(Estop)
    refused(t, [Frame(stop.id, bytes(7)), Frame(stop.id, bytes(12))], "ESTOP of a wrong length")


def wrong_values(t: Tester) -> None:
    """Each field out of its range by the least it can be; at the ends of the range it is taken."""
    t.to_preop()
    for message, values in heard(t).items():
        name = t.codec(*message).name
        for wrong in out_of_range(t, message, values):
            frame = ahead(t, message, wrong.body)
            refused(t, [frame], f"{name}.{wrong.signal} = {wrong.value:g}")
        if message[0] in ACTING:
            continue
        before = t.beat().discarded
        for body in at_the_bounds(t, message, values):
            t.only(t.give(t.seal(*message, body)), (), f"{name} at an end of a range")
        t.equal(t.beat().discarded, before, f"discarded frames, {name} at the ends of its ranges")
    t.give(t.master_beat())
    t.state_is(NodeState.PREOP)


def for_others(t: Tester) -> None:
    """Frames for other nodes: not even a wrong one counts."""
    t.to_preop()
    before = t.beat().discarded
    for message, values in not_heard(t).items():
        frame = t.frame(*message, *values)
        damaged = Frame(frame.id, frame.data[:-1] + bytes((frame.data[-1] ^ 1,)))
        for sent in (frame, frame, damaged):
            t.only(t.give(sent), (), t.codec(*message).name)
    t.only(t.give(Frame(0x7FF, bytes(8))), (), "an identifier that nothing has")
    t.only(t.elapse(QUIET_S), ())
    t.equal(t.beat().discarded, before, "discarded frames")


def twice(t: Tester) -> None:
    """The same SYNC again is a duplicate."""
    t.configure()
    t.cycle = 11
    before = t.beat().discarded
    t.cycle += 1
    frame = t.frame(Sync, None, t.cycle, NodeState.PREOP, 0, t.wire.dbc_hash)
    t.only(t.give(frame), ("HEARTBEAT",), "SYNC 12")
    t.only(t.give(frame), (), "the same SYNC again")
    t.equal(t.beat().discarded - before, 1, "discarded frames")


def not_yet(t: Tester) -> None:
    """Without a configuration nothing moves."""
    t.configure()
    t.give(t.frame(Config, t.joint, Parameter.KP, 0, 1.0, 0))  # voids the set in force
    before = t.state_is(NodeState.PREOP)
    t.equal(before.config_hash, 0, "configuration hash")
    for command in (Command.HOME, Command.START, Command.STOP, Command.QUICKSTOP):
        t.only(t.command(command), (), f"{command.name} in PREOP")
        beat = t.state_is(NodeState.PREOP)
        told = (beat.config_hash, beat.error_register, beat.discarded - before.discarded)
        t.equal(told, (0, 0, 0), f"hash, faults, discarded frames after {command.name}")
    for state in NodeState:
        t.only(t.sync(state), ("HEARTBEAT",) if t.cycle % 12 == 0 else (), "SYNC in PREOP")
    t.configure()
    for command in (Command.START, Command.STOP, Command.QUICKSTOP):
        t.only(t.command(command), (), f"{command.name} in PREOP, configured")
        t.state_is(NodeState.PREOP)
    t.sync(NodeState.OPERATIONAL)
    t.only(t.measure() + t.setpoint() + t.errors(), (), "a whole cycle in PREOP")

"""Checks 43 to 49: stops, emergency stops, and what leads out of them."""

from typing import Final

from rfms_can.conform.checks.emergencies import emergency, noted, off, register, silent
from rfms_can.conform.checks.ladder import bare, operational
from rfms_can.conform.checks.presence import WINDOW
from rfms_can.conform.samples import flipped
from rfms_can.conform.talk import Answers
from rfms_can.conform.tester import Tester
from rfms_can.conform.vectors import set_hash
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import MASTER
from rfms_can.wire.records import Config, Estop, Heartbeat, Nmt, Sync
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState, Parameter

S, F, C = NodeState, FaultCode, Command
LARGEST_TOLD: Final = 1e9


def quickstop(t: Tester) -> None:
    """QUICKSTOP is left by RESET alone; the node keeps set and reference, and comes up again."""
    operational(t)
    t.only(t.command(C.QUICKSTOP), (), "QUICKSTOP")
    noted(t, S.QUICKSTOP)
    for command in (C.QUICKSTOP, C.START, C.STOP, C.HOME):
        t.only(t.command(command), (), f"{command.name} in QUICKSTOP")
        noted(t, S.QUICKSTOP)
        t.sync(S.QUICKSTOP)
        t.only(t.setpoint() + t.errors(), (), "a stop tells no error")
        t.one(t.measure(), "DAC", "a stop holds")
    t.only(t.command(C.RESET), (), "RESET")
    noted(t, S.PREOP)
    t.equal(t.beat().config_hash, set_hash(t.parameters), "configuration hash")
    t.only(t.sync() + t.measure() + t.setpoint() + t.errors(), (), "in PREOP")
    t.command(C.HOME)
    t.sync(S.HOMING)
    t.measure()
    t.one(t.reference(valid=0), "DAC", "its reference is known")
    t.state_is(S.READY)
    t.start()
    t.only(bare(t.run()), ("ERROR", "DAC"))
    t.only(bare(t.run(20)), ("ERROR", "DAC"))
    noted(t, S.OPERATIONAL)


def commands_in_operational(t: Tester) -> None:
    """RESET and HOME are not taken; the counters go on."""
    operational(t)
    for command in (C.RESET, C.HOME, C.START):
        t.only(t.command(command), (), f"{command.name} in OPERATIONAL")
        noted(t, S.OPERATIONAL)
    before = t.beat().discarded
    t.skip_counter(Nmt, None, WINDOW)
    t.send(t.frame(Nmt, None, C.QUICKSTOP, 0, 0))
    t.skip_counter(Nmt, None, -WINDOW - 1)
    t.equal(t.beat().discarded - before, 1, "discarded frames: counters were not restarted")
    t.only(bare(t.run()), ("ERROR", "DAC"))


def estop(t: Tester) -> None:
    """In each state: FAULT, EMCY, one DAC of zero where DACs went out, silence; once."""
    for state in (S.PREOP, S.HOMING, S.READY, S.OPERATIONAL, S.QUICKSTOP):
        brought_to(t, state)
        answers = t.estop()
        off(t, answers, _goes_off(state))
        emergency(t, answers, F.EMERGENCY_STOP, culprit=0, frame=0, value=0.0, bound=0.0)
        noted(t, S.FAULT, F.EMERGENCY_STOP)
        t.only(t.estop(), (), "ESTOP again")
        for command in (C.QUICKSTOP, C.START, C.STOP, C.HOME):
            t.only(t.command(command), (), f"{command.name} in FAULT")
            noted(t, S.FAULT, F.EMERGENCY_STOP)
        silent(t)
    # without a configuration there is nothing to switch off
    t.configure()
    t.say(Config, t.joint, Parameter.KP, 0, 1.0, 0)
    t.only(t.estop(), ("EMCY",), "ESTOP without a configuration")
    noted(t, S.FAULT, F.EMERGENCY_STOP)
    # nor where the joint is braked: a DAC would open its brake
    for state in (S.HOMING, S.READY):
        brought_to(t, state)
        t.sync(S.READY)
        off(t, t.estop(), ("EMCY",))
        silent(t)
    # out of damping: harder still
    operational(t)
    for _ in range(6):
        t.sync()
        t.measure()
    noted(t, S.FAULT, F.SETPOINT_MISSING)
    t.one(t.measure(), "DAC", "damping")
    off(t, t.estop())
    noted(t, S.FAULT, F.SETPOINT_MISSING, F.EMERGENCY_STOP)
    silent(t)


def _goes_off(state: NodeState) -> tuple[str, ...]:
    """What OFF sends out of a state that ``brought_to`` leads to."""
    return ("EMCY",) if state is S.PREOP else ("EMCY", "DAC")


def brought_to(t: Tester, state: NodeState) -> None:
    """A configured node in a state."""
    t.configure()
    t.sync(S.PREOP)
    if state is S.PREOP:
        return
    if state is S.HOMING:
        t.theta = -0.9
        t.command(C.HOME)
        t.sync(S.HOMING)
        return
    t.home()
    if state is S.READY:
        return
    t.start()
    t.run(2)
    if state is S.QUICKSTOP:
        t.command(C.QUICKSTOP)


def estop_frames(t: Tester) -> None:
    """A classic frame is as good; one bit wrong is no ESTOP."""
    t.configure()
    stop = t.frame(Estop, None, 0x504F5453, 0xAFB0ABAC)
    before = t.beat().discarded
    for number, data in enumerate(flipped(stop.data), 1):
        t.only(t.give(Frame(stop.id, data, number % 2 == 0)), (), "ESTOP, one bit wrong")
    t.equal(t.beat().discarded - before, 64, "discarded frames")
    noted(t, S.PREOP)
    answers = t.give(Frame(stop.id, stop.data, fd=False))
    off(t, answers, _goes_off(S.PREOP))
    noted(t, S.FAULT, F.EMERGENCY_STOP)
    # it has no counter: each is as good as the first
    before = t.beat().discarded
    t.only(t.give(stop, stop), (), "ESTOP twice more")
    t.equal(t.beat().discarded, before, "discarded frames after ESTOP once more")


def out_of_fault(t: Tester) -> None:
    """RESET forgives; the way up is the usual one."""
    for state in (S.OPERATIONAL, S.QUICKSTOP):
        brought_to(t, state)
        t.estop()
        t.only(bare(t.run(14)), (), "whole cycles do not enable it")
        t.state_is(S.FAULT)
        t.only(t.command(C.RESET), ())
        noted(t, S.PREOP)
        t.only(bare(t.run(2)), (), "nor in PREOP")
        t.home()
        t.start()
        t.only(bare(t.run(3)), ("ERROR", "DAC"))
        noted(t, S.OPERATIONAL)


def clean_record(t: Tester) -> None:
    """START forgets the faults of before, and so does RESET; the ladder begins at its foot."""
    t.configure()
    t.theta = -0.3
    t.command(C.HOME)
    t.row_set = 9  # rows that never came
    for _ in range(2):
        t.sync(S.HOMING)
        t.measure()
        t.reference(valid=0)
    noted(t, S.HOMING, F.ROWS_MISSING)
    t.row_set = 0
    t.sync(S.HOMING)
    t.measure()
    t.reference()
    noted(t, S.READY, F.ROWS_MISSING)
    t.start()
    noted(t, S.OPERATIONAL)
    t.row_set = 9
    t.run(2)
    noted(t, S.OPERATIONAL, F.ROWS_MISSING)
    t.only(t.command(C.STOP), ())
    noted(t, S.READY, F.ROWS_MISSING)
    t.start()
    noted(t, S.OPERATIONAL)
    t.row_set = 9
    t.only(bare(t.run(2)), ("ERROR", "DAC"), "two cycles after START: the ladder has begun again")
    # a cycle that a stop has cut short is not held against the next life
    for sampled, told in ((True, False), (False, True), (True, True)):
        operational(t)
        t.sync()
        if sampled:
            t.measure()
        if told:
            t.setpoint()
        t.command(C.QUICKSTOP)
        t.command(C.RESET)
        t.theta = -0.3
        t.command(C.HOME)
        t.sync(S.HOMING)
        noted(t, S.HOMING)


def register_bits(t: Tester) -> None:
    """A bit for each fault, held or not, and bit 0 for any."""
    operational(t)
    t.sync()
    t.measure()
    t.errors()  # no SETPOINT
    t.sync()
    t.setpoint()
    t.errors()  # no MEASURE
    t.sync()
    t.measure()
    t.setpoint()  # no ERROR of the others
    t.row_set = 77
    t.sync()  # no rows
    wanted = (F.SETPOINT_MISSING, F.MEASURE_MISSING, F.ERROR_MISSING, F.ROWS_MISSING)
    noted(t, S.OPERATIONAL, *wanted)
    t.row_set = 0
    t.measure()
    t.setpoint()
    t.errors()
    answers = t.estop()
    (told,) = answers.of("EMCY") or [None]
    t.equal(told and told.error_register, register(F.EMERGENCY_STOP, *wanted), "register in EMCY")
    t.command(C.RESET)
    noted(t, S.PREOP)


def another_dbc(t: Tester) -> None:
    """A SYNC of another layout: FAULT at once, and told once."""
    for state in (S.PREOP, S.READY, S.OPERATIONAL):
        brought_to(t, state)
        other = t.wire.dbc_hash ^ 0x10
        values = (state, 0, other)
        answers = t.say(Sync, None, 1200, *values)
        off(t, answers, _goes_off(state))
        emergency(
            *(t, answers, F.DBC_MISMATCH),
            culprit=MASTER,
            frame=t.codec(Sync).id,
            value=other,
            bound=t.wire.dbc_hash,
        )
        noted(t, S.FAULT, F.DBC_MISMATCH)
        t.only(t.say(Sync, None, 1212, *values), (), "such a SYNC again")
        t.command(C.RESET)
        noted(t, S.PREOP)
        t.only(t.sync(S.PREOP), ("HEARTBEAT",) if t.cycle % 12 == 0 else ())
        noted(t, S.PREOP)
    answers = t.say(Sync, None, t.cycle + 1, S.PREOP, 0, t.wire.dbc_hash ^ 1)
    off(t, answers, _goes_off(S.PREOP))
    noted(t, S.FAULT, F.DBC_MISMATCH)


def second_master(t: Tester) -> None:
    """A HEARTBEAT with another boot id does not take over from a master that drives: it stops."""
    operational(t)
    t.only(t.give(t.master_beat()), (), "the master's HEARTBEAT")
    _is_told(t, t.give(t.master_beat(0xBEEF)), 0xBEEF, t.boot_id)
    noted(t, S.QUICKSTOP, F.FOREIGN_MASTER)
    before = t.beat().discarded
    t.skip_counter(Nmt, None, WINDOW)
    t.send(t.frame(Nmt, None, C.RESET, 0, 0))
    t.skip_counter(Nmt, None, -WINDOW - 1)
    t.equal(t.beat().discarded - before, 1, "discarded frames: NMT of a second master")
    t.only(t.give(t.master_beat(0xBEEF)), (), "told once")
    t.sync(S.QUICKSTOP)
    t.one(t.measure(), "DAC", "the stop")
    t.only(t.give(t.master_beat()), (), "the first master's HEARTBEAT")
    noted(t, S.QUICKSTOP, F.FOREIGN_MASTER)
    # whose RESET was taken is the master
    operational(t)
    t.only(t.give(t.master_beat(0xBEEF)), (), "the first HEARTBEAT after RESET")
    noted(t, S.OPERATIONAL)
    _is_told(t, t.give(t.master_beat()), t.boot_id, 0xBEEF)
    noted(t, S.QUICKSTOP, F.FOREIGN_MASTER)


def _is_told(t: Tester, answers: Answers, boot_id: int, known: int) -> None:
    """EMCY of a HEARTBEAT; it tells no number beyond 1e9."""
    emergency(
        *(t, answers, F.FOREIGN_MASTER),
        culprit=MASTER,
        frame=t.codec(Heartbeat, MASTER).id,
        value=min(boot_id, LARGEST_TOLD),
        bound=min(known, LARGEST_TOLD),
    )

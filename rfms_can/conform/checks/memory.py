"""Checks 4c, 1b, 43c, 43d and 45b: what a node remembers of before, and what it does not."""

from rfms_can.conform.checks.emergencies import noted
from rfms_can.conform.checks.ladder import bare, operational
from rfms_can.conform.checks.presence import WINDOW
from rfms_can.conform.outcome import CheckSkipped
from rfms_can.conform.samples import heard
from rfms_can.conform.talk import Answers
from rfms_can.conform.tester import Tester
from rfms_can.wire.nodes import DBC_NAMES, MASTER
from rfms_can.wire.records import Heartbeat, Nmt
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState, Parameter

S, F, C = NodeState, FaultCode, Command


def first_life(t: Tester) -> None:
    """A node that was never RESET, and hears its master's HEARTBEAT first while it drives."""
    if t.power_on() is None:
        raise CheckSkipped("needs a line that switches the node on")
    t.cycle = t.row_set = 0
    t.theta, t.speed = -0.9, 0.0
    t.parameters = t.bench()
    answers = t.sync(S.OPERATIONAL) + t.setpoint() + t.measure() + t.errors()
    t.only(answers + t.reference(), (), "a whole cycle without a configuration")
    t.tell_parameters()
    t.only(t.command(C.HOME), ())
    t.only(t.sync(S.HOMING), ())
    noted(t, S.HOMING)
    t.only(t.setpoint() + t.errors(), (), "SETPOINT and ERROR before any MEASURE")
    t.only(t.measure(), ())
    t.one(t.reference(valid=0), "DAC")
    t.only(t.give(t.master_beat()), (), "the first HEARTBEAT of a master")
    t.only(t.sync(S.READY), ())
    t.only(t.give(t.master_beat()), (), "the same, READY")
    _leap(t, taken=False, why="the master has not started again")
    t.only(t.sync(S.HOMING) + t.measure(), ())
    t.one(t.reference(), "DAC")
    noted(t, S.READY)
    t.start()
    t.only(bare(t.run(2)), ("ERROR", "DAC"))
    noted(t, S.OPERATIONAL)
    # switched off before its first sample
    t.power_on()
    t.tell_parameters()
    t.command(C.HOME)
    t.sync(S.HOMING)
    (dac,) = t.estop().of("DAC") or [None]
    t.equal(dac and (dac.cycle, dac.current_dac), (0, 0), "DAC 0 without any sample")
    noted(t, S.FAULT, F.EMERGENCY_STOP)


def _leap(t: Tester, *, taken: bool, why: str) -> None:
    """NMT with a counter that no lost frames explain."""
    before = t.beat().discarded
    t.skip_counter(Nmt, None, WINDOW)
    t.send(t.frame(Nmt, None, C.STOP, 31, 0))
    if not taken:
        t.skip_counter(Nmt, None, -WINDOW - 1)
    t.equal(t.beat().discarded - before, 0 if taken else 1, f"discarded frames: {why}")


def master_that_restarts(t: Tester) -> None:
    """Another boot id: the next frame of each of the master's messages is taken, of no other's."""
    t.to_preop()
    messages = {m: v for m, v in heard(t).items() if m[0] is not Heartbeat}
    for boot_id, restarted in ((t.boot_id, False), (0xBEEF, True), (0xBEEF, False)):
        for message, values in messages.items():
            t.send(*(t.frame(*message, *values) for _ in range(2)))
        t.settle()
        t.send(t.master_beat(boot_id))
        for message, values in messages.items():
            before = t.beat().discarded
            masters = t.codec(*message).senders == {DBC_NAMES[MASTER]}
            taken = restarted and masters
            t.skip_counter(*message, 40)
            t.send(t.frame(*message, *values))
            if not taken:
                t.skip_counter(*message, -41)
            name = t.codec(*message).name
            told = f"discarded frames: {name}, its counter 41 on, boot id {boot_id:#x}"
            t.equal(t.beat().discarded - before, 0 if taken else 1, told)
            t.came()


def stop_within_a_cycle(t: Tester) -> None:
    """QUICKSTOP after MEASURE, or a step: no DAC is owed; before MEASURE: MEASURE is, and a DAC."""

    def quickstop() -> Answers:
        return t.command(C.QUICKSTOP)

    # the sample has been used: this cycle ends without a DAC, and that is no fault
    for before in ((t.measure,), (t.measure, t.setpoint), (t.setpoint, t.measure)):
        operational(t)
        t.sync()
        for say in before:
            say()
        t.only(quickstop() + t.errors() + t.setpoint(), (), "QUICKSTOP after MEASURE")
        t.only(bare(t.sync(S.QUICKSTOP)), ())
        noted(t, S.QUICKSTOP)
        t.one(t.measure(), "DAC", "the stop begins with the next sample")
    for sampled_last in (False, True):
        operational(t)
        t.sync()
        step = [lambda: t.setpoint(t.measured + 0.3), t.measure]
        answers = step[sampled_last]() + step[not sampled_last]()
        t.only(answers, ("EMCY",), "a step")
        t.only(bare(t.sync(S.QUICKSTOP)), ())
        noted(t, S.QUICKSTOP, F.SETPOINT_STEP)
    # the sample is yet to come
    operational(t)
    t.sync()
    t.only(t.setpoint() + quickstop() + t.errors(), (), "QUICKSTOP before MEASURE")
    t.only(bare(t.sync(S.QUICKSTOP)), ())
    noted(t, S.QUICKSTOP, F.MEASURE_MISSING)
    operational(t)
    t.sync()
    quickstop()
    t.one(t.measure(), "DAC", "MEASURE after QUICKSTOP")
    t.only(bare(t.sync(S.QUICKSTOP)), ())
    noted(t, S.QUICKSTOP)


def rows_forgotten(t: Tester) -> None:
    """Every way into PREOP forgets the rows, and RESET in PREOP; STOP there does not."""

    def gravity(number: int) -> None:
        row = t.own_first([1.0, *[0.0] * 5])
        t.rows(number, (*row, *[0.0] * 6, 1.2, number, 0, 0.0, 0, 0))

    def names_rows(number: int, *faults: FaultCode) -> None:
        t.theta = -0.9
        t.command(C.HOME)
        t.sync(S.HOMING, row_set=number)
        noted(t, S.HOMING, *faults)
        t.command(C.STOP)
        t.command(C.RESET)
        t.row_set = 0

    t.configure()
    for command, faults in ((C.STOP, ()), (C.RESET, (F.ROWS_MISSING,))):
        gravity(4)
        t.only(t.command(command), (), f"{command.name} in PREOP")
        names_rows(4, *faults)
    t.home()
    gravity(6)
    t.command(C.RESET)
    names_rows(6, F.ROWS_MISSING)
    gravity(7)
    t.tell_parameters({Parameter.KP: 40.0})
    names_rows(7, F.ROWS_MISSING)
    # a set in force is forgotten as well: SYNC must name set 0 again
    t.home()
    gravity(3)
    t.sync(S.HOMING)
    t.command(C.RESET)
    names_rows(3, F.ROWS_MISSING)


def cycle_of_dac_0(t: Tester) -> None:
    """DAC 0 is tagged with the cycle of the last sample, of any cycle where any is taken."""
    for command, state in ((None, S.OPERATIONAL), (C.QUICKSTOP, S.QUICKSTOP)):
        operational(t)
        t.run(1)
        sampled = t.cycle
        t.sync()
        if command is not None:
            t.command(command)
        (dac,) = t.estop().of("DAC") or [None]
        t.equal(dac and dac.cycle, sampled & 0xFF, f"cycle of DAC 0 in {state.name}")
        noted(t, S.FAULT, F.EMERGENCY_STOP)
    t.only(t.measure(cycle=t.cycle + 77), (), "MEASURE of another cycle in FAULT")
    sampled = t.cycle + 77
    t.command(C.RESET)
    t.only(t.measure(cycle=t.cycle + 50), (), "MEASURE of another cycle in PREOP")
    t.theta = -0.9
    t.command(C.HOME)
    t.sync(S.HOMING)
    (dac,) = t.estop().of("DAC") or [None]
    t.equal(dac and dac.cycle, sampled & 0xFF, "cycle of DAC 0 before the first sample of homing")

"""Checks 41 and 42: SYNCs that do not come, and numbers that are left out."""

from rfms_can.conform.checks.cycles import BARE
from rfms_can.conform.checks.emergencies import emergency, noted, silent, step_limit
from rfms_can.conform.checks.ladder import HOMED, bare, operational
from rfms_can.conform.outcome import CheckSkipped
from rfms_can.conform.tester import Tester
from rfms_can.wire.nodes import MASTER
from rfms_can.wire.records import Setpoint, Sync
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState, Parameter

S, F = NodeState, FaultCode


def no_sync(t: Tester) -> None:
    """By the node's own clock: overdue after 1.5 of what CONFIG says, then once each."""
    clocks = (2.0, Parameter.PERIOD), (1.0, Parameter.BARRIER), (0.0, Parameter.PERIOD)
    for clock, period in clocks:
        if not t.line.virtual and clock == 0.0:
            continue
        _no_sync(t, {Parameter.CLOCK: clock, period: 0.1})


def _no_sync(t: Tester, changes: dict[Parameter, float]) -> None:
    t.ready({**BARE, Parameter.PERIOD: 0.004, Parameter.BARRIER: 0.004, **changes})
    t.start()
    t.run(2)
    begin = t.sync_ns
    # each moment: units since SYNC, what has come since the one before, the state
    moments: tuple[tuple[float, tuple[str, ...], NodeState, int], ...] = (
        (1.3, (), S.OPERATIONAL, 0),
        (1.7, (), S.OPERATIONAL, 1),
        (3.3, (), S.OPERATIONAL, 1),
        (3.7, ("EMCY",), S.QUICKSTOP, 3),
        (5.3, (), S.QUICKSTOP, 0),
        (5.7, ("EMCY",), S.FAULT, 5),
        (25.3, (), S.FAULT, 0),
        (25.7, ("EMCY", "DAC"), S.FAULT, 25),
    )
    for units, names, state, missed in moments:
        t.line.pass_until(begin + round(units * 0.1e9))
        answers = t.settle()
        t.only(answers, names, f"{units} periods after the last SYNC")
        if names:
            emergency(
                *(t, answers, F.SYNC_MISSING),
                culprit=MASTER,
                frame=t.codec(Sync).id,
                value=missed,
                bound=missed,
            )
        noted(t, state, *((F.SYNC_MISSING,) if units > 1.5 else ()))
        if state is S.QUICKSTOP:
            t.one(t.measure(cycle=t.cycle + 3), "DAC", "MEASURE goes on without SYNC")
    silent(t)


def sync_returns(t: Tester) -> None:
    """Two SYNCs lost, one that comes, two lost: it goes on; READY and PREOP do not mind at all."""
    if not t.line.virtual:
        raise CheckSkipped("needs a line whose time the tester holds")
    operational(t)
    for _ in range(3):
        t.only(bare(t.sync(skip=2)), (), "SYNC after two that were lost")
        t.only(t.measure() + t.setpoint() + t.errors(), ("ERROR", "DAC"))
    noted(t, S.OPERATIONAL, F.SYNC_MISSING)
    t.ready()
    t.only(t.elapse(1.0), (), "READY without SYNC")
    noted(t, S.READY)
    t.configure()
    t.sync(S.PREOP)
    t.only(bare(t.elapse(1.0)), (), "PREOP without SYNC")
    noted(t, S.PREOP)
    t.command(Command.HOME)
    t.sync(S.HOMING)
    answers = t.elapse(0.0035 * 4 + 0.001)
    t.only(answers, ("EMCY",), "HOMING without SYNC")
    noted(t, S.PREOP, F.SYNC_MISSING)


def numbers_skipped(t: Tester) -> None:
    """SYNC leaves out three numbers, and the steps that are allowed grow with them."""
    for gap, allowed in ((1, 1), (2, 2), (4, 4), (9, 4)):
        for sign in (1.0, -1.0):
            for part, refused in ((0.995, False), (1.02, True)):
                t.operational({Parameter.CLOCK: 1.0, Parameter.BARRIER: 20.0}, theta=HOMED)
                t.run(3)
                at = t.measured
                bound = step_limit(t)
                t.cycle += gap - 1
                t.sync()
                t.measure()
                answers = t.setpoint(at + sign * part * allowed * bound)
                names = ("EMCY",) if refused else ("ERROR",)
                t.only(answers, names, f"{gap} cycles on, a step of {part} of {allowed} bounds")
                if refused:
                    emergency(
                        *(t, answers, F.SETPOINT_STEP),
                        culprit=MASTER,
                        frame=t.codec(Setpoint, 1).id,
                        value=sign * part * allowed * bound,
                        bound=allowed * bound,
                        tolerance=2e-5,
                    )
                    continue
                t.only(t.errors(), ("DAC",))
                noted(t, S.OPERATIONAL)

"""Checks 41 and 42: SYNCs that do not come, and numbers that are left out."""

from collections.abc import Callable
from typing import Final

from rfms_can.conform.checks.cycles import BARE
from rfms_can.conform.checks.emergencies import emergency, no_more_than, noted, silent, step_limit
from rfms_can.conform.checks.ladder import HOMED, bare, operational
from rfms_can.conform.outcome import CheckSkipped
from rfms_can.conform.talk import Answers
from rfms_can.conform.tester import Tester
from rfms_can.wire.nodes import MASTER
from rfms_can.wire.records import Setpoint, Sync
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState, Parameter

S, F = NodeState, FaultCode


def no_sync(t: Tester) -> None:
    """By the node's own clock: overdue after 1.5 of what CONFIG says, then once each period."""
    for clock in (2.0, 0.0):
        if t.line.virtual or clock != 0.0:
            _no_sync(t, {Parameter.CLOCK: clock, Parameter.PERIOD: 0.1}, 0.15)


def no_sync_in_lockstep(t: Tester) -> None:
    """The first after 1.5 BARRIER, whatever the period; then each period, whatever BARRIER."""
    for barrier in (0.1, 0.7):
        changes = {Parameter.CLOCK: 1.0, Parameter.BARRIER: barrier, Parameter.PERIOD: 0.1}
        _no_sync(t, changes, 1.5 * barrier)
    # where SYNC comes again, BARRIER holds again
    t.operational(changes)
    t.run(2)
    for _ in range(2):
        t.line.pass_until(t.sync_ns + round((1.5 * 0.7 + 0.13) * 1e9))
        t.only(t.settle(), (), "two SYNCs missed")
        t.only(bare(t.sync()) + t.setpoint() + t.measure() + t.errors(), ("ERROR", "DAC"))
    noted(t, S.OPERATIONAL, F.SYNC_MISSING)


def _no_sync(t: Tester, changes: dict[Parameter, float], first: float) -> None:
    """SYNC stays out; it is first overdue after so many seconds, then each 0.1 s."""
    t.ready({**BARE, **changes})
    t.start()
    t.run(2)
    begin = t.sync_ns
    # each moment: periods since SYNC was first overdue, what has come since the one before, state
    moments: tuple[tuple[float, tuple[str, ...], NodeState, int], ...] = (
        (-0.2, (), S.OPERATIONAL, 0),
        (0.2, (), S.OPERATIONAL, 1),
        (1.8, (), S.OPERATIONAL, 1),
        (2.2, ("EMCY",), S.QUICKSTOP, 3),
        (3.8, (), S.QUICKSTOP, 0),
        (4.2, ("EMCY",), S.FAULT, 5),
        (23.8, (), S.FAULT, 0),
        (24.2, ("EMCY", "DAC"), S.FAULT, 25),
    )
    for periods, names, state, missed in moments:
        t.line.pass_until(begin + round((first + 0.1 * periods) * 1e9))
        answers = t.settle()
        t.only(answers, names, f"{periods} periods after SYNC was first overdue")
        if names:
            emergency(
                *(t, answers, F.SYNC_MISSING),
                culprit=MASTER,
                frame=t.codec(Sync).id,
                value=missed,
                bound=missed,
            )
        noted(t, state, *((F.SYNC_MISSING,) if periods > 0.0 else ()))
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
    for gap in (1, 2, 3, 4):
        allowed = gap
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
                noted(t, S.OPERATIONAL, F.FOLLOWING_ERROR)  # by its rate, for a cycle


REAL: Final[dict[Parameter, float]] = {Parameter.CLOCK: 2.0, Parameter.PERIOD: 0.1}
"""Long periods on the node's own clock, so that a tester in real time meets them."""


def _sync_stays_out(t: Tester) -> Answers:
    """The watchdog runs off once; what comes."""
    t.line.pass_until(t.sync_ns + round(1.7 * REAL[Parameter.PERIOD] * 1e9))
    return t.settle()


def cycle_cut_short(t: Tester) -> None:
    """Where SYNC stays out, what the cycle before lacked is counted then, and once."""
    t.operational(REAL)
    t.run(2)
    parts: tuple[tuple[Callable[[], Answers], ...], ...]
    parts = (t.measure, t.setpoint, t.errors), (t.measure, t.setpoint), (t.measure,), ()
    lacking = (), (F.ERROR_MISSING,), (F.SETPOINT_MISSING,), (F.MEASURE_MISSING,)
    seen: set[FaultCode] = {F.SYNC_MISSING}
    for part, faults in zip(parts, lacking, strict=True):
        t.sync()
        for say in part:
            say()
        seen.update(faults)
        t.only(_sync_stays_out(t), (), "SYNC stays out")
        noted(t, S.OPERATIONAL, *seen)
    # twice without SETPOINT, SYNC in time after the second: two, not three
    t.only(bare(t.run()), ("ERROR", "DAC"))
    for late in (True, False):
        t.sync()
        t.measure()
        if late:
            _sync_stays_out(t)
    t.only(bare(t.sync()), (), "two cycles without SETPOINT")
    t.measure()
    t.only(bare(t.sync()), ("EMCY",), "three cycles without SETPOINT")
    noted(t, S.QUICKSTOP, *seen)


def encoder_meanwhile(t: Tester) -> None:
    """How far an encoder may have gone: a period for each SYNC that did not come, once."""
    held: Final = {Parameter.CLOCK: 1.0, Parameter.BARRIER: 20.0}
    for changes, gap, allowed in (
        *((REAL, 1, 2), (REAL, 2, 2), (REAL, 3, 3)),
        *((held, 1, 1), (held, 2, 2), (held, 4, 4)),
    ):
        for part, jumps in ((0.98, False), (1.02, True)):
            t.operational(changes, theta=HOMED)
            t.run(2)
            if changes is REAL:
                t.only(_sync_stays_out(t), ())
            t.cycle += gap - 1
            t.sync()
            t.move_to(t.theta + part * allowed * step_limit(t), no_more_than(t))
            t.only(t.measure(), ())
            told = (F.SYNC_MISSING,) if changes is REAL else ()
            noted(t, S.OPERATIONAL, *told, *((F.ENCODER_GLITCH,) if jumps else ()))


def after_start(t: Tester) -> None:
    """START counts as SYNC -1, whatever number SYNC had before: what is skipped then is held."""
    for first in (0, 1, 2):
        for part, refused in ((0.99, False), (1.01, True)):
            t.ready({Parameter.CLOCK: 1.0, Parameter.BARRIER: 20.0}, theta=HOMED)
            t.cycle = 40
            t.sync(S.READY)
            t.start()
            t.cycle += first
            t.sync()
            t.measure()
            answers = t.setpoint(t.measured + part * (1 + first) * step_limit(t))
            names = ("EMCY",) if refused else ("ERROR",)
            t.only(answers, names, f"SYNC {first} after START, a step of {part * (1 + first)}")

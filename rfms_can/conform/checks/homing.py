"""Checks 20 to 25: how a joint finds its zero."""

from typing import Final

from rfms_can.conform.checks.emergencies import FREE, emergency, noted, off, silent
from rfms_can.conform.tester import Tester
from rfms_can.wire.records import Dac, Reference
from rfms_can.wire.vocabulary import Command, ConfigStatus, FaultCode, NodeState, Parameter

S = NodeState
INTERVAL: Final = 1000.0 / 8000.0
"""Between two indexes of the bench, rad."""
QUARTER: Final = 0.25
"""Index intervals by which coarse position and index may disagree."""


def frames_of_homing(t: Tester) -> None:
    """One DAC a cycle, when MEASURE and then REFERENCE of this cycle are there."""
    t.configure()
    t.theta = -0.9
    t.only(t.command(Command.HOME), (), "HOME")
    t.cycle = -1
    beat = t.one(t.sync(S.HOMING), "HEARTBEAT", "with SYNC 0")
    t.equal(NodeState(beat.state).name, "HOMING", "state")
    for number in range(4):
        if number:
            t.only(t.sync(S.HOMING), ())
        if number != 1:
            t.only(t.measure(), (), "MEASURE alone")
            dac: Dac = t.one(t.reference(valid=0), "DAC", "REFERENCE")
            t.equal(dac.cycle, t.cycle & 0xFF, "cycle of DAC")
            t.equal(dac.force_dac, 0, "force DAC")
            continue
        t.only(t.reference(valid=0), (), "REFERENCE before MEASURE")
        t.only(t.measure(cycle=t.cycle - 1), (), "MEASURE of the cycle before")
        t.only(t.reference(valid=0), (), "REFERENCE without MEASURE of this cycle")
        t.only(t.measure(), (), "MEASURE after REFERENCE")
        t.only(t.reference(valid=0, cycle=t.cycle - 1), (), "REFERENCE of the cycle before")
        t.one(t.reference(valid=0), "DAC", "REFERENCE at last")
    t.only(t.setpoint() + t.errors(), (), "SETPOINT and ERROR in HOMING")
    for state in (S.PREOP, S.READY, S.QUICKSTOP, S.INIT, S.FAULT):
        t.only(t.sync(state) + t.measure() + t.reference(valid=0), (), f"SYNC {state.name}")
    t.state_is(S.HOMING)


def zero(t: Tester) -> None:
    """The count of joint angle 0, from an index that was seen anywhere."""
    for theta in (-2.0, -0.731, 0.0, 0.3125, 2.2):
        for away in (-3, 0, 2):
            for off_by in (-0.24, 0.0, 0.24):
                _found_at(t, theta, away, off_by * INTERVAL)


def _found_at(t: Tester, theta: float, away: int, off_by: float) -> None:
    t.configure()
    t.theta = theta
    t.zero = 17 - round(1e4 * theta)  # powered up anywhere
    t.command(Command.HOME)
    t.sync(S.HOMING)
    t.measure()
    place = (t.counts() - t.zero) // t.interval + away
    t.one(
        t.reference(coarse=t.coarse_code(theta + off_by), index_counts=place * t.interval + t.zero),
        "DAC",
    )
    t.state_is(S.READY)
    t.start()
    t.sync()
    t.measure()
    (error,) = t.setpoint().of("ERROR") or [None]
    if error is None:
        t.fail("nothing", "ERROR to the first SETPOINT after homing")
    t.near(error.error, 0.0, 1e-6, f"error at {theta} rad, index {away} intervals away")


def ambiguous(t: Tester) -> None:
    """A coarse position between two indexes, and one that does not move as the encoder does."""
    for sign in (1, -1):
        t.configure()
        t.theta = 0.3
        t.command(Command.HOME)
        t.sync(S.HOMING)
        t.measure()
        code = t.coarse_code(t.theta + sign * 0.3 * INTERVAL)
        told = code * t.parameters[Parameter.COARSE_PER_CODE] + t.parameters[Parameter.COARSE_ZERO]
        place = round(0.3 / INTERVAL) * t.interval
        answers = t.reference(coarse=code, index_counts=place + t.zero)
        residual = (told * 8000.0 - (t.counts() - t.zero - place)) / 1000.0
        off(t, answers)
        emergency(
            *(t, answers, FaultCode.HOMING_FAILED),
            culprit=t.joint,
            frame=t.codec(Reference, t.joint).id,
            value=abs(residual - round(residual)),
            bound=QUARTER,
            tolerance=1e-5,
        )
        noted(t, S.FAULT, FaultCode.HOMING_FAILED)
        silent(t)


def disagreeing(t: Tester) -> None:
    """Encoder and coarse position must move alike, within a quarter of an interval."""
    for sign in (1.0, -1.0):
        for moved, fails in ((0.24, False), (0.26, True)):
            t.configure(FREE)
            t.theta = -0.8
            t.command(Command.HOME)
            for _ in range(2):
                t.sync(S.HOMING)
                t.measure()
                t.one(t.reference(valid=0, coarse=t.coarse_code(-0.8)), "DAC")
            t.theta = -0.8 + sign * moved * INTERVAL
            t.sync(S.HOMING)
            t.measure()
            answers = t.reference(valid=0, coarse=t.coarse_code(-0.8))
            if not fails:
                t.one(answers, "DAC", f"{moved} intervals apart")
                t.state_is(S.HOMING)
                continue
            off(t, answers)
            t.equal([e.fault for e in answers.of("EMCY")], [FaultCode.HOMING_FAILED], "faults")
            noted(t, S.FAULT, FaultCode.HOMING_FAILED)


def given_up(t: Tester) -> None:
    """STOP, QUICKSTOP, RESET in HOMING lead to PREOP; HOME homes again."""
    t.configure()
    for command in (Command.STOP, Command.QUICKSTOP, Command.RESET):
        t.theta = -0.9
        t.command(Command.HOME)
        t.sync(S.HOMING)
        t.measure()
        t.one(t.reference(valid=0), "DAC")
        t.only(t.command(command), (), command.name)
        noted(t, S.PREOP)
        t.only(t.sync(S.HOMING) + t.measure() + t.reference(), (), "in PREOP")
    t.home(-0.9)


def held(t: Tester) -> None:
    """READY: the joint is held while SYNC says HOMING, and only then."""
    t.ready()
    for state in S:
        t.cycle = 12 * (t.cycle // 12) + 12
        answers = t.sync(state) + t.measure() + t.reference() + t.setpoint() + t.errors()
        t.only(answers, ("DAC",) if state is S.HOMING else (), f"READY, SYNC {state.name}")
    noted(t, S.READY)
    for command in (Command.STOP, Command.QUICKSTOP):
        t.only(t.command(command), ())
        noted(t, S.READY)
    # homed already: at once, even without an index
    t.only(t.command(Command.HOME), ())
    t.state_is(S.HOMING)
    t.sync(S.HOMING)
    t.measure()
    t.one(t.reference(valid=0), "DAC")
    noted(t, S.READY)
    t.only(t.command(Command.RESET), ())
    noted(t, S.PREOP)
    # the same set again, which is in force already, leaves the reference as it is
    t.equal(ConfigStatus(t.commit().status).name, "TAKEN", "answer to the same COMMIT")
    t.only(t.command(Command.HOME), ())
    t.sync(S.HOMING)
    t.measure()
    t.one(t.reference(valid=0), "DAC")
    noted(t, S.READY)

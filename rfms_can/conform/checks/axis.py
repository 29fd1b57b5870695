"""Checks 23 and 52k: a joint that moves, and what becomes of it when something breaks."""

import math
from collections.abc import Iterator
from typing import Final

from rfms_can.conform.axis import Axis, Fault, Sample
from rfms_can.conform.checks.emergencies import off
from rfms_can.conform.checks.ladder import bare
from rfms_can.conform.talk import Answers
from rfms_can.conform.tester import Tester
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState, Parameter

S, F, P = NodeState, FaultCode, Parameter

MOST_CODES: Final = 2047


def _frozen(true: Sample, first: Sample, _cycles: int) -> Sample:
    return true._replace(theta=first.theta)


def _encoder_reversed(true: Sample, first: Sample, _cycles: int) -> Sample:
    return true._replace(theta=2.0 * first.theta - true.theta)


def _runs_off(true: Sample, _first: Sample, cycles: int) -> Sample:
    return true._replace(theta=true.theta + 0.004 * cycles)


def _tachometer_reversed(true: Sample, _first: Sample, _cycles: int) -> Sample:
    return true._replace(speed=-true.speed)


def _tachometer_dead(true: Sample, _first: Sample, _cycles: int) -> Sample:
    return true._replace(speed=0.0)


def _tachometer_frozen(true: Sample, first: Sample, _cycles: int) -> Sample:
    return true._replace(speed=first.speed)


def _no_current(true: Sample, _first: Sample, _cycles: int) -> Sample:
    return true._replace(current=0)


ENCODERS: Final = (
    Fault("an encoder that stands", _frozen),
    Fault("an encoder that counts the other way", _encoder_reversed),
    Fault("an encoder that runs off", _runs_off),
)
MOTOR_REVERSED: Final = Fault("a motor that turns the other way", torque=lambda asked: -asked)
OTHERS: Final = (
    Fault("a tachometer that is turned round", _tachometer_reversed),
    Fault("a tachometer without a voltage", _tachometer_dead),
    Fault("a tachometer that shows one value", _tachometer_frozen),
    Fault("an amplifier that drives nothing", _no_current, torque=lambda _asked: 0.0),
    Fault("a motor that has all its torque", torque=lambda _asked: 12.0),
)
IN_HOMING: Final = frozenset((F.HOMING_FAILED, F.RUNAWAY, F.SENSOR_MISMATCH, F.SENSOR_STUCK))
IN_OPERATION: Final = frozenset(
    {F.SENSOR_MISMATCH, F.SENSOR_STUCK, F.AMPLIFIER_FAULT, F.FOLLOWING_ERROR, F.OVERSPEED}
    | {F.RUNAWAY, F.ENCODER_GLITCH}
)
"""Faults of which one must have taken the torque off: which, is a question of what came first."""
HOMING_WAY: Final = 0.15
"""How far a joint may go until its torque is off, rad: an index interval and a quarter."""
HOMING_CYCLES: Final = 120
FOUND_S: Final = 0.2
"""Time until the torque is off, in operation, s."""
EXCESS: Final = 0.25
"""Way beyond where it was to be then, rad."""
TURN_S: Final = 1.6
"""Of the motion there and back."""
AMPLITUDE: Final = 0.25
"""Of it, rad: at most 0.98 rad/s."""


class _Moved:
    """The tester with a joint that moves.

    Args:
        t: the tester, the node in PREOP or READY.
        theta: where the joint stands, rad.
    """

    def __init__(self, t: Tester, theta: float) -> None:
        self.t = t
        self.axis = Axis(t.parameters, theta)
        self._spoken = False

    def begin(self, state: NodeState) -> Answers:
        """SYNC, and MEASURE of where the joint has come to."""
        t = self.t
        answers = t.sync(state)
        self.axis.period(t.current, self._spoken)
        told = self.axis.sample(t.current)
        t.theta = told.theta
        codes = round(told.speed / t.parameters[P.RATE_PER_CODE])
        speed_code = max(-MOST_CODES, min(MOST_CODES, codes))
        self.coarse = t.coarse_code(told.coarse)
        return answers + t.measure(
            current=told.current, speed_code=speed_code, braked=int(told.braked)
        )

    def ended(self, answers: Answers) -> Answers:
        """The cycle is over: did the joint hear a DAC?"""
        self._spoken = "DAC" in answers.names
        return bare(answers)


# --- homing ---------------------------------------------------------------------------------------


def homing(t: Tester) -> None:
    """A sound joint finds its index; one with a broken part loses its torque in time."""
    for theta in (-0.9, 0.9):
        _homes(t, theta, None)
        for fault in (*ENCODERS, MOTOR_REVERSED):
            for cycle in (0, 12, 40):
                _homes(t, theta, fault, cycle)


def _homes(t: Tester, theta: float, fault: Fault | None, cycle: int = 0) -> None:
    t.configure()
    t.zero = -1234
    t.only(t.command(Command.HOME), ())
    moved = _Moved(t, theta)
    where = fault.name if fault else "a sound joint"
    index: int | None = None
    for number in range(HOMING_CYCLES):
        if fault is not None and number == cycle:
            moved.axis.begin(fault)
            begin = moved.axis.theta
        answers = moved.begin(S.HOMING)
        if fault is None and index is None and number > 60:
            index = (t.counts() - t.zero) // t.interval * t.interval + t.zero
        found = {} if index is None else {"index_counts": index}
        answers += t.reference(valid=int(index is not None), coarse=moved.coarse, **found)
        answers = moved.ended(answers)
        if "EMCY" in answers.names:
            _is_off(t, answers, fault, where, IN_HOMING)
            t.near(moved.axis.theta, begin, HOMING_WAY, f"{where}: the joint has come to")
            return
        t.only(answers, ("DAC",), f"{where}, cycle {number} of homing")
    t.equal(fault, None, f"{where}: a fault within {HOMING_CYCLES} cycles; what is wrong")
    t.state_is(S.READY)


def _is_off(
    t: Tester, answers: Answers, fault: Fault | None, where: str, among: frozenset[FaultCode]
) -> None:
    told = [F(e.fault) for e in answers.of("EMCY")]
    if fault is None or not set(told) <= among:
        t.fail(f"{where}: {[f.name for f in told]}", "none" if fault is None else "another fault")
    off(t, answers)
    t.state_is(S.FAULT)


# --- operation ------------------------------------------------------------------------------------


def _motion(t: Tester) -> Iterator[float]:
    """There and back, twice, from rest, rad."""
    period = t.parameters[P.PERIOD]
    for k in range(round(2.0 * TURN_S / period)):
        x = 2.0 * math.pi * k * period / TURN_S
        yield 0.5 * AMPLITUDE * (1.0 - math.cos(x))


def operation(t: Tester) -> None:
    """A sound joint moves there and back; one that breaks on the way loses its torque in time."""
    _operates(t, None, 0)
    for fault in (*ENCODERS, MOTOR_REVERSED, *OTHERS):
        for cycle in (60, 230):
            _operates(t, fault, cycle)


def _operates(t: Tester, fault: Fault | None, cycle: int) -> None:
    t.ready()
    t.start()
    moved = _Moved(t, t.theta)
    where = fault.name if fault else "a sound joint"
    last = cycle + round(FOUND_S / t.parameters[P.PERIOD])
    for number, goal in enumerate(_motion(t)):
        if fault is not None and number == cycle:
            moved.axis.begin(fault)
        answers = moved.begin(S.OPERATIONAL)
        state = t.beat().state if "EMCY" in answers.names else S.OPERATIONAL
        if state == S.OPERATIONAL:
            answers += t.setpoint(goal) + t.errors()
        answers = moved.ended(answers)
        if "EMCY" in answers.names:
            _is_off(t, answers, fault, where, IN_OPERATION)
            t.near(moved.axis.theta, goal, EXCESS, f"{where}: the joint has come to")
            return
        t.only(answers, ("ERROR", "DAC"), f"{where} since cycle {cycle}, cycle {number}")
        if fault is not None and number == last:
            t.fail(f"{where}: nothing for {FOUND_S} s", "torque off")
    t.equal(fault, None, "what is wrong")
    t.equal(t.state_is(S.OPERATIONAL).error_register, 0, "error register of a sound joint")

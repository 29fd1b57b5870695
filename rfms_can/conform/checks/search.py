"""Checks 22c, 22d and 22e: the limits of the search for the index, and its direction."""

from collections.abc import Mapping
from typing import Final

from rfms_can.conform.checks.cycles import BARE
from rfms_can.conform.checks.emergencies import FREE, emergency, noted, off
from rfms_can.conform.checks.ladder import bare
from rfms_can.conform.talk import Answers
from rfms_can.conform.tester import Tester
from rfms_can.wire.records import Dac, Measure, Reference
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState, Parameter

S, F, P = NodeState, FaultCode, Parameter
Changes = Mapping[Parameter, float]

WEAK: Final = {P.TORQUE_LIMIT: 1.0, P.INTEGRAL_LIMIT: 0.5, P.CONTINUOUS_TORQUE: 0.5}
"""A motor whose torque the search needs at once."""
STUCK: Final = {**WEAK, P.STUCK_TIME: 0.03}
STUCK_CYCLES: Final = 8
"""0.03 s in whole cycles of 4 ms."""
TIME: Final = {**FREE, P.HOMING_TIME: 0.11}
TIME_CYCLES: Final = 28
RIGID: Final = (1.0, *[0.0] * 5)
"""Own element of a rigid law first."""
EXACT: Final = {
    **FREE,
    P.COUNTS_PER_UNIT: 8192.0,
    P.INDEX_INTERVAL_COUNTS: 1024.0,
    P.COARSE_PER_CODE: 2.0**-9,
    P.COARSE_ZERO: -3.0,
}
"""A quarter of an index interval is 256 counts, 16 coarse codes and 2^-5 rad, to the bit."""
QUARTER: Final = 256
CODE: Final = 2.0**-9
MIDDLES: Final = ((-2.5, 2.75), (-1.0, 4.0), (-4.0, 1.5))
"""Ranges whose middles a coarse code meets to the bit: 0.125, 1.5 and -1.25 rad."""


def _begin(t: Tester, changes: Changes, theta: float = -0.9) -> None:
    t.configure(changes)
    t.theta, t.speed = theta, 0.0
    t.only(t.command(Command.HOME), ())


def _cycle(t: Tester, **reference: int) -> Answers:
    """A cycle of the search; by default the joint is where it was, and no index has come."""
    answers = t.sync(S.HOMING) + t.measure()
    return bare(answers + t.reference(**{"valid": 0, **reference}))


def _goes_on(t: Tester, cycles: int, why: str, counts: float = 0.0) -> None:
    """Cycles in which the joint moves on by so many counts, and nothing is wrong."""
    for number in range(cycles):
        t.theta += counts / t.parameters[P.COUNTS_PER_UNIT]
        t.only(_cycle(t), ("DAC",), f"{why}, cycle {number}")


def _fails(
    t: Tester, answers: Answers, record: type[Measure] | type[Reference], value: float, bound: float
) -> None:
    off(t, answers)
    emergency(
        *(t, answers, F.HOMING_FAILED),
        culprit=t.joint,
        frame=t.codec(record, t.joint).id,
        value=value,
        bound=bound,
    )
    noted(t, S.FAULT, F.HOMING_FAILED)


def limits(t: Tester) -> None:
    """A search ends after HOMING_TIME, and after STUCK_TIME at the torque limit; not before."""
    _too_long(t)
    _stands(t)
    _stands_for_no_fault(t)


def _too_long(t: Tester) -> None:
    """The cycles of the search count, one by one; HOME begins again, a pause does not."""
    _begin(t, TIME)
    step = t.parameters[P.HOMING_SPEED] * t.parameters[P.PERIOD] * t.parameters[P.COUNTS_PER_UNIT]
    for pause in (0, 10):
        _goes_on(t, pause, "before a pause", step)
        for _ in range(2):
            t.only(bare(t.sync(S.READY) + t.measure()), (), "a pause")
        _goes_on(t, TIME_CYCLES - pause, "searching", step)
        period = t.parameters[P.PERIOD]
        value, bound = (TIME_CYCLES + 1) * period, TIME_CYCLES * period
        _fails(t, _cycle(t), Reference, value, bound)
        t.only(t.command(Command.RESET) + t.command(Command.HOME), ())


def _stands(t: Tester) -> None:
    """No count although the whole torque is on; one count begins it again, and so does HOME."""
    _begin(t, STUCK)
    period = t.parameters[P.PERIOD]
    for before in (0, 6, STUCK_CYCLES + 1):
        _goes_on(t, before, "standing")
        t.theta += 1.0 / t.parameters[P.COUNTS_PER_UNIT]
        _goes_on(t, STUCK_CYCLES + 1, "standing after a count")
        value, bound = (STUCK_CYCLES + 1) * period, STUCK_CYCLES * period
        _fails(t, _cycle(t), Measure, value, bound)
        t.only(t.command(Command.RESET) + t.command(Command.HOME), ())


def _stands_for_no_fault(t: Tester) -> None:
    """Within its torque limit a joint may stand, and at the limit as long as nothing is cut."""
    _begin(t, {P.STUCK_TIME: 0.03})
    _goes_on(t, STUCK_CYCLES + 6, "standing with torque to spare")
    for gravity in (1.0, -1.0):
        for viscous, stands in ((0.0, False), (0.0025, True)):
            _begin(t, {**STUCK, **BARE, P.KP: 0.0, P.VISCOUS: viscous}, -0.9 * gravity)
            t.rows(1, (*t.own_first(RIGID), *[0.0] * 6, gravity, 1, 0, 0.0, 0, 0))
            why = f"gravity {gravity}, the limit, and friction {viscous}"
            _goes_on(t, STUCK_CYCLES + 1, why)
            t.only(_cycle(t), ("EMCY", "DAC") if stands else ("DAC",), why)


def direction(t: Tester) -> None:
    """Upwards below the middle of the range by the coarse position, downwards from it on."""
    friction = {P.COULOMB_POSITIVE: 1.2, P.COULOMB_NEGATIVE: 0.9}
    for low, high in MIDDLES:
        middle = round((0.5 * (low + high) + 3.0) / CODE)
        for code in (middle - 40, middle - 1, middle, middle + 1, middle + 40):
            for resting in (0.4, 0.25):  # HOMING_SPEED is 0.4, and at FRICTION_SPEED it rests
                changes = {P.POSITION_MIN: low, P.POSITION_MAX: high, P.FRICTION_SPEED: resting}
                _begin(t, {**EXACT, **BARE, **changes, **friction, P.KD: 2.0})
                up = code < middle
                t.only(bare(t.sync(S.HOMING) + t.measure()), ())
                dac: Dac = t.one(t.reference(valid=0, coarse=code), "DAC")
                p = t.parameters
                speed = p[P.HOMING_SPEED] if up else -p[P.HOMING_SPEED]
                torque = (p[P.KP] * p[P.PERIOD] + p[P.KD]) * speed
                if resting < 0.3:
                    torque += 1.2 if up else -0.9
                why = f"coarse code {code}, the middle {middle}, FRICTION_SPEED {resting}: DAC"
                t.near(dac.current_dac, torque / p[P.TORQUE_PER_CODE], 0.6, why)


def to_the_bit(t: Tester) -> None:
    """A quarter of an interval belongs to what is taken; a count more does not."""
    for sign in (1, -1):
        for more, fails in ((0, False), (1, True)):
            away = sign * (QUARTER + more)
            value, bound = (QUARTER + more) / 8192.0, QUARTER / 8192.0
            # the encoder moves, the coarse position does not
            _begin(t, EXACT, -0.75)
            coarse = t.coarse_code()
            _goes_on(t, 2, "before")
            t.sync(S.HOMING)
            t.measure(counts=t.counts() + away)
            answers = bare(t.reference(valid=0, coarse=coarse))
            if fails:
                _fails(t, answers, Reference, value, bound)
            else:
                t.only(answers, ("DAC",), f"{away} counts apart")
                noted(t, S.HOMING)
            # coarse position beside an index
            _begin(t, EXACT, 0.0)
            answers = _cycle(t, valid=1, index_counts=t.counts() + away)
            if fails:
                _fails(t, answers, Reference, (QUARTER + 1) / 1024.0, 0.25)
            else:
                t.only(answers, ("DAC",), f"an index {away} counts away")
                noted(t, S.READY)

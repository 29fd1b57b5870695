"""Checks 52 to 52e: what a joint does not believe of its sample, to the cycle."""

from collections.abc import Callable, Iterator
from typing import Final

from rfms_can.conform.checks.cycles import BARE
from rfms_can.conform.checks.emergencies import count, emergency, noted, off, silent
from rfms_can.conform.checks.ladder import bare
from rfms_can.conform.talk import Answers
from rfms_can.conform.tester import Tester
from rfms_can.wire.records import JointError, Measure
from rfms_can.wire.vocabulary import FaultCode, NodeState, Parameter

S, F, P = NodeState, FaultCode, Parameter

SETTLED: Final = 6
"""Cycles at rest: five DACs of a joint are known then."""
COMPLYING: Final = (1.0, *[0.0] * 11, 0.0, 1, 0, 0.0, 1, 1)
"""Identity, selected: an error of its rate is no fault."""
Motion = Iterator[tuple[float, float]]
"""Encoder's way, in counts, and the tachometer's speed, rad/s, cycle by cycle."""


def emergency_of(
    t: Tester, answers: Answers, fault: FaultCode, value: float, bound: float, *others: FaultCode
) -> None:
    """EMCY of what a joint finds wrong with its own sample or drive."""
    emergency(
        *(t, answers, fault),
        culprit=t.joint,
        frame=t.codec(Measure, t.joint).id,
        value=value,
        bound=bound,
        others=others,
        tolerance=1e-5,
    )


def complying(t: Tester, theta: float = 0.0) -> None:
    """OPERATIONAL at rest, the arm complying."""
    t.operational(theta=theta)
    t.rows(1, (*t.own_first(COMPLYING[:6]), *COMPLYING[6:]))
    t.run(SETTLED)


def _sample(t: Tester, counts: float, speed: float) -> Answers:
    """A cycle up to MEASURE: the encoder goes so many counts, the tachometer tells a speed."""
    t.theta += counts * count(t)
    t.speed = speed
    return bare(t.sync() + t.measure())


def _goes_on(t: Tester, answers: Answers, why: str, goal: float | None = None) -> None:
    """The rest of a cycle in which nothing is wrong with the sample; by default its own goal."""
    t.only(answers + t.setpoint(goal) + t.errors(), ("ERROR", "DAC"), why)


# --- tachometer and encoder -----------------------------------------------------------------------


class _Sums:
    """What the page says of SENSOR_MISMATCH, counted beside the node."""

    def __init__(self, t: Tester) -> None:
        self._p = t.parameters
        self._up = self._down = self._before = 0.0
        self.off = 0.0

    def differ(self, moved: float, v: float) -> bool:
        """Whether the sums have passed their bound, after a cycle's way, rad, at a speed, rad/s."""
        tau, fastest = self._p[P.PERIOD], self._p[P.SPEED_LIMIT]
        d = moved - tau * (v + self._before) / 2
        s = tau * (0.01 * fastest + 0.05 * max(abs(v), abs(self._before)))
        self._up = max(0.0, self._up + d - s)
        self._down = max(0.0, self._down - d - s)
        self._before, self.off = v, d / tau
        return max(self._up, self._down) > 3 * tau * self._p[P.TACHOMETER_LIMIT]


def tachometer(t: Tester) -> None:
    """A difference that lasts is found to the cycle; a tachometer that is 5 % off is sound."""
    for sign in (1.0, -1.0):
        _mismatch(t, ((0.0, sign * 0.9 - 0.002 * k) for k in range(40)), found=True)
        _mismatch(t, ((sign * 20.0, 0.002 * (1 + k % 3)) for k in range(40)), found=True)
        _mismatch(t, ((sign * 20.0, -sign * 0.5 - 0.002 * (k % 3)) for k in range(40)), found=True)
        # 28 counts a cycle are 0.875 rad/s
        slow = 0.95 * 0.875 - 0.02
        _mismatch(t, ((sign * 28.0, sign * slow) for _ in range(90)), found=False)
    # now too much, now too little: neither lasts
    _mismatch(t, ((0.0, 0.9 if k % 4 < 2 else -0.9) for k in range(90)), found=False)


def _mismatch(t: Tester, motion: Motion, *, found: bool) -> None:
    complying(t, -0.3)
    sums = _Sums(t)
    for number, (counts, speed) in enumerate(motion):
        before = t.measured
        answers = _sample(t, counts, speed)
        if sums.differ(t.measured - before, t.measured_speed):
            off(t, answers)
            emergency_of(t, answers, F.SENSOR_MISMATCH, sums.off, t.parameters[P.TACHOMETER_LIMIT])
            noted(t, S.FAULT, F.SENSOR_MISMATCH)
            silent(t)
            t.equal(found, True, "a tachometer that is found wrong")
            return
        _goes_on(t, answers, f"cycle {number}: {counts} counts at {speed:.3f} rad/s", -0.3)
    t.equal(found, False, "a tachometer that is found wrong")
    noted(t, S.OPERATIONAL)


def one_value(t: Tester) -> None:
    """One code while the encoder's way of a cycle varies by more than a tenth of the fastest."""
    for sign in (1.0, -1.0):
        for speed, ways in ((0.0, (0, 9, 0, 0, 9)), (0.3, (10, 10, 19, 12, 10))):
            for more, stuck in ((0, False), (1, True)):
                complying(t)
                for way in ways[:-1]:
                    _goes_on(t, _sample(t, sign * way, sign * speed), f"{way} counts", 0.0)
                t.sync()  # a cycle without a sample ends no row, and is not compared
                t.setpoint(0.0)
                t.errors()
                answers = _sample(t, sign * 2 * ways[0], sign * speed)
                _goes_on(t, answers, "after a cycle without", 0.0)
                answers = _sample(t, sign * (ways[2] if speed else 9) + sign * more, sign * speed)
                if not stuck:
                    _goes_on(t, answers, "nine counts of difference", 0.0)
                    noted(t, S.OPERATIONAL, F.MEASURE_MISSING)
                    continue
                _stuck(t, answers, 10.0)


def _stuck(t: Tester, answers: Answers, counts: float) -> None:
    off(t, answers)
    p = t.parameters
    rate = count(t) / p[P.PERIOD]
    bound = 0.1 * p[P.SPEED_LIMIT] + 3.0 * rate
    emergency_of(t, answers, F.SENSOR_STUCK, counts * rate, bound, F.MEASURE_MISSING)
    noted(t, S.FAULT, F.MEASURE_MISSING, F.SENSOR_STUCK)


# --- converters, speed ----------------------------------------------------------------------------


def rails(t: Tester) -> None:
    """A tachometer at its rail: the encoder's rate takes its place; damping after three."""
    for code in (2047, -2048):
        complying(t)
        for cycles in (2, 3):
            for number in range(1, cycles + 1):
                t.sync()
                answers = t.measure(speed_code=code)
                if number == 3:
                    t.only(answers, ("EMCY", "DAC"), f"the third code {code}")
                    emergency_of(t, answers, F.ADC_SATURATED, value=code, bound=2047.0)
                    noted(t, S.FAULT, F.ADC_SATURATED)
                    break
                error: JointError = t.one(answers + t.setpoint(), "ERROR", f"code {code}")
                t.near(error.error_rate, 0.0, 1e-6, f"error rate, velocity_adc {code}")
                t.errors()
            else:
                t.only(bare(t.run()), ("ERROR", "DAC"), "a good cycle")
                noted(t, S.OPERATIONAL, F.ADC_SATURATED)
    for code in (2046, -2047):
        t.operational({P.SPEED_LIMIT: 4.0})
        t.run(SETTLED)
        t.sync()
        t.only(t.measure(speed_code=code), (), f"code {code}, which is no rail")
        noted(t, S.OPERATIONAL)
    _explained_rail(t)


def _explained_rail(t: Tester) -> None:
    """A current at its rail that the DACs ask for is none; one that they do not is two faults."""
    t.operational({**BARE, P.TORQUE_PER_CODE: 0.005})
    for number, gravity in enumerate((2.5, 5.0, 7.5, 10.0), 1):
        t.rows(number, (*t.own_first(COMPLYING[:6]), *[0.0] * 6, gravity, number, 0, 0.0, 0, 0))
        t.run(1)
    t.run(SETTLED)
    for _ in range(4):
        _goes_on(t, bare(t.sync() + t.measure(current=2047)), "10 Nm are 2000 codes")
    noted(t, S.OPERATIONAL)
    _goes_on(t, bare(t.sync() + t.measure(current=-2048)), "for a cycle")
    noted(t, S.OPERATIONAL, F.ADC_SATURATED, F.AMPLIFIER_FAULT)


def overspeed(t: Tester) -> None:
    """One cycle is borne, two in a row are not."""
    for sign in (1, -1):
        for codes, faults in (((1498, 1490), ()), ((1502, 1490), (F.OVERSPEED,))):
            complying(t)
            for code in codes:
                t.sync()
                answers = t.measure(speed_code=sign * code)
                _goes_on(t, answers, f"velocity_adc {sign * code}")
            noted(t, S.OPERATIONAL, *faults)
        complying(t)
        t.sync()
        _goes_on(t, t.measure(speed_code=sign * 1502), "one cycle")
        t.sync()
        answers = t.measure(speed_code=sign * 1503)
        off(t, answers)
        p = t.parameters
        speed = sign * 1503 * p[P.RATE_PER_CODE]
        emergency_of(t, answers, F.OVERSPEED, value=speed, bound=p[P.OVERSPEED_LIMIT])
        noted(t, S.FAULT, F.OVERSPEED)
        silent(t)


# --- the amplifier --------------------------------------------------------------------------------


def amplifier(t: Tester) -> None:
    """A current beyond what the last five DACs explain: once, and twice in a row."""
    for gravity in (1.2, -1.2, 0.0):
        for high in (True, False):
            for cycles in (1, 2):
                _driven(t, gravity, high, cycles)
    _five_dacs(t, "START")
    _five_dacs(t, "a sample with braked")


def _loaded(t: Tester, gravity: float) -> None:
    """At rest, the torque gravity alone."""
    t.operational(BARE)
    t.rows(1, (*t.own_first(COMPLYING[:6]), *[0.0] * 6, gravity, 1, 0, 0.0, 0, 0))
    t.run(SETTLED)


def _driven(t: Tester, gravity: float, high: bool, cycles: int) -> None:
    _loaded(t, gravity)
    code = round(gravity / t.parameters[P.TORQUE_PER_CODE])
    tolerance = 2048 * t.parameters[P.CURRENT_TOLERANCE] + 0.1 * abs(code)
    border = code + tolerance if high else code - tolerance
    inside, beyond = int(border // 1) + (not high), int(border // 1) + high
    _goes_on(t, bare(t.sync() + t.measure(current=inside)), f"{inside} codes, {code} asked for")
    for number in range(1, cycles + 1):
        answers = bare(t.sync() + t.measure(current=beyond))
        if number == 1:
            _goes_on(t, answers, f"{beyond} codes, {code} asked for")
            continue
        off(t, answers)
        emergency_of(t, answers, F.AMPLIFIER_FAULT, value=beyond, bound=border)
        noted(t, S.FAULT, F.AMPLIFIER_FAULT)
        silent(t)
        return
    _goes_on(t, bare(t.sync() + t.measure()), "a good cycle")
    _goes_on(t, bare(t.sync() + t.measure(current=beyond)), "one more")
    noted(t, S.OPERATIONAL, F.AMPLIFIER_FAULT)


def _five_dacs(t: Tester, after: str) -> None:
    """Nothing is compared before five DACs are known."""
    begins: dict[str, Callable[[], Answers]] = {
        "START": lambda: t.measure(current=900),
        "a sample with braked": lambda: t.measure(current=900, braked=1),
    }
    if after == "START":
        t.ready(BARE)
        t.sync(S.READY)
        t.measure()  # it does not drive: its DACs are forgotten
        t.start()
    else:
        _loaded(t, 0.0)
    for number in range(5):
        t.sync()
        sample = begins[after] if number == 0 else lambda: t.measure(current=900)
        _goes_on(t, bare(sample()), f"{number} DACs since {after}")
    noted(t, S.OPERATIONAL)
    _goes_on(t, bare(t.sync() + t.measure(current=900)), f"five DACs since {after}")
    noted(t, S.OPERATIONAL, F.AMPLIFIER_FAULT)

"""Checks 39c, 52f to 52h: a joint that does not follow, turn or cool; where a stop begins."""

from typing import Final

from rfms_can.conform.checks.cycles import BARE
from rfms_can.conform.checks.emergencies import count, noted, off, silent, step_limit
from rfms_can.conform.checks.ladder import bare
from rfms_can.conform.checks.sensing import COMPLYING, SETTLED, complying, emergency_of
from rfms_can.conform.talk import Answers
from rfms_can.conform.tester import Tester
from rfms_can.wire.contract import BIAS_BELONGS, JOINT_SETPOINT_BELONGS
from rfms_can.wire.records import Bias, Dac
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState, Parameter

S, F, P, C = NodeState, FaultCode, Parameter, Command

FREE_RUN: Final = (*(0.05 * k for k in range(1, 18)), *[0.9] * 40)
"""Speeds of a set-point that begins to move, rad/s: its rate is never 1 rad/s."""


# --- following ------------------------------------------------------------------------------------


def following(t: Tester) -> None:
    """Two cycles in a row with an error, or its rate, beyond the bound; not while it complies."""
    for sign in (1.0, -1.0):
        _too_far(t, sign)
        for codes, faults in (((498, 499, 498), ()), ((502, 0, 502), (F.FOLLOWING_ERROR,))):
            t.operational()
            t.run(SETTLED)
            for code in codes:
                t.sync()
                answers = t.measure(speed_code=round(sign * code)) + t.setpoint() + t.errors()
                t.only(bare(answers), ("ERROR", "DAC"), f"velocity_adc {sign * code}")
            noted(t, S.OPERATIONAL, *faults)
        _too_fast(t, sign)
        complying(t)
        for code in (502, 503, 504):
            t.sync()
            answers = t.measure(speed_code=round(sign * code)) + t.setpoint() + t.errors()
            t.only(bare(answers), ("ERROR", "DAC"), "while the arm complies")
        noted(t, S.OPERATIONAL)
        _stop_too_fast(t, sign)


def _too_fast(t: Tester, sign: float) -> None:
    t.operational()
    t.run(SETTLED)
    t.sync()
    answers = t.measure(speed_code=round(sign * 502)) + t.setpoint() + t.errors()
    t.only(bare(answers), ("ERROR", "DAC"), "the first")
    t.sync()
    answers = t.measure(speed_code=round(sign * 503)) + t.setpoint()
    off(t, answers)
    p = t.parameters
    bound = p[P.RATE_ERROR_LIMIT] * p[P.SPEED_LIMIT]
    emergency_of(t, answers, F.FOLLOWING_ERROR, value=-sign * 503 * p[P.RATE_PER_CODE], bound=bound)
    noted(t, S.FAULT, F.FOLLOWING_ERROR)
    silent(t)


def _too_far(t: Tester, sign: float) -> None:
    """The set-point goes, the joint stands."""
    t.operational()
    t.run(SETTLED)
    goal, limit, missed = t.measured, t.parameters[P.FOLLOWING_ERROR_LIMIT], 0
    for speed in (*FREE_RUN, *[FREE_RUN[-1]] * 40):
        goal += sign * speed * t.parameters[P.PERIOD]
        t.sync()
        t.measure()
        answers = t.setpoint(goal)
        missed = missed + 1 if abs(goal - t.measured) > limit else 0
        if missed == 2:
            break
        t.only(answers + t.errors(), ("ERROR", "DAC"), f"the set-point {goal} rad away")
    off(t, answers)
    emergency_of(t, answers, F.FOLLOWING_ERROR, value=goal - t.measured, bound=limit)
    noted(t, S.FAULT, F.FOLLOWING_ERROR)


def _stop_too_fast(t: Tester, sign: float) -> None:
    """On the stop ramp a joint must not be faster than it was, by more than the bound."""
    for first, codes, stopped in (
        (0, (498, 499), False),
        (200, (698, 699), False),
        (0, (502, 503), True),
    ):
        t.operational()
        t.run(SETTLED)
        t.sync()
        t.measure(speed_code=round(sign * first))
        t.setpoint()
        t.errors()
        t.command(C.QUICKSTOP)
        for number, code in enumerate(codes):
            answers = bare(t.sync(S.QUICKSTOP) + t.measure(speed_code=round(sign * code)))
            if not (stopped and number):
                t.only(answers, ("DAC",), f"a stop that began at {first}, velocity_adc {code}")
                continue
            off(t, answers)
            p = t.parameters
            bound = p[P.RATE_ERROR_LIMIT] * p[P.SPEED_LIMIT]
            emergency_of(
                t, answers, F.FOLLOWING_ERROR, value=sign * code * p[P.RATE_PER_CODE], bound=bound
            )
            noted(t, S.FAULT, F.FOLLOWING_ERROR)


# --- where a stop begins --------------------------------------------------------------------------


def stop_begins(t: Tester) -> None:
    """Its ramp is never faster than the joint is, or was told to be, and begins at the joint."""
    for sign in (1.0, -1.0):
        for speed, ramp in ((0.4, 0.4), (0.9, 0.85), (-0.3, 0.0), (0.0, 0.0)):
            for by_step in (True, False):
                _ramp_of(t, sign * speed, sign * ramp, sign, by_step=by_step)
        for lag, found in ((5, 5), (24, 24), (60, 24)):
            _place_of(t, sign * lag, sign * found)


def _moving(t: Tester, sign: float) -> None:
    """A set-point that goes at 0.85 rad/s, the joint with it."""
    for speed in FREE_RUN[:20]:
        t.move_to(t.theta + sign * min(speed, 0.85) * t.parameters[P.PERIOD])
        t.sync()
        t.measure()
        t.only(t.setpoint(t.theta) + t.errors(), ("ERROR", "DAC"), "a motion")


def _ramp_of(t: Tester, speed: float, ramp: float, sign: float, *, by_step: bool) -> None:
    """The torque is the derivative's alone: of the ramp's speed less the joint's."""
    t.operational({**BARE, P.KP: 0.0, P.KD: 5.0})
    _moving(t, sign)
    t.speed = speed
    t.sync()
    t.measure()
    if by_step:
        t.only(t.setpoint(t.theta + 2.0 * step_limit(t)), ("EMCY",), "a step")
    else:
        t.command(C.QUICKSTOP)
    t.sync(S.QUICKSTOP)
    dac: Dac = t.one(t.measure(), "DAC", "the stop")
    p = t.parameters
    change = p[P.ACCELERATION_LIMIT] * p[P.PERIOD]
    after = max(0.0, abs(ramp) - change) * (1.0 if ramp > 0.0 else -1.0)
    want = 5.0 * (after - t.measured_speed) / p[P.TORQUE_PER_CODE]
    t.near(dac.current_dac, want, 2.0, f"DAC of a stop, the joint at {speed} rad/s")


def _place_of(t: Tester, lag: float, found: float) -> None:
    """The torque is the proportional term's alone: of how far from the joint the stop begins."""
    t.operational(BARE)
    t.run(2)
    goal = t.measured
    for step in range(1, 13):
        t.theta = goal - lag * step / 12 * count(t)
        t.speed = 0.002 * (step % 3)  # the encoder's ways are small, and not all alike
        t.sync()
        t.measure()
        t.only(t.setpoint(goal) + t.errors(), ("ERROR", "DAC"), "behind its set-point")
    t.command(C.QUICKSTOP)
    t.speed = 0.0
    t.sync(S.QUICKSTOP)
    dac: Dac = t.one(t.measure(), "DAC", "the stop")
    want = t.parameters[P.KP] * found * count(t) / t.parameters[P.TORQUE_PER_CODE]
    t.near(dac.current_dac, want, 0.6 + abs(want) * 0.03, f"DAC of a stop {lag} counts behind")


# --- a motor that does not turn, or gets hot ------------------------------------------------------

STALLING: Final = {**BARE, P.KP: 0.0, P.STALL_TIME: 0.018}
STALL_CYCLES: Final = 5
"""0.018 s in whole cycles of 4 ms."""
LOAD: Final = 2.4
"""Gravity, Nm; with a bias of 7.7 beyond the torque limit of 10."""


def _pushes(t: Tester, bias: float, code: int = 0) -> Answers:
    """A cycle with a bias torque, Nm; what comes of it."""
    t.sync()
    answers = t.measure(speed_code=code)
    told = [0.0] * 6
    told[t.index] = bias
    frames = (
        t.setpoint_frame(JOINT_SETPOINT_BELONGS | BIAS_BELONGS),
        t.angles_frame(t.measured),
        t.frame(Bias, None, *told, t.cycle & 0xFF),
    )
    return bare(answers + t.give(*frames) + t.errors())


def _pushing(t: Tester, changes: dict[Parameter, float]) -> None:
    t.operational(changes)
    t.rows(1, (*t.own_first(COMPLYING[:6]), *[0.0] * 6, LOAD, 1, 0, 0.0, 0, 0))
    t.run(SETTLED)


def stall(t: Tester) -> None:
    """All of its torque for STALL_TIME, at rest: damping; motion or less torque begins again."""
    _pushing(t, STALLING)
    for last in ((7.7, 25), (7.5, 0)):  # it turns; its torque is not cut
        for _ in range(STALL_CYCLES):
            t.only(_pushes(t, 7.7), ("ERROR", "DAC"), "pushing")
        t.only(_pushes(t, *last), ("ERROR", "DAC"), f"bias {last[0]} Nm, velocity_adc {last[1]}")
    for number in range(STALL_CYCLES):
        t.only(_pushes(t, 7.7, number % 2 * 15), ("ERROR", "DAC"), "pushing again")
    answers = _pushes(t, 7.7)
    t.only(answers, ("ERROR", "EMCY", "DAC"), "its torque goes out all the same")
    p = t.parameters
    emergency_of(t, answers, F.STALL, value=(STALL_CYCLES + 1) * p[P.PERIOD], bound=p[P.STALL_TIME])
    noted(t, S.FAULT, F.STALL)


def overload(t: Tester) -> None:
    """The heat of the torque that went out, cycle by cycle; it stays through RESET and START."""
    hot = {**BARE, P.KP: 0.0, P.CONTINUOUS_TORQUE: 4.0, P.OVERLOAD_TIME: 0.07}
    _pushing(t, hot)
    tau, continuous = t.parameters[P.PERIOD], t.parameters[P.CONTINUOUS_TORQUE]
    limit = t.parameters[P.TORQUE_LIMIT]
    bound = t.parameters[P.OVERLOAD_TIME] * (limit**2 - continuous**2)
    heat, cycles = 0.0, 0
    while heat <= bound:
        t.only(_pushes(t, 6.0), ("ERROR", "DAC"), f"heat {heat} of {bound}")
        heat += tau * ((LOAD + 6.0) ** 2 - continuous**2)
        cycles += 1
    answers = bare(t.sync())
    t.only(answers, ("EMCY",), f"after {cycles} cycles")
    emergency_of(t, answers, F.OVERLOAD, value=heat, bound=bound)
    noted(t, S.FAULT, F.OVERLOAD)
    # a motor does not cool by a command
    t.command(C.RESET)
    t.home()
    t.start()
    t.rows(1, (*t.own_first(COMPLYING[:6]), *[0.0] * 6, LOAD, 1, 0, 0.0, 0, 0))
    t.only(_pushes(t, 6.0), ("ERROR", "DAC"), "after RESET")
    answers = bare(t.sync())
    t.only(answers, ("EMCY",), "hot still")
    noted(t, S.FAULT, F.OVERLOAD)
    # at rest it cools, and a configuration is a new motor
    _pushing(t, {**hot, P.KD: 0.001})
    for _ in range(cycles - 1):
        t.only(_pushes(t, 6.0), ("ERROR", "DAC"), "a new configuration")
    noted(t, S.OPERATIONAL)

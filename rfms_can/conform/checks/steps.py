"""Checks 39 and 40: set-points and encoders that step, and the end of the range."""

import math
from typing import Final

from rfms_can.conform.checks.emergencies import (
    count,
    emergency,
    no_more_than,
    noted,
    off,
    step_limit,
)
from rfms_can.conform.checks.ladder import HOMED, bare, operational
from rfms_can.conform.tester import Tester
from rfms_can.wire.nodes import MASTER
from rfms_can.wire.records import JointError, Measure, Setpoint
from rfms_can.wire.vocabulary import FaultCode, NodeState, Parameter

S, F = NodeState, FaultCode
RATE_FRACTION: Final = 0.2
"""Of SPEED_LIMIT: by which the rate of a set-point may change."""
SOFT_MARGIN: Final = 0.02
HARD_MARGIN: Final = 0.05
"""Beyond the range, rad: where a motion may come to rest, and where torque goes off."""


def setpoint_step(t: Tester) -> None:
    """Nothing of a step beyond the bound acts; one just inside is taken. Holding widens it."""
    for sign in (1.0, -1.0):
        for held in range(3):
            for part, refused in ((0.995, False), (1.005, True), (25.0, True)):
                operational(t)
                before = t.measured
                for _ in range(held):
                    t.sync()
                    t.measure()
                    t.errors()
                bound = step_limit(t) * (1 + held)
                t.sync()
                t.measure()
                answers = t.setpoint(before + sign * part * bound)
                if not refused:
                    t.only(answers, ("ERROR",), f"a step of {part} of the bound")
                    continue
                t.only(answers, ("EMCY",), f"a step of {part} of the bound")
                emergency(
                    *(t, answers, F.SETPOINT_STEP),
                    culprit=MASTER,
                    frame=t.codec(Setpoint, 1).id,
                    value=sign * part * bound,
                    bound=bound,
                    others=(F.SETPOINT_MISSING,) if held else (),
                    tolerance=2e-5,
                )
                t.state_is(S.QUICKSTOP)
                t.only(t.errors(), (), "no DAC of the step")
                t.sync(S.QUICKSTOP)
                t.one(t.measure(), "DAC", "the stop")


def step_after_holding(t: Tester) -> None:
    """A set-point that is taken ends the holding: the next step is bounded as ever."""
    operational(t)
    for _ in range(2):
        t.sync()
        t.measure()
        t.errors()
    before = t.measured
    t.only(bare(t.run()), ("ERROR", "DAC"), "a good cycle after two that were held")
    t.sync()
    t.measure()
    answers = t.setpoint(before + 1.005 * step_limit(t))
    t.only(answers, ("EMCY",), "a step of 1.005 of the bound")
    t.state_is(S.QUICKSTOP)


def rate_step(t: Tester) -> None:
    """A rate that changes by more than 0.2 of the fastest is a step, after four set-points."""
    for sign in (1.0, -1.0):
        for cycles, part, refused in ((6, 0.98, False), (6, 1.02, True), (3, 1.02, False)):
            _rate_step(t, sign, cycles, part, refused=refused)
        # a cycle that was held begins again
        for good, refused in ((3, False), (4, True)):
            t.operational(theta=HOMED)
            t.run(5)
            t.sync()
            t.measure()
            t.errors()
            t.only(bare(t.run(good)), ("ERROR", "DAC"))
            _stepped(t, sign * 1.02, refused=refused, others=(F.SETPOINT_MISSING,))


def _rate_step(t: Tester, sign: float, cycles: int, part: float, *, refused: bool) -> None:
    t.operational(theta=HOMED)
    t.run(cycles)
    _stepped(t, sign * part, refused=refused)


def _stepped(t: Tester, part: float, *, refused: bool, others: tuple[FaultCode, ...] = ()) -> None:
    """The set-point goes on from rest at so many bounds; its rate is 11/6 of the first step."""
    p = t.parameters
    bound = RATE_FRACTION * p[Parameter.SPEED_LIMIT]
    t.sync()
    t.measure()
    way = part * bound * 6.0 / 11.0 * p[Parameter.PERIOD]
    answers = t.setpoint(t.measured + way)
    if not refused:
        t.only(answers + t.errors(), ("ERROR", "DAC"), f"a rate that steps by {part} of the bound")
        return
    t.only(answers, ("EMCY",), f"a rate that steps by {part} of the bound")
    emergency(
        *(t, answers, F.SETPOINT_STEP),
        culprit=MASTER,
        frame=t.codec(Setpoint, 1).id,
        value=part * bound,
        bound=bound,
        others=others,
        tolerance=1e-3,
    )
    noted(t, S.QUICKSTOP, F.SETPOINT_STEP, *others)


def too_far(t: Tester) -> None:
    """An error that ERROR cannot say is a step, however small the step."""
    t.operational({Parameter.PERIOD: 1.0}, theta=-1.0)
    t.run(2)
    t.sync()
    t.move_to(1.01)
    t.measure()
    answers = t.setpoint(-1.0)
    t.only(answers, ("EMCY",), "an error of 2.01 rad")
    t.equal([e.fault for e in answers.of("EMCY")], [F.SETPOINT_STEP], "faults")


def encoder_jump(t: Tester) -> None:
    """A step that no joint can make is predicted over, twice; then the joint stops."""
    for sign in (1.0, -1.0):
        operational(t)
        bound = step_limit(t)
        inside = int(bound / count(t)) - 1
        for counts in (inside, -inside):
            t.speed = math.copysign(no_more_than(t), counts)
            t.sync()
            t.measure(counts=t.counts() + counts)
            error: JointError = t.one(t.setpoint(), "ERROR")
            t.near(error.error, -counts * count(t), 1e-6, "error of a step that a joint can make")
            t.errors()
            for speed in (-t.speed, 0.0):  # back again, and at rest
                t.speed = speed
                t.run(1)
        noted(t, S.OPERATIONAL)
        jump = round(sign * (bound / count(t) + 2))
        t.speed = 0.2 * sign
        for number in (1, 2):
            t.sync()
            t.measure(counts=t.counts() + number * jump)
            told: JointError = t.one(t.setpoint(), "ERROR")
            way = (number - 1) * t.measured_speed * t.parameters[Parameter.PERIOD]
            t.near(told.error, -way, 1e-6, f"error of prediction {number}")
            t.only(t.errors(), ("DAC",))
        noted(t, S.OPERATIONAL, F.ENCODER_GLITCH)
        t.sync()
        answers = t.measure(counts=t.counts() + 3 * jump)
        t.only(answers, ("EMCY", "DAC"), "a third jump")
        emergency(
            *(t, answers, F.ENCODER_GLITCH),
            culprit=t.joint,
            frame=t.codec(Measure, t.joint).id,
            value=3 * jump * count(t) - t.measured_speed * t.parameters[Parameter.PERIOD],
            bound=bound,
            tolerance=1e-5,
        )
        noted(t, S.QUICKSTOP, F.ENCODER_GLITCH)


def encoder_unseen(t: Tester) -> None:
    """After a cycle without MEASURE an encoder may have gone twice as far."""
    for sign in (1, -1):
        operational(t)
        inside = int(1.95 * step_limit(t) / count(t))
        t.sync()
        t.setpoint()
        t.errors()
        t.sync()
        t.measure(counts=t.counts() + sign * inside)
        error: JointError = t.one(t.setpoint(), "ERROR")
        t.near(error.error, -sign * inside * count(t), 1e-6, "error after a cycle without MEASURE")
        noted(t, S.OPERATIONAL, F.MEASURE_MISSING)
        operational(t)
        t.speed = 0.1
        t.run(1)
        for number in (1, 2):
            t.sync()
            t.measure(counts=t.counts() + sign * 400 * number)
            t.setpoint()
            t.errors()
        t.sync()
        t.setpoint()
        t.errors()
        t.sync()
        answers = t.measure(counts=t.counts() + sign * 1600)
        moved = 2.0 * t.measured_speed * t.parameters[Parameter.PERIOD]
        emergency(
            *(t, answers, F.ENCODER_GLITCH),
            culprit=t.joint,
            frame=t.codec(Measure, t.joint).id,
            value=sign * 1600 * count(t) - moved,
            bound=2.0 * step_limit(t),
            others=(F.MEASURE_MISSING,),
            tolerance=1e-5,
        )


def encoder_returns(t: Tester) -> None:
    """Two jumps, one good sample, two jumps: never three in a row."""
    operational(t)
    for _ in range(3):
        for number in (1, 2):
            t.sync()
            t.measure(counts=t.counts() + 500 * number)
            t.only(t.setpoint() + t.errors(), ("ERROR", "DAC"))
        t.only(bare(t.run()), ("ERROR", "DAC"))
    noted(t, S.OPERATIONAL, F.ENCODER_GLITCH)


def end_of_range(t: Tester) -> None:
    """0.02 rad beyond the range it stops, 0.05 rad torque goes off; it stops where it must."""
    p = t.bench()
    for end, sign in ((p[Parameter.POSITION_MAX], 1.0), (p[Parameter.POSITION_MIN], -1.0)):
        _creeps_out(t, end, sign)
        _rushes_out(t, end + sign * SOFT_MARGIN, sign)
        _is_sent_out(t, end + sign * SOFT_MARGIN, sign)


def _creeps_out(t: Tester, end: float, sign: float) -> None:
    """Three counts a cycle: too slow for a motion away from the set-point."""
    t.operational(theta=end)
    t.run(2)
    start, at, state = t.measured, 0, S.OPERATIONAL
    per_speed2 = 0.5 / t.parameters[Parameter.ACCELERATION_LIMIT]
    hard = round(HARD_MARGIN / count(t))
    while at <= hard:
        at += 3
        t.move_to(start + sign * at * count(t))
        rest = at * count(t) + per_speed2 * t.measured_speed**2
        answers = bare(t.sync(state) + t.measure())
        if state is S.OPERATIONAL and rest <= SOFT_MARGIN:
            t.only(answers + t.setpoint(end) + t.errors(), ("ERROR", "DAC"), f"{at} counts beyond")
        elif state is S.OPERATIONAL:
            t.only(answers, ("EMCY", "DAC"), f"{at} counts beyond the range")
            t.equal([e.fault for e in answers.of("EMCY")], [F.SOFT_LIMIT], "faults")
            noted(t, S.QUICKSTOP, F.SOFT_LIMIT)
            state = S.QUICKSTOP
        elif at <= hard:
            t.only(answers, ("DAC",), f"{at} counts beyond the range, stopping")
    off(t, answers)
    edge = end + sign * HARD_MARGIN
    told = dict(culprit=t.joint, frame=0, value=t.measured, bound=edge, tolerance=1e-5)
    emergency(t, answers, F.HARD_LIMIT, **told, others=(F.SOFT_LIMIT,))  # type: ignore[arg-type]
    noted(t, S.FAULT, F.SOFT_LIMIT, F.HARD_LIMIT)


def _rushes_out(t: Tester, edge: float, sign: float) -> None:
    """A joint that is pushed towards the end of its range, and was not told to go there."""
    deceleration = t.bench()[Parameter.ACCELERATION_LIMIT]
    way = 0.5 * 1.5**2 / deceleration
    for short, stops in ((0.003, False), (-0.003, True)):
        t.operational(theta=edge - sign * (way + short))
        t.run(1)
        t.speed = sign * 1.5
        t.sync()
        answers = t.measure()
        if not stops:
            t.only(answers, (), "fast, but far enough from the edge")
            continue
        t.only(answers, ("EMCY", "DAC"), "too fast for the way that is left")
        rest = t.measured + sign * 0.5 * t.measured_speed**2 / deceleration
        told = dict(culprit=t.joint, frame=0, value=rest, bound=edge, tolerance=1e-4)
        emergency(t, answers, F.SOFT_LIMIT, **told)  # type: ignore[arg-type]
        noted(t, S.QUICKSTOP, F.SOFT_LIMIT)


def _is_sent_out(t: Tester, edge: float, sign: float) -> None:
    """A set-point that runs to the end of the range, and a joint that follows: the master's."""
    t.operational(theta=edge - sign * 0.25)
    t.run(2)
    deceleration = t.parameters[Parameter.ACCELERATION_LIMIT]
    for number, speed in enumerate((*(0.05 * k for k in range(1, 29)), *[1.4] * 40)):
        ahead = sign * min(0.02, 0.0002 * number)
        t.move_to(t.measured + sign * speed * t.parameters[Parameter.PERIOD])
        rest = t.measured + sign * 0.5 * t.measured_speed**2 / deceleration
        answers = bare(t.sync() + t.measure())
        if sign * (rest - edge) > 0.0:
            break
        answers += t.setpoint(t.measured + ahead) + t.errors()
        t.only(answers, ("ERROR", "DAC"), f"{rest} rad is inside")
    t.only(answers, ("EMCY", "DAC"), f"{rest} rad is beyond the range")
    told = dict(culprit=MASTER, frame=t.codec(Setpoint, 1).id, value=rest, bound=edge)
    emergency(t, answers, F.SOFT_LIMIT, **told, tolerance=1e-5)  # type: ignore[arg-type]
    noted(t, S.QUICKSTOP, F.SOFT_LIMIT)

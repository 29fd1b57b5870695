"""Checks 39 and 40: set-points and encoders that step, and the end of the range."""

from rfms_can.conform.checks.emergencies import count, emergency, noted, off, step_limit
from rfms_can.conform.checks.ladder import bare, operational
from rfms_can.conform.tester import Tester
from rfms_can.wire.nodes import MASTER, PLANT
from rfms_can.wire.records import JointError, Measure, Setpoint
from rfms_can.wire.vocabulary import FaultCode, NodeState, Parameter

S, F = NodeState, FaultCode


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


def too_far(t: Tester) -> None:
    """An error that ERROR cannot say is a step, however small the step."""
    t.operational({Parameter.PERIOD: 1.0}, theta=-1.0)
    t.run(2)
    t.sync()
    t.theta = 1.01
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
            t.sync()
            t.measure(counts=t.counts() + counts)
            error: JointError = t.one(t.setpoint(), "ERROR")
            t.near(error.error, -counts * count(t), 1e-6, "error of a step that a joint can make")
            t.errors()
            t.run(1)
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
            culprit=PLANT,
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
            culprit=PLANT,
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
    """0.05 rad beyond the range torque goes off; where only a stop can keep it, it stops."""
    p = t.bench()
    ends = (p[Parameter.POSITION_MAX], 1.0), (p[Parameter.POSITION_MIN], -1.0)
    for end, sign in ends:
        edge = end + sign * 0.05
        for beyond, fault in ((-2, None), (2, F.HARD_LIMIT)):
            t.operational(theta=end)
            t.run(2)
            # towards the edge in steps that a joint can make, with halts: else it runs away
            for part in (0.2, 0.2, 0.4, 0.4, 0.6, 0.6, 0.8, 0.8):
                t.theta = end + sign * 0.05 * part
                t.sync()
                t.measure()
                t.setpoint(end)
                t.errors()
            t.theta = edge + sign * beyond * count(t)
            t.sync()
            answers = t.measure()
            if fault is None:
                t.only(answers, (), "short of the edge")
                noted(t, S.OPERATIONAL)
                continue
            off(t, answers)
            told = dict(culprit=t.joint, frame=0, value=t.measured, bound=edge, tolerance=1e-5)
            emergency(t, answers, fault, **told)  # type: ignore[arg-type]
            noted(t, S.FAULT, fault)
        way = 0.5 * 1.5**2 / p[Parameter.ACCELERATION_LIMIT]
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
            rest = t.measured + sign * 0.5 * t.measured_speed**2 / p[Parameter.ACCELERATION_LIMIT]
            told = dict(culprit=t.joint, frame=0, value=rest, bound=edge, tolerance=1e-4)
            emergency(t, answers, F.SOFT_LIMIT, **told)  # type: ignore[arg-type]
            noted(t, S.QUICKSTOP, F.SOFT_LIMIT)

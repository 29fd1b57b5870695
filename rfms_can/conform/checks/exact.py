"""Checks 40g and 40h: bounds met to the bit, with parameters that are powers of two."""

import math
from collections.abc import Mapping, Sequence
from typing import Final

from rfms_can.conform.checks.emergencies import emergency, no_more_than, noted, off, step_limit
from rfms_can.conform.checks.ladder import bare
from rfms_can.conform.tester import Tester
from rfms_can.wire.contract import COMPLY_BELONGS, JOINT_SETPOINT_BELONGS
from rfms_can.wire.nodes import MASTER
from rfms_can.wire.records import Comply, JointError, Setpoint
from rfms_can.wire.vocabulary import FaultCode, NodeState, Parameter

S, F, P = NodeState, FaultCode, Parameter

EXACT: Final = {P.PERIOD: 2.0**-8, P.COUNTS_PER_UNIT: 8192.0, P.KP: 640.0}
"""A step of 1.5 SPEED_LIMIT PERIOD is 96 counts; a runaway's error is more than 64."""
STEP: Final = 96
AT: Final = 0.125
ULP: Final = 2.0**-26
"""Twice the distance of float32 numbers at the set-points here."""
FAST: Final = {P.SPEED_LIMIT: 20.0, P.RATE_PER_CODE: 0.01, P.ACCELERATION_LIMIT: 1000.0}
"""Motion away is then more than 32 counts a cycle, and fast more than 320."""
Steps = Sequence[tuple[int, int]]
RUNAWAYS: Final[tuple[tuple[Mapping[Parameter, float], Steps], ...]] = (
    ({}, [(0, n) for n in (40, 64, 84, 104, 124, 144, 164)]),  # 64 counts do not count
    (FAST, [(0, n) for n in (40, 80, 116, 152, 188, 224)]),  # 36 is 0.9 of 40: not braked
    (FAST, [(0, n) for n in (60, 381, 702)]),  # 321 are fast
)
"""Counts of set-point and encoder from where they were; at the last the torque goes off."""
NONE: Final[tuple[tuple[Mapping[Parameter, float], Steps], ...]] = (
    (FAST, [(0, 60 + 32 * n) for n in range(9)]),  # 32 counts are no motion
    (FAST, [(0, n) for n in (60, 380, 700, 1020, 1020)]),  # 320 are not fast
    (FAST, [(0, 40), (0, 80), (0, 80), *((33 * n, 80 + 33 * n) for n in range(1, 8))]),
)
"""In the last the set-point goes with the joint: the error does not grow."""


def steps(t: Tester) -> None:
    """A step of the bound is taken, of encoder and set-point; the next number beyond is not."""
    for sign in (1, -1):
        for lost in (0, 1):
            for more in (0, 1):
                _encoder_step(t, lost, sign * (STEP * (1 + lost) + more), jumps=more > 0)
            for ulp in (0.0, ULP):
                _set_point_step(t, lost, sign, ulp)


def _encoder_step(t: Tester, lost: int, counts: int, *, jumps: bool) -> None:
    """The encoder is elsewhere, after so many cycles without MEASURE."""
    t.operational(EXACT, AT)
    t.run(2)
    for _ in range(lost):
        t.sync()
        t.setpoint()
        t.errors()
    t.sync()
    t.speed = math.copysign(no_more_than(t), counts)
    t.measure(counts=t.counts() + counts)
    error: JointError = t.one(t.setpoint(), "ERROR", f"an encoder {counts} counts away")
    t.near(error.error, 0.0 if jumps else -counts / 8192.0, 1e-6, "error")
    faults = (*((F.MEASURE_MISSING,) * lost), *((F.ENCODER_GLITCH,) if jumps else ()))
    noted(t, S.OPERATIONAL, *faults)


def _set_point_step(t: Tester, lost: int, sign: int, more: float) -> None:
    """The set-point steps by the bound, and ``more``, after so many cycles without one."""
    t.operational(EXACT, AT)
    t.run(2)
    for _ in range(lost):
        t.sync()
        t.measure()
        t.errors()
    bound = step_limit(t) * (1 + lost)
    t.sync()
    t.measure()
    answers = t.setpoint(AT + sign * (bound + more))
    t.only(answers, ("EMCY",) if more else ("ERROR",), f"a step of {bound} + {more}")
    if more:
        emergency(
            *(t, answers, F.SETPOINT_STEP),
            culprit=MASTER,
            frame=t.codec(Setpoint, 1).id,
            value=sign * (bound + more),
            bound=bound,
            others=(F.SETPOINT_MISSING,) * lost,
        )


def displaced_steps(t: Tester) -> None:
    """COMPLY is part of the set-point that steps: held it steps by nothing, whatever it is."""
    for sign in (1, -1):
        for part, refused in ((0.0, False), (0.98, False), (1.02, True)):
            t.operational(EXACT, AT)
            t.run(1)  # four set-points in a row, and the rate of the step would count
            for step in (0.0, 0.0, part * step_limit(t)):
                t.sync()
                t.measure()
                told = [sign * 0.01] * 6
                comply = t.frame(Comply, None, *told, t.cycle & 0xFF)
                extras = COMPLY_BELONGS | JOINT_SETPOINT_BELONGS
                angle = t.angles_frame(AT + sign * step)
                answers = t.give(comply, t.setpoint_frame(extras), angle)
                stopped = refused and step > 0.0
                t.only(answers, ("EMCY",) if stopped else ("ERROR",), f"0.01 rad and {step} rad")
                t.errors()


def runaways(t: Tester) -> None:
    """What meets a bound of RUNAWAY does not break it."""
    for sign in (1, -1):
        for changes, way in RUNAWAYS:
            _play(t, changes, way, sign, runs_away=True)
        for changes, way in NONE:
            _play(t, changes, way, sign, runs_away=False)


def _play(
    t: Tester, changes: Mapping[Parameter, float], way: Steps, sign: int, *, runs_away: bool
) -> None:
    t.operational({**EXACT, **changes}, AT)
    t.run(2)
    for number, (ahead, counts) in enumerate(way):
        t.move_to(AT + sign * counts / 8192.0, no_more_than(t))
        t.sync()
        t.measure()
        answers = bare(t.setpoint(AT + sign * ahead / 8192.0))
        if runs_away and number == len(way) - 1:
            off(t, answers)
            noted(t, S.FAULT, F.RUNAWAY)
            return
        t.only(answers, ("ERROR",), f"{counts} counts away, the set-point {ahead}, of {way}")
        t.only(t.errors(), ("DAC",))
    noted(t, S.OPERATIONAL)

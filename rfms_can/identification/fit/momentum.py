"""Effective inertia by double integration (Eq. 4.17 to 4.23).

While joint i moves alone its inertia is constant, so that

    W(t) = integral of integral of (tau_i - D_i) dt dt = (Ia_i + D_ii) (theta_i(t) - theta_i(0))

for a motion from rest. The thesis sums ``tau(0) + ... + tau(m)`` over m = 0 ... n, which counts
(n + 1)(n + 2) / 2 samples instead of n^2 / 2: too large by 1 + 3/n, 6 % at n = 50. Here a torque is
held for the period before its sample, so one sum is exact and the second is the trapezoidal rule.
"""

from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple

import numpy as np

from rfms_can.analysis.cycles import Floats
from rfms_can.identification.experiments.actions import BURST
from rfms_can.identification.fit.least_squares import Fit, solve
from rfms_can.identification.fit.trace import Trace

MOVING: Final = 0.03
"""Speed over the motion's largest above which a joint moves and does not stick."""


def twice(values: Floats, period_s: float) -> Floats:
    """The double integral of values held over the period before each; 0 at the first row.

    Along the first axis; the value of the first row is not used.
    """
    held = values.copy()
    held[0] = 0.0
    once = np.cumsum(held, axis=0) * period_s
    steps = 0.5 * (once[1:] + once[:-1]) * period_s
    return np.concatenate((np.zeros_like(once[:1]), np.cumsum(steps, axis=0)))


def printed_sum(values: Floats, period_s: float) -> float:
    """The right side of Eq. 4.20 as printed, over all values."""
    return float(np.cumsum(values).sum()) * period_s**2


class Motion(NamedTuple):
    """One motion of one joint, from its breakaway to its stop.

    Attributes:
        joint: index 0 to 5.
        action: number in its experiment.
        pose: of the other joints, rad (6).
        q, current, qd: of the joint: rad, DAC codes, rad/s (n).
        poses: of all joints, rad (n, 6).
        time: s (n).
        direction: +1 or -1.
        load: whether the known load was in the hand.
    """

    joint: int
    action: int
    pose: Floats
    q: Floats
    current: Floats
    qd: Floats
    poses: Floats
    time: Floats
    direction: float
    load: bool


def motions_of(trace: Trace) -> Iterable[Motion]:
    """The bursts of a trace, without the samples in which the joint sticks."""
    for mark in trace.marks:
        if mark.kind != BURST:
            continue
        i = mark.joint - 1
        qd = trace.qd[mark.start : mark.stop, i]
        direction = float(np.sign(trace.q[mark.stop - 1, i] - trace.q[mark.start, i]))
        moving = np.flatnonzero(direction * qd > MOVING * np.abs(qd).max())
        rows = slice(mark.start + int(moving[0]), mark.start + int(moving[-1]) + 1)
        time: Floats = trace.period_s * np.arange(rows.stop - rows.start, dtype=np.float64)
        yield Motion(
            i,
            mark.action,
            trace.q[mark.start],
            trace.q[rows, i],
            trace.current[rows, i],
            trace.qd[rows, i],
            trace.q[rows],
            time,
            direction,
            trace.load,
        )


def inertia_of(motions: Sequence[Motion], torques: Sequence[Floats], period_s: float) -> Fit:
    """Inertia of one joint from motions at one pose.

    Args:
        motions: of one joint.
        torques: tau_i - D_i of each, friction subtracted, Nm (n each).
        period_s: between samples, s.

    Each motion also has its initial momentum and an offset of the torque as unknowns, so that an
    error of the friction does not bias the inertia. Errors of a double integral are correlated, so
    their scatter within a motion is not a measure of the deviation: that of the values of several
    motions is used if available.
    """
    what = f"inertia of joint {motions[0].joint + 1}"
    fits = []
    for motion, torque in zip(motions, torques, strict=True):
        columns = (motion.q - motion.q[0], -motion.time, -0.5 * motion.time**2)
        right = twice(torque, period_s)
        fits.append(solve(_UNKNOWNS, np.column_stack(columns), right, what))
    values = np.array([[fit.values[name] for name in _UNKNOWNS] for fit in fits])
    deviation = fits[0].deviations["inertia"]
    if len(fits) > 1:
        deviation = max(float(values[:, 0].std(ddof=1)) / len(fits) ** 0.5, deviation)
    residual = float(np.sqrt(np.mean([fit.residual**2 for fit in fits])))
    equations = sum(fit.equations for fit in fits)
    value = float(values[:, 0].mean())
    return Fit({"inertia": value}, {"inertia": deviation}, residual, equations, fits[0].condition)


_UNKNOWNS: Final = ("inertia", "momentum", "offset")

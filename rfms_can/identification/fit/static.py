"""Static friction: the torque at which a joint that is pushed harder and harder begins to move.

The servo of a joint that creeps raises its torque steadily, r Nm/s, until the joint breaks away. By
the time an encoder shows it, x rad later, the torque is more: with inertia M the joint goes
``r t^3 / (6 M)``, so it broke away ``t = (6 M x / r)^(1/3)`` before.
"""

from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

import numpy as np

from rfms_can.arm import Arm
from rfms_can.arm.torque_law import TorqueLaw
from rfms_can.dynamics.terms import gravity_row, inertia_row, value
from rfms_can.identification.experiments.actions import CREEP
from rfms_can.identification.fit.trace import Trace

STARTED: Final = 1.5
"""Encoder counts after which a joint has begun to move."""
RAMP: Final = 25
"""Samples over which the torque's rise is measured."""


class Breakaway(NamedTuple):
    """How one motion began.

    Attributes:
        joint: index 0 to 5.
        direction: +1 or -1.
        torque: the static friction it overcame, Nm.
        spread: how far that may be off, Nm: what the torque rises in two samples, and the noise.
    """

    joint: int
    direction: float
    torque: float
    spread: float


def breakaways(
    trace: Trace, laws: Sequence[TorqueLaw], constants: Mapping[str, float], arm: Arm
) -> list[Breakaway]:
    """How each motion of a trace that creeps has broken away."""
    result = []
    for mark in trace.marks:
        if mark.kind != CREEP:
            continue
        joint = mark.joint - 1
        law, count = laws[joint], 1.0 / abs(arm.drives[joint].counts_per_radian)
        q = trace.q[mark.start : mark.stop, joint]
        direction = float(np.sign(q[-1] - q[0]))
        first = int(np.argmax(direction * (q - q[0]) > STARTED * count))
        if first < RAMP:
            continue  # it moved before it was asked to: nothing has broken away
        row = mark.start + first
        slope = law.slope_positive if direction > 0.0 else law.slope_negative
        ramp = direction * slope * trace.current[row - RAMP : row, joint]
        times = trace.period_s * np.arange(-RAMP, 0)
        rate, now = np.polyfit(times, ramp, 1)
        if rate <= 0.0:
            continue
        inertia = value(inertia_row(mark.joint, trace.q[row].tolist()), constants)
        before = (6.0 * inertia * STARTED * count / rate) ** (1.0 / 3.0)
        held = value(gravity_row(mark.joint, trace.q[row].tolist()), constants)
        torque = float(now - rate * before) - direction * held
        noise = float(np.std(ramp - np.polyval((rate, now), times))) / RAMP**0.5
        spread = float(2.0 * rate * trace.period_s + noise)
        result.append(Breakaway(joint, direction, torque, spread))
    return result

"""Static friction: the breakaway torque of a joint under slowly increasing torque.

The servo of a creeping joint increases its torque at a constant rate, r Nm/s, until the joint
breaks away. When the encoder shows it, x rad later, the torque is larger: with inertia M the joint
has moved by ``r t^3 / (6 M)``, so it broke away ``t = (6 M x / r)^(1/3)`` before.
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
"""Encoder counts after which a joint is considered moving."""
RAMP: Final = 25
"""Samples over which the torque's rise is measured."""


class Breakaway(NamedTuple):
    """Breakaway of one motion.

    Attributes:
        joint: index 0 to 5.
        direction: +1 or -1.
        torque: static friction, Nm.
        spread: its uncertainty, Nm: the torque's rise in two samples, and the noise.
    """

    joint: int
    direction: float
    torque: float
    spread: float


def breakaways(
    trace: Trace, laws: Sequence[TorqueLaw], constants: Mapping[str, float], arm: Arm
) -> list[Breakaway]:
    """The breakaway of each creep motion of a trace."""
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
            continue  # the joint was moving before the command: not a breakaway
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

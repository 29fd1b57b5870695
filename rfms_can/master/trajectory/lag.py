"""How far the commanded joint angles lag behind what is asked of them, to keep the joints' limits.

A path whose goal is observed, or pushed by compliance, may ask for more than a joint may do: a step
of a correction on top of a transition, or a displacement by counts of an encoder. The joint then
does what it may, lags behind, and comes up again: with the velocity of what it follows, and as fast
besides as it can still stop there. Where the arm follows a plan it never lags.
"""

import math
from collections.abc import Sequence
from typing import Final, Protocol

KEPT: Final = 1.01
"""Acceleration over its limit that is let through: plans are judged at some samples only, and an
angle of float32 moves by up to 0.5 % of it."""
KEPT_SPEED: Final = 1.05
"""The same of the speed: joints estimate how they leave a segment."""
LARGEST: Final = 0.02
"""A lag behind a path, rad, that says: this cannot be followed."""
CAUGHT_UP: Final = 1e-9
"""Lag, and difference of steps, rad, that count as none."""
CAREFUL: Final = 0.7
"""Part of the speed at which a joint could just stop where it is asked to be."""


class JointLimits(Protocol):
    """How fast the joints of an arm may run and accelerate."""

    @property
    def speed_limits(self) -> Sequence[float]:
        """rad/s, one per joint."""

    @property
    def acceleration_limits(self) -> Sequence[float]:
        """rad/s2, one per joint."""


class Lag:
    """Of six joints.

    Args:
        arm: its limits.
        period_s: control period, s.

    Attributes:
        angles: what is to be added to the joint angles asked for, rad (6).
        active: whether that is anything.
    """

    __slots__ = ("_asked", "_limits", "_steps", "active", "angles")

    def __init__(self, arm: JointLimits, period_s: float) -> None:
        self._limits: Final = tuple(
            (KEPT_SPEED * speed * period_s, KEPT * acceleration * period_s * period_s)
            for speed, acceleration in zip(arm.speed_limits, arm.acceleration_limits, strict=True)
        )
        self.reset((0.0,) * 6)

    def reset(self, asked: Sequence[float]) -> None:
        """At rest at the angles ``asked``, rad, without a lag."""
        self._asked = list(asked)
        self._steps = [0.0] * 6  # commanded in the last cycle, rad
        self.angles = [0.0] * 6
        self.active = False

    def follow(self, asked: Sequence[float]) -> None:
        """Take the joint angles asked for in the next cycle, rad."""
        before, steps, active = self._asked, self._steps, self.active
        still = True
        for k, (most, bend) in enumerate(self._limits):
            step = asked[k] - before[k]
            if active or not (-bend <= step - steps[k] <= bend and -most <= step <= most):
                still = self._follow(k, step, most, bend) and still
            else:
                steps[k] = step
            before[k] = asked[k]
        self.active = not still
        if still and active:
            self.angles = [0.0] * 6

    @property
    def joint_too_far(self) -> int | None:
        """The joint that lags too far behind, or None."""
        if self.active:
            for k, angle in enumerate(self.angles):
                if abs(angle) > LARGEST:
                    return k + 1
        return None

    def _follow(self, k: int, step: float, most: float, bend: float) -> bool:
        """One joint: as near to what is asked for as the limits let it; whether it is there."""
        last = self._steps[k]
        behind = -self.angles[k]
        size = abs(behind)
        if size > 0.5 * bend:
            behind = math.copysign(min(size, CAREFUL * math.sqrt(2.0 * bend * size)), behind)
        needed = step + behind
        needed = min(max(needed, -most), most)
        needed = min(max(needed, last - bend), last + bend)
        self._steps[k] = needed
        self.angles[k] += needed - step
        return abs(self.angles[k]) <= CAUGHT_UP and abs(needed - step) <= CAUGHT_UP

"""How far the commanded joint angles lag behind what is asked of them, to keep the joints' limits.

A path whose goal is observed, or pushed, may ask for a little more than a joint may do: a step of a
correction on top of a transition. The joint then does what it may, lags behind, and comes up again
as soon as there is room. Where the arm follows a plan it never does.
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
"""A lag, rad, that says: this cannot be followed."""
CAUGHT_UP: Final = 1e-9
"""Lag and step, rad, that count as none."""
LEAST_ROOM: Final = 0.1
"""Part of its acceleration limit a joint comes up with even where the path takes all of it."""


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

    __slots__ = ("_asked", "_asked_steps", "_limits", "_steps", "active", "angles")

    def __init__(self, arm: JointLimits, period_s: float) -> None:
        self._limits: Final = tuple(
            (KEPT_SPEED * speed * period_s, KEPT * acceleration * period_s * period_s)
            for speed, acceleration in zip(arm.speed_limits, arm.acceleration_limits, strict=True)
        )
        self.reset((0.0,) * 6)

    def reset(self, asked: Sequence[float]) -> None:
        """At rest at the angles ``asked``, rad, without a lag."""
        self._asked = list(asked)
        self._asked_steps = [0.0] * 6
        self._steps = [0.0] * 6
        self.angles = [0.0] * 6
        self.active = False

    def follow(self, asked: Sequence[float]) -> None:
        """Take the joint angles asked for in the next cycle, rad."""
        before, steps, active = self._asked, self._asked_steps, self.active
        for k, (most, bend) in enumerate(self._limits):
            step = asked[k] - before[k]
            asked_bend = step - steps[k]
            before[k], steps[k] = asked[k], step
            if active or not (-bend <= asked_bend <= bend and -most <= step <= most):
                self._follow(k, step, asked_bend, most, bend)
        if self.active:
            self.active = any(
                abs(angle) + abs(step) > CAUGHT_UP
                for angle, step in zip(self.angles, self._steps, strict=True)
            )
            if not self.active:
                self.angles, self._steps = [0.0] * 6, [0.0] * 6

    @property
    def joint_too_far(self) -> int | None:
        """The joint that lags too far behind, or None."""
        if self.active:
            for k, angle in enumerate(self.angles):
                if abs(angle) > LARGEST:
                    return k + 1
        return None

    def _follow(self, k: int, step: float, asked_bend: float, most: float, bend: float) -> None:
        """One joint: come up within what the limits leave, or fall behind as they ask."""
        self.active = True
        behind, last = -self.angles[k], self._steps[k]
        room = max(bend - abs(asked_bend), LEAST_ROOM * bend)
        size = abs(behind)
        wanted = math.copysign(min(size, 0.7 * math.sqrt(2.0 * room * size) + 0.5 * room), behind)
        if size < 0.5 * room:
            wanted = behind
        wanted = min(max(wanted, -most - step), most - step)
        wanted = min(max(wanted, last - bend - asked_bend), last + bend - asked_bend)
        self._steps[k] = wanted
        self.angles[k] += wanted

"""A displacement of six joints that goes back to zero, smooth to the jerk."""

import math
from collections.abc import Sequence
from typing import Final

PEAK_SPEED: Final = 1.875
PEAK_ACCELERATION: Final = 5.774
"""Of the quintic from 1 to 0 over unit time, at rest to its second derivative at both ends."""


class Fade:
    """Six displacements that return to zero.

    Attributes:
        over: whether they are there.
    """

    __slots__ = ("_at", "_from", "_step", "over")

    def __init__(
        self, displacement: Sequence[float], limits: Sequence[tuple[float, float]], least: int
    ) -> None:
        """Take as many cycles as the joints need.

        Args:
            displacement: where they are, rad (6).
            limits: speed and acceleration of each joint, rad per cycle and per cycle^2.
            least: cycles to take at least.
        """
        cycles = float(max(1, least))
        for size, (speed, acceleration) in zip(displacement, limits, strict=True):
            cycles = max(cycles, PEAK_SPEED * abs(size) / speed)
            cycles = max(cycles, math.sqrt(PEAK_ACCELERATION * abs(size) / acceleration))
        self._from = tuple(displacement)
        self._step = 1.0 / math.ceil(cycles)
        self._at = 0.0
        self.over = False

    def step(self) -> tuple[float, ...]:
        """One cycle on."""
        p = self._at = min(1.0, self._at + self._step)
        self.over = p > 1.0 - 1e-9
        remaining = 0.0 if self.over else 1.0 - p**3 * (10.0 - 15.0 * p + 6.0 * p * p)
        return tuple(remaining * size for size in self._from)

"""Where the joints are, how fast, and which brakes hold: from MEASURE, as a stranger hears it."""

from typing import Final

from rfms_can.arm import Arm
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import Measure

STILL_COUNTS: Final = 2
"""Encoder counts in a period up to which a joint is at rest: one is noise of the sample."""
_CYCLES: Final = 256


class Joints:
    """The six joints by their boards.

    Args:
        arm: the arm's data.
        period_s: of the control cycle, s.

    Attributes:
        counts: encoder counts by the last MEASURE (6).
        speeds: over each joint's speed limit, signed (6).
        still: periods in a row in which each joint has not moved (6).
        braked: whether each brake holds (6).
    """

    def __init__(self, arm: Arm, period_s: float) -> None:
        self._per_count = [
            1.0 / (abs(drive.counts_per_radian) * limit * period_s)
            for drive, limit in zip(arm.drives, arm.speed_limits, strict=True)
        ]
        self._cycles: list[int | None] = [None] * len(JOINTS)
        self.counts = [0] * len(JOINTS)
        self.speeds = [0.0] * len(JOINTS)
        self.still = [0] * len(JOINTS)
        self.braked = [False] * len(JOINTS)

    def take(self, index: int, measure: Measure) -> None:
        """A MEASURE of a joint; its speed is known from two periods that follow one another."""
        before = self._cycles[index]
        moved = measure.counts - self.counts[index]
        if before is not None and (before + 1) % _CYCLES == measure.cycle:
            self.speeds[index] = moved * self._per_count[index]
            self.still[index] = self.still[index] + 1 if abs(moved) <= STILL_COUNTS else 0
        self._cycles[index] = measure.cycle
        self.counts[index] = measure.counts
        self.braked[index] = bool(measure.braked)

    @property
    def fastest(self) -> float:
        """Largest speed over its limit."""
        return max(map(abs, self.speeds))

    @property
    def slowest(self) -> float:
        """Smallest speed over its limit."""
        return min(map(abs, self.speeds))

    def at_rest(self, periods: int) -> bool:
        """Whether no joint has moved for so many periods."""
        return min(self.still) >= periods

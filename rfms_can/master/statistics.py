"""Numbers of a run: tracking errors per joint, cycles, misses, lateness."""

import math
from collections.abc import Sequence
from typing import Final

from rfms_can.wire.nodes import JOINTS

LATENESS_EDGES_NS: Final = tuple(10_000 * 2**n for n in range(12))
"""Upper edges of the histogram of SYNC lateness: 10 us, 20 us, ... 20 ms."""

SETTLING_S: Final = 0.4
"""Time after the end of a motion from which errors count as steady."""


class Tracking:
    """Extremes and rms of one joint's error (rad), over the cycles that had one."""

    __slots__ = ("_squares", "count", "highest", "largest", "lowest")

    def __init__(self) -> None:
        self._squares = 0.0
        self.count = 0
        self.largest = 0.0
        self.lowest = math.inf
        self.highest = -math.inf

    def add(self, error: float) -> None:
        """Take the error of one cycle."""
        self._squares += error * error
        self.count += 1
        size = -error if error < 0.0 else error
        self.largest = max(self.largest, size)
        self.lowest = min(self.lowest, error)
        self.highest = max(self.highest, error)

    @property
    def rms(self) -> float:
        """Root mean square, rad."""
        return math.sqrt(self._squares / self.count) if self.count else 0.0


class RunStatistics:
    """What the master counts.

    Attributes:
        cycles: control cycles since enable.
        incomplete: cycles that ended before all had answered.
        moving: tracking of each joint while commanded to move.
        settled: the same once commanded to rest for ``SETTLING_S``.
        lateness: histogram of how late SYNC was sent (real time only).
    """

    def __init__(self, period_s: float) -> None:
        self.cycles = 0
        self.incomplete = 0
        self.moving = [Tracking() for _ in JOINTS]
        self.settled = [Tracking() for _ in JOINTS]
        self._settling = round(SETTLING_S / period_s)
        self._rested = 0
        self.lateness = [0] * (len(LATENESS_EDGES_NS) + 1)
        self.missing: dict[str, int] = {}

    def errors(self, errors: Sequence[float], moves: bool) -> None:
        """Take the six errors of a cycle, rad; ``moves``: the arm is commanded to move."""
        self._rested = 0 if moves else self._rested + 1
        if moves:
            for tracking, error in zip(self.moving, errors, strict=True):
                tracking.add(error)
        elif self._rested > self._settling:
            for tracking, error in zip(self.settled, errors, strict=True):
                tracking.add(error)

    def late(self, lateness_ns: int) -> None:
        """SYNC went out this late."""
        place = 0
        while place < len(LATENESS_EDGES_NS) and lateness_ns >= LATENESS_EDGES_NS[place]:
            place += 1
        self.lateness[place] += 1

    def miss(self, names: str) -> None:
        """A cycle ended without these frames."""
        self.incomplete += 1
        self.missing[names] = self.missing.get(names, 0) + 1

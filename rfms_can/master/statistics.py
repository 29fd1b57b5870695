"""Numbers of a run: tracking errors per joint, cycles, misses, lateness. No allocation per cycle."""

import math
from collections.abc import Sequence
from typing import Final

from rfms_can.wire import JOINTS

LATENESS_EDGES_NS: Final = tuple(10_000 * 2**n for n in range(12))
"""Upper edges of the histogram of SYNC lateness: 10 us, 20 us, ... 20 ms."""


class Tracking:
    """Maximum and rms of one joint's error (rad), over the cycles that had one."""

    __slots__ = ("_squares", "count", "largest")

    def __init__(self) -> None:
        self._squares = 0.0
        self.count = 0
        self.largest = 0.0

    def add(self, error: float) -> None:
        """Take the error of one cycle."""
        self._squares += error * error
        self.count += 1
        size = -error if error < 0.0 else error
        if size > self.largest:
            self.largest = size

    @property
    def rms(self) -> float:
        """Root mean square, rad."""
        return math.sqrt(self._squares / self.count) if self.count else 0.0


class RunStatistics:
    """What the master counts.

    Attributes:
        cycles: control cycles since enable.
        incomplete: cycles that ended before all had answered.
        moving, resting: tracking of each joint while commanded to move, and at rest.
        lateness: histogram of how late SYNC was sent (real time only).
    """

    def __init__(self) -> None:
        self.cycles = 0
        self.incomplete = 0
        self.moving = [Tracking() for _ in JOINTS]
        self.resting = [Tracking() for _ in JOINTS]
        self.lateness = [0] * (len(LATENESS_EDGES_NS) + 1)
        self.missing: dict[str, int] = {}

    def errors(self, errors: Sequence[float], moves: bool) -> None:
        """Take the six errors of a cycle, rad."""
        for tracking, error in zip(self.moving if moves else self.resting, errors, strict=True):
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

"""Homing (docs/node-law.md, Homing): searches the index, then holds."""

import math
from typing import NamedTuple

from third_node.codec import Fields
from third_node.configuration import Parameters
from third_node.law import Law


class Failure(NamedTuple):
    """What EMCY HOMING_FAILED says; ``stands``: the frame is MEASURE_n, else REFERENCE_n."""

    value: float
    bound: float
    stands: bool = False


class Homing:
    """From HOME to READY; then the hold. ``zero``: counts at theta = 0, None if not known."""

    def __init__(self, p: Parameters, zero: int | None) -> None:
        self.p = p
        self.zero = zero
        self.residual = 0.0
        self.theta = self.error = self.rate = 0.0
        self.coarse = 0.0
        self.begin()

    def begin(self) -> None:
        """HOME."""
        self.found = self.zero is not None
        self.n = self.stuck = 0
        self.counts: int | None = None
        self.failure: Failure | None = None
        self.let_go()

    def let_go(self) -> None:
        """The joint is not driven: where it is next, it is held, or goes on to search."""
        self.target: float | None = None
        self.offset: float | None = None

    def angle(self, counts: int) -> float:
        """Of the joint, rad."""
        return (counts - (self.zero or 0)) / self.p.COUNTS_PER_UNIT

    def step(self, counts: int, reference: Fields, cut: bool) -> None:
        """One cycle; ``cut``: the last torque was at its limit. See ``failure``."""
        p = self.p
        coarse = self.coarse = p.COARSE_ZERO + reference["coarse_adc"] * p.COARSE_PER_CODE
        self.theta = self.angle(counts)
        if self.target is None:
            self.target = self.theta
        self.compare(coarse - self.theta)
        self.rate = 0.0
        if not self.found and self.failure is None and reference["index_valid"]:
            self.refer(counts, reference["index_counts"])
        if not self.found:
            self.go_on(counts, cut)
            middle = (p.POSITION_MIN + p.POSITION_MAX) / 2
            self.rate = p.HOMING_SPEED if coarse < middle else -p.HOMING_SPEED
            self.target += self.rate * p.PERIOD
        self.error = self.target - self.theta

    def compare(self, offset: float) -> None:
        """Encoder and coarse position must go the same way."""
        p = self.p
        if self.offset is None:
            self.offset = offset
            return
        bound = 0.25 * p.INDEX_INTERVAL_COUNTS / abs(p.COUNTS_PER_UNIT)
        off = abs(offset - self.offset)
        if off > bound:
            self.failure = Failure(off, bound)

    def refer(self, counts: int, index_counts: int) -> None:
        """The index was seen."""
        p = self.p
        x = (self.coarse * p.COUNTS_PER_UNIT - (counts - index_counts)) / p.INDEX_INTERVAL_COUNTS
        n = round(x)
        self.residual = abs(x - n)
        if self.residual > 0.25:
            self.failure = Failure(self.residual, 0.25)
            return
        self.zero = index_counts - n * int(p.INDEX_INTERVAL_COUNTS)
        self.found = True
        change = self.angle(counts) - self.theta
        assert self.target is not None and self.offset is not None
        self.target += change
        self.offset -= change
        self.theta = self.angle(counts)

    def go_on(self, counts: int, cut: bool) -> None:
        """The search has a limit of time, and the encoder must count."""
        p = self.p
        self.n += 1
        longest = math.ceil(p.HOMING_TIME / p.PERIOD)
        if self.n > longest:
            self.failure = Failure(self.n * p.PERIOD, longest * p.PERIOD)
        self.stuck = self.stuck + 1 if counts == self.counts and cut else 0
        self.counts = counts
        longest = math.ceil(p.STUCK_TIME / p.PERIOD)
        if self.stuck > longest:
            self.failure = Failure(self.stuck * p.PERIOD, longest * p.PERIOD, True)

    def torque(self, law: Law, gravity: float, speed: float) -> float:
        """That drives the joint to its target, Nm."""
        return law.alone(self.error, self.rate - speed, gravity, self.rate, 0.0)

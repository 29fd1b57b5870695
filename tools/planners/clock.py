"""The thesis' local time of Paul's and Taylor's motions: which leg, and how far into it."""

from collections.abc import Sequence
from typing import NamedTuple

from planners.task import Leg
from rfms_can.master.trajectory.segment import whole_ticks


class Beat(NamedTuple):
    """One cycle of a motion.

    Attributes:
        leg: under way, from 0; the number of legs in the transition to rest.
        n: local time in periods, -n_acc at the start of the transition into the leg.
        enters: whether the transition into the leg begins with this cycle.
    """

    leg: int
    n: int
    enters: bool


class Clock:
    """Runs through the legs as Table 3.3 does: -t_acc to t_seg - t_acc of the next leg.

    Attributes:
        segment: t_seg of each leg in periods; that of the transition to rest is t_acc.
        acceleration: t_acc of each in periods; that to rest has the last leg's.
        beat: of the last cycle.
    """

    def __init__(self, legs: Sequence[Leg], period_s: float) -> None:
        acceleration = [whole_ticks(leg.acceleration_time, period_s) for leg in legs]
        segment = [whole_ticks(leg.segment_time, period_s) for leg in legs]
        self.acceleration = [*acceleration, acceleration[-1]]
        self.segment = [*segment, acceleration[-1]]
        self.beat = Beat(-1, 0, False)
        self._n = 0

    @property
    def blending(self) -> bool:
        """Whether the last cycle was in a transition."""
        leg, n, _ = self.beat
        return n <= self.acceleration[leg]

    @property
    def over(self) -> bool:
        """Whether the transition to rest is over."""
        leg, n, _ = self.beat
        return leg == len(self.segment) - 1 and n >= self.acceleration[leg]

    def advance(self) -> Beat:
        """The next cycle's; at rest it goes on counting."""
        leg, n, _ = self.beat
        last = len(self.segment) - 1
        if leg < 0 or (leg < last and n + 1 == self.segment[leg] - self.acceleration[leg + 1]):
            self.beat = Beat(leg + 1, -self.acceleration[leg + 1], True)
        else:
            self.beat = Beat(leg, n + 1, False)
        return self.beat

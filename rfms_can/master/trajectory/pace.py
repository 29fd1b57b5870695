"""The pace: how far local time advances in a cycle (feed-rate override, pause and resume).

r, p and h are functions of local time n, so a feed rate changes when the arm is where, never where
it goes. Two things need a steady pace: a hand-over, whose derivatives and polynomial are told for
one t_acc, and the cycles before it from which the joints estimate how they move. So a change of
pace is a ramp that is over by then, and one that does not fit waits until the hand-over is past:
that takes 2 t_acc or so, and the ramp itself up to 2 t_acc more, in the local time of the pace.
"""

import math
from typing import Final, NamedTuple

from rfms_can.setpoint.blend import blend_parameter
from rfms_can.setpoint.history import window_for

MIN_FEED: Final = 0.05
"""Slowest feed rate; to stand still there is the pause."""

LONGEST_ACCELERATION_S: Final = 100.0
"""What SETPOINT can say of an acceleration time, s; a feed rate makes it longer."""

CRAWL: Final = 0.25
"""Part of the feed rate at which a pause must leave room to reach the hand-over."""

LONG_STEADY: Final = 200.0
"""Cycles of steady pace that are enough for any hand-over."""

_SHARES: Final = tuple(k / 16 for k in range(16, 0, -1))
"""Parts of a change that are tried where the whole of it does not fit."""


class HandOver(NamedTuple):
    """What of a hand-over the pace must mind.

    Attributes:
        n: local time at which it is due, periods; infinite where none is to come.
        acceleration_ticks: t_acc of what follows.
        estimated: whether joints estimate from past cycles how they move.
    """

    n: float
    acceleration_ticks: int
    estimated: bool

    def cycles_at(self, pace: float) -> int:
        """Cycles of steady ``pace`` it takes: the difference quotient of r, or a whole window."""
        return window_for(round(self.acceleration_ticks / pace)) + 1 if self.estimated else 3


NO_HAND_OVER: Final = HandOver(math.inf, 1, False)


class Pace:
    """The step of local time from cycle to cycle, in periods: 1 at full speed, 0 in a pause.

    A ramp has the shape of (3.16), continuous to its second derivative, so that the jerk of the
    joints is continuous. It takes 2 t_acc times the root of the change: for a pause as long as a
    controlled stop, and with no larger jerk for less.

    Attributes:
        feed: step of the cycle at hand.
        rate: requested feed rate.
        paused: whether a pause is requested.
    """

    __slots__ = ("_from", "_k", "_period", "_steady", "_ticks", "_to", "feed", "paused", "rate")

    def __init__(self, period_s: float) -> None:
        self._period: Final = period_s
        self.rate: float = 1.0
        self.paused = False
        self.jump()

    def jump(self) -> None:
        """Take on the requested pace at once."""
        self.feed = self._from = self._to = self.wanted
        self._k = self._ticks = 0
        self._steady: float = math.inf

    @property
    def wanted(self) -> float:
        """The requested pace."""
        return 0.0 if self.paused else self.rate

    @property
    def is_as_wanted(self) -> bool:
        """Whether there is nothing to change."""
        return self.feed == self.wanted and self._k == self._ticks

    @property
    def changes(self) -> bool:
        """Whether a ramp is under way."""
        return self._k != self._ticks

    @property
    def stands(self) -> bool:
        """Whether local time stands still."""
        return self.feed == 0.0 and self._k == self._ticks

    def advance(self) -> float:
        """The step of the next cycle."""
        if self._k == self._ticks:
            self._steady += 1.0
            return self.feed
        self._k += 1
        if self._k == self._ticks:
            self.feed, self._steady = self._to, 1.0
        else:
            u = self._k / self._ticks
            shape = ((6.0 * u - 15.0) * u + 10.0) * u * u * u
            self.feed, self._steady = self._from + (self._to - self._from) * shape, 0.0
        return self.feed

    def change(self, n: float, acceleration_ticks: int, ahead: HandOver) -> None:
        """Begin as much of the requested change as is over by the hand-over ``ahead``.

        A pause is begun whole or not at all: what would be left of it is a slow hand-over.

        Args:
            n: local time now.
            acceleration_ticks: t_acc of the segment under way.
            ahead: the earliest that may come.
        """
        wanted, feed = self.wanted, self.feed
        if self._k != self._ticks:
            return
        for share in _SHARES if wanted > feed else (1.0,):
            to = wanted if share == 1.0 else feed + (wanted - feed) * share
            distance = _ramp_distance(feed, to, acceleration_ticks)
            room = ahead.n - n - distance
            if self._steady_distance(to, acceleration_ticks, ahead) <= room:
                break
        else:
            if feed > 0.0:
                return
        self._from, self._to = feed, to
        self._k, self._ticks = 0, _ramp_ticks(feed, to, acceleration_ticks)

    def until_steady(self, acceleration_ticks: int, ahead: HandOver) -> float:
        """Local time until the pace has been steady long enough for ``ahead``; 0 if it has been."""
        left = self._ticks - self._k
        if left == 0:
            if self.feed == 0.0:
                return self._steady_distance(0.0, acceleration_ticks, ahead)
            if self._steady > LONG_STEADY:
                return 0.0
            return max(0.0, ahead.cycles_at(self.feed) - self._steady) * self.feed
        u = self._k / self._ticks
        change = self._to - self._from
        distance = left * self._from + change * self._ticks * (1.0 - blend_parameter(u)) / 2.0
        return distance + 1.0 + self._steady_distance(self._to, acceleration_ticks, ahead)

    def _steady_distance(self, pace: float, acceleration_ticks: int, ahead: HandOver) -> float:
        """Local time a hand-over takes once ``pace`` is reached; from a pause, that of a crawl."""
        if ahead is NO_HAND_OVER:
            return 0.0
        if pace > 0.0:
            return (ahead.cycles_at(pace) + 1) * pace
        slowest = ahead.acceleration_ticks * self._period / LONGEST_ACCELERATION_S
        crawl = max(self.rate * CRAWL, slowest)
        distance = _ramp_distance(0.0, crawl, acceleration_ticks)
        return distance + (ahead.cycles_at(crawl) + 1) * crawl


def _ramp_ticks(start: float, end: float, acceleration_ticks: int) -> int:
    return math.ceil(2 * acceleration_ticks * math.sqrt(abs(end - start)))


def _ramp_distance(start: float, end: float, acceleration_ticks: int) -> float:
    """Local time a ramp covers, and half a step to spare."""
    return (start + end) / 2.0 * _ramp_ticks(start, end, acceleration_ticks) + 0.5

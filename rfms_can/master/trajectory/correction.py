"""The Cartesian transition: T6 itself blends from one path to the next (thesis, Ch. VII).

In the frame left of its drive the new path is D(r), the old one, continued, L^-1 T6 R^-1; so is
the new one in joint mode, T6 being that of its joints' angles. What lies between them, a
translation and a rotation vector, is added to the new one and faded by the matching polynomial
(3.18) of all four derivatives.
Both paths are known, so the derivatives are those of the polynomial through seven of their poses,
a period of local time apart or so: nothing is estimated from noise.

Of two segments that run at one rate along one line, or about one axis, the sum is that motion
exactly: h of (3.15) and the matching polynomial of a constant rate add up to it.
"""

import math
from collections.abc import Callable
from typing import Final, NamedTuple, Self

import numpy as np

from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.trajectory.segment import Segment
from rfms_can.setpoint.blend import NO_MATCH, Derivatives, MatchingPolynomial
from rfms_can.transform import DriveTransform, Transform

SAMPLES: Final = 7
"""Poses the derivatives are taken from, the newest of the cycle before the transition."""

_FIT: Final = np.linalg.inv(np.vander(np.arange(1.0 - SAMPLES, 1.0), increasing=True))
_FACTORS: Final = [[math.perm(i, order) for i in range(SAMPLES)] for order in range(4)]


class Correction:
    """What is left of the old path, as a function of p."""

    __slots__ = ("_polynomials",)

    def __init__(self, polynomials: tuple[MatchingPolynomial, ...]) -> None:
        """Translation x, y, z, metres, and rotation vector x, y, z, radians."""
        self._polynomials: Final = polynomials

    @classmethod
    def between(
        cls,
        old: Callable[[int], Transform],
        new: Callable[[int], Transform],
        past: float,
        acceleration: float,
    ) -> Self:
        """The correction from the path ``old`` to the path ``new``.

        Args:
            old: pose number -6 to 0 of the old path, in the frame of ``new``.
            new: the new path then, where it starts: h of (3.15) begins with four zeros. D(1) rests;
                the start of a joint-mode segment goes as its goal does, joint by joint.
            past: the hand-over, after pose 0.
            acceleration: t_acc of the transition. Both in units of the time between two poses.
        """
        samples = [_difference(old(k), new(k)) for k in range(1 - SAMPLES, 1)]
        series = (_FIT @ np.array(samples)).T.tolist()
        return cls(
            tuple(
                MatchingPolynomial.matching(_derivatives(each, past), acceleration)
                for each in series
            )
        )

    def pose(self, segment: Segment, moment: Moment, r: float, p: float) -> Transform:
        """T6 at p of the transition into ``segment``.

        Raises:
            KinematicsError: the goal of a joint-mode segment has no solution.
        """
        goal, base = segment.move.target, segment.driven(moment, r)
        x, y, z, ex, ey, ez = (polynomial.at(p) for polynomial in self._polynomials)
        angle = math.sqrt(ex * ex + ey * ey + ez * ez)
        turned = Transform.rotation((ex, ey, ez), angle) @ base if angle else base
        moved = turned._replace(px=base.px + x, py=base.py + y, pz=base.pz + z)
        return goal.left(moment) @ moved @ goal.right(moment)


NO_CORRECTION: Final = Correction((NO_MATCH,) * 6)
"""Between two paths that already agree."""


class Leaving(NamedTuple):
    """A segment as it was at its last cycle.

    Attributes:
        segment: left.
        tick: of that cycle.
        n, clock: local time, of the path and of the goal, periods.
        step: the pace.
        period_s: tau, s.
    """

    segment: Segment
    tick: int
    n: float
    clock: float
    step: float
    period_s: float

    def moment(self, cycle: int) -> Moment:
        """The moment of the path, continued, at ``cycle`` after the last."""
        segment, elapsed = self.segment, cycle * self.step
        h = 1.0 if segment.rests else (self.n + elapsed) / segment.move.segment_ticks
        return Moment(self.tick + cycle, h, (self.clock + elapsed) * self.period_s)

    def pose(self, cycle: int) -> Transform:
        """T6 then."""
        moment = self.moment(cycle)
        return self.segment.hand(moment, 1.0 - moment.h)

    def into(self, segment: Segment, hand_over: float) -> Correction:
        """The transition into ``segment``, that begins at local time ``hand_over``."""
        goal, ticks = segment.move.target, segment.move.acceleration_ticks
        apart = max(1, round(1.0 / self.step))

        def start(k: int) -> Moment:
            cycle = k * apart
            if segment.rests:
                return self.moment(cycle)._replace(h=1.0)
            t = (self.n + cycle * self.step - hand_over - ticks) * self.period_s
            return Moment(self.tick + cycle, 0.0, t)

        def old(k: int) -> Transform:
            pose, moment = self.pose(k * apart), start(k)
            return goal.left(moment).inverse() @ pose @ goal.right(moment).inverse()

        def new(k: int) -> Transform:
            return segment.driven(start(k), 1.0)

        unit = self.step * apart
        return Correction.between(old, new, (hand_over - self.n) / unit, ticks / unit)


def _difference(old: Transform, new: Transform) -> list[float]:
    """Translation and rotation vector from ``new`` to ``old``, in the frame both are given in."""
    turn = DriveTransform(old @ new.inverse())
    return [
        *(old.px - new.px, old.py - new.py, old.pz - new.pz),
        *(component * turn.psi for component in turn.axis),
    ]


def _derivatives(series: list[float], x: float) -> Derivatives:
    """Value and three derivatives of a power series at x."""
    powers = [x**i for i in range(SAMPLES)]
    value, rate, acceleration, jerk = (
        sum(factors[i] * series[i] * powers[i - order] for i in range(order, SAMPLES))
        for order, factors in enumerate(_FACTORS)
    )
    return (value, rate, acceleration, jerk)

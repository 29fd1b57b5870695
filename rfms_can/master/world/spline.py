"""Coordinates between the rows of a table."""

from bisect import bisect_right
from collections.abc import Sequence
from itertools import pairwise
from typing import Final

Coordinates = tuple[float, ...]


class Interpolation:
    """A function of u through the rows of a table, one polynomial an interval.

    Before the first row and after the last it stays.
    """

    __slots__ = ("_first", "_last", "_pieces", "_u")

    def __init__(
        self,
        u: Sequence[float],
        rows: Sequence[Coordinates],
        slopes: Sequence[Coordinates] | None,
    ) -> None:
        """Interpolate.

        Args:
            u: parameters, growing (n, at least 2).
            rows: coordinates there (n, m).
            slopes: their derivatives there (n, m): cubic in between; straight if None.
        """
        self._u: Final = list(u)
        self._first: Final = tuple(rows[0])
        self._last: Final = tuple(rows[-1])
        self._pieces: Final = [
            tuple(
                _cubic(step, rows[i][k], rows[i + 1][k], slopes[i][k], slopes[i + 1][k])
                if slopes is not None
                else (rows[i][k], (rows[i + 1][k] - rows[i][k]) / step, 0.0, 0.0)
                for k in range(len(self._first))
            )
            for i, step in enumerate(b - a for a, b in pairwise(self._u))
        ]

    def at(self, u: float) -> Coordinates:
        """The coordinates at u (m)."""
        knots = self._u
        if u <= knots[0]:
            return self._first
        if u >= knots[-1]:
            return self._last
        i = bisect_right(knots, u) - 1
        x = u - knots[i]
        return tuple(((d * x + c) * x + b) * x + a for a, b, c, d in self._pieces[i])


def clamped_slopes(u: Sequence[float], values: Sequence[float]) -> list[float]:
    """Slopes of the cubic spline through ``values`` whose ends are at rest.

    Its second derivative is continuous at the inner knots: for steps p before and q after one,
    s[i-1]/p + 2 s[i] (1/p + 1/q) + s[i+1]/q = 3 (d before/p + d after/q), d the divided
    differences. Tridiagonal and diagonally dominant: elimination needs no pivots.
    """
    step = [b - a for a, b in pairwise(u)]
    divided = [(b - a) / h for (a, b), h in zip(pairwise(values), step, strict=True)]
    slopes = [0.0] * len(values)
    upper = [0.0] * len(values)
    for i in range(1, len(values) - 1):
        before, after = 1.0 / step[i - 1], 1.0 / step[i]
        pivot = 2.0 * (before + after) - before * upper[i - 1]
        upper[i] = after / pivot
        right = 3.0 * (before * divided[i - 1] + after * divided[i])
        slopes[i] = (right - before * slopes[i - 1]) / pivot
    for i in range(len(values) - 2, 0, -1):
        slopes[i] -= upper[i] * slopes[i + 1]
    return slopes


def _cubic(
    step: float, begin: float, end: float, rate: float, end_rate: float
) -> tuple[float, float, float, float]:
    """Coefficients of the cubic with these values and slopes at 0 and ``step``."""
    divided = (end - begin) / step
    return (
        begin,
        rate,
        (3.0 * divided - 2.0 * rate - end_rate) / step,
        (rate + end_rate - 2.0 * divided) / (step * step),
    )

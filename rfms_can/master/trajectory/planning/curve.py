"""Joint angles along a path, as Chebyshev polynomials: few inverse solutions, exact derivatives.

Twice as many solutions are taken until the last coefficients have faded. Where a path passes close
to a singularity they fade late, and the samples crowd of themselves.
"""

import math
from collections.abc import Callable
from functools import cache
from typing import Final

import numpy as np
import numpy.typing as npt

from rfms_can.kinematics import Joints

Floats = npt.NDArray[np.float64]
Function = Callable[[float, Joints], Joints]
"""Angles at an argument, on the turns nearest to those of the second."""

LEAST: Final = 16
MOST: Final = 1024
"""Degrees that are tried, from the first, doubled, to the last."""

FADED: Final = 1e-8
"""A curve is resolved where its last coefficients are below this, rad."""

_LAST: Final = 3
ORDERS: Final = 4


class Curve:
    """Six angles as a function of one argument, and three derivatives of them.

    Attributes:
        degree: of the polynomials.
        first, last: the angles at either end, rad.
        steepest: those before the largest turn from one sample to the next, rad.
        largest_step: largest turn of each joint from one sample to the next, rad.
        resolved: whether the coefficients have faded.
    """

    __slots__ = (
        "_half",
        "_middle",
        "_series",
        "degree",
        "first",
        "largest_step",
        "last",
        "resolved",
        "steepest",
    )

    def __init__(
        self,
        function: Function,
        span: tuple[float, float],
        previous: Joints,
        least: int = LEAST,
        most: int = MOST,
    ) -> None:
        """Sample ``function`` over ``span``, from the turns of ``previous`` on.

        Raises:
            KinematicsError: ``function`` does.
        """
        start, end = span
        self._middle: Final = (start + end) / 2.0
        self._half: Final = (end - start) / 2.0
        samples: list[Joints] = []
        for x in _nodes(least):
            previous = function(self._middle + self._half * x, previous)
            samples.append(previous)
        degree = least
        while True:
            values = np.array(samples)
            series = _transform(degree) @ values
            self.resolved = bool(np.abs(series[-_LAST:]).max() < FADED)
            if self.resolved or 2 * degree > most:
                break
            degree *= 2
            nodes, refined = _nodes(degree), [samples[0]]
            for k, sample in enumerate(samples[1:], 1):
                argument = self._middle + self._half * nodes[2 * k - 1]
                between = function(argument, samples[k - 1])
                refined += (between, sample)
            samples = refined
        self.degree: Final = degree
        self.first: Final = samples[0]
        self.last: Final = samples[-1]
        steps = np.abs(np.diff(values, axis=0))
        self.largest_step: Final = steps.max(axis=0)
        self.steepest: Final = samples[int(steps.max(axis=1).argmax())]
        self._series: Final = _derivatives(degree) @ series

    def derivatives(self, arguments: Floats) -> Floats:
        """Value and three derivatives at n ``arguments``; shape (4, n, 6)."""
        x = np.clip((arguments - self._middle) / self._half, -1.0, 1.0)
        terms = np.cos(np.outer(np.arccos(x), np.arange(self.degree + 1)))
        scale = self._half ** -np.arange(float(ORDERS))
        return np.asarray((terms @ self._series) * scale[:, None, None])


@cache
def _nodes(degree: int) -> tuple[float, ...]:
    """The extrema of T_degree, ascending from -1 to 1; those of half the degree are among them."""
    return tuple(-math.cos(math.pi * k / degree) for k in range(degree + 1))


@cache
def _transform(degree: int) -> Floats:
    """From values at the nodes to coefficients."""
    k = np.arange(degree + 1)
    matrix = np.cos(np.pi * np.outer(k, degree - k) / degree) * (2.0 / degree)
    matrix[:, [0, -1]] /= 2.0
    matrix[[0, -1], :] /= 2.0
    return np.asarray(matrix)


@cache
def _derivatives(degree: int) -> Floats:
    """From coefficients to those of the function and its derivatives; shape (4, n, n)."""
    unit = np.eye(degree + 1)
    first = np.zeros_like(unit)
    first[:-1] = np.polynomial.chebyshev.chebder(unit)
    second = first @ first
    return np.stack((unit, first, second, first @ second))

"""Joint angles along a path, as Chebyshev polynomials: few inverse solutions, exact derivatives.

Twice as many solutions are taken until the last coefficients have faded. Where a path passes close
to a singularity they do not: it is halved there until each piece has faded. Derivatives of narrow
pieces tell of rounding, and a joint never has the highest ones, as it runs from set-point to
set-point: there they are differences over what is run in a period.
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
WHOLE: Final = 128
"""Degrees that are tried, from the first, doubled, to the last, before a curve is halved."""
PIECE: Final = 32
"""The last of them for a piece."""
NARROWEST: Final = 2.0**-10
"""Part of the whole that is not halved once more."""

FADED: Final = 1e-8
"""A curve is resolved where its last coefficients are below this, rad."""

_LAST: Final = 3
ORDERS: Final = 4

SHORTEST: Final = 1e-5
"""Part of the whole that differences are taken over at least, for at its ends a path stands."""


class Curve:
    """Six angles as a function of one argument, and its derivatives.

    Attributes:
        degree: of the polynomials; of the finest where there are pieces.
        whole: whether it is one piece: differences are never taken of it.
        first, last: the angles at either end, rad.
        steepest: those before the largest turn from one sample to the next, rad.
        largest_step: largest turn of each joint from one sample to the next, rad.
        resolved: whether the coefficients have faded.
    """

    __slots__ = (
        *("_ends", "_pieces", "_span"),
        *("degree", "first", "largest_step", "last", "resolved", "steepest", "whole"),
    )

    def __init__(
        self,
        function: Function,
        span: tuple[float, float],
        previous: Joints,
        least: int = LEAST,
        most: int = WHOLE,
        narrowest: float = NARROWEST,
    ) -> None:
        """Sample ``function`` over ``span``, from the turns of ``previous`` on.

        Args:
            function, span, previous: the curve.
            least, most: degrees that are tried of the whole.
            narrowest: part of it that is not halved; 1 for what is to stay whole.

        Raises:
            KinematicsError: ``function`` does.
        """
        start, end = span
        width = narrowest * (end - start)
        pieces: list[_Piece] = []
        ahead = [(start, end)]
        while ahead:
            begin, stop = ahead.pop()
            top = PIECE if stop - begin < end - start else most
            piece = _Piece(function, (begin, stop), previous, least, top)
            if piece.resolved or (stop - begin) / 2.0 < width:
                pieces.append(piece)
                previous = piece.samples[-1]
            else:
                middle = (begin + stop) / 2.0
                ahead += ((middle, stop), (begin, middle))
        self._pieces: Final = tuple(pieces)
        self._ends: Final = np.array([piece.span[0] for piece in pieces[1:]])
        self._span: Final = span
        self.whole: Final = len(pieces) == 1
        self.resolved: Final = all(piece.resolved for piece in pieces)
        self.degree: Final = max(piece.degree for piece in pieces)
        self.first: Final = pieces[0].samples[0]
        self.last: Final = pieces[-1].samples[-1]
        steps = np.array([piece.steps for piece in pieces])
        self.largest_step: Final = steps.max(axis=0)
        self.steepest: Final = pieces[int(steps.max(axis=1).argmax())].steepest

    def derivatives(self, arguments: Floats, steps: Floats | float) -> Floats:
        """Value and three derivatives at n ``arguments``; shape (4, n, 6).

        Args:
            arguments: where, n of them.
            steps: what the argument changes by in a period there: one, or n of them. In pieces,
                derivatives are differences over that, and the third is left 0.
        """
        if self.whole:
            return self._pieces[0].derivatives(arguments)
        start, end = self._span
        steps = np.maximum(steps, SHORTEST * (end - start))
        centres = np.clip(arguments, start + steps, end - steps)
        before, there, after = (self._values(centres + k * steps) for k in (-1.0, 0.0, 1.0))
        reach = np.broadcast_to(steps, arguments.shape)[:, None]
        first = (after - before) / (2.0 * reach)
        second = (after - 2.0 * there + before) / reach**2
        return np.stack((self._values(arguments), first, second, np.zeros_like(first)))

    def _values(self, arguments: Floats) -> Floats:
        """The angles at n ``arguments``, of the pieces they are in; shape (n, 6)."""
        which = np.searchsorted(self._ends, arguments, side="right")
        values = np.empty((len(arguments), 6))
        for index in np.unique(which).tolist():
            inside = which == index
            values[inside] = self._pieces[index].values(arguments[inside])
        return values


class _Piece:
    """A polynomial over part of a curve.

    Attributes:
        span: of the argument.
        degree, resolved: of the polynomials; whether their last coefficients have faded.
        samples: at the nodes, rad.
        steps, steepest: as ``Curve``'s.
    """

    __slots__ = (
        *("_half", "_middle", "_series"),
        *("degree", "resolved", "samples", "span", "steepest", "steps"),
    )

    def __init__(
        self,
        function: Function,
        span: tuple[float, float],
        previous: Joints,
        least: int,
        most: int,
    ) -> None:
        start, end = self.span = span
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
        self.samples: Final = samples
        turns = np.abs(np.diff(values, axis=0))
        self.steps: Final = turns.max(axis=0)
        self.steepest: Final = samples[int(turns.max(axis=1).argmax())]
        self._series: Final = series

    def values(self, arguments: Floats) -> Floats:
        """The angles at n ``arguments``; shape (n, 6)."""
        return np.asarray(self._terms(arguments) @ self._series)

    def derivatives(self, arguments: Floats) -> Floats:
        """Value and three derivatives at n ``arguments``; shape (4, n, 6)."""
        scale = self._half ** -np.arange(float(ORDERS))
        series = _derivatives(self.degree) @ self._series
        return np.asarray((self._terms(arguments) @ series) * scale[:, None, None])

    def _terms(self, arguments: Floats) -> Floats:
        x = np.clip((arguments - self._middle) / self._half, -1.0, 1.0)
        return np.asarray(np.cos(np.outer(np.arccos(x), np.arange(self.degree + 1))))


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

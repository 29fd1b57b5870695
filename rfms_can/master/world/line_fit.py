"""The line of least squares through what was seen of an object, as far as it can be believed.

A line has a value and a slope: where the object is, and how fast it moves. Its window is as long as
the motion is straight in it: where a parabola fits significantly better, the older half is left
out. Of the slope so much is believed as is not explained by the noise of the residuals: the factor
1 - F0 / F is that of James and Stein's positive-part estimator, with F of the test that the slope
is zero. An object at rest then has no velocity, and its place is the mean of the window.

Metres and radians, in columns: x, y, z of the origin, and a rotation vector x, y, z.
"""

from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

FEWEST: Final = 5
"""Observations that are kept where the motion bends, and where they come slowly."""

BELIEVED: Final = 6.0
"""F0: F of a slope that is zero is above it once in 2000 times, with degrees of freedom (3, 60)."""

BENT: Final = 6.0
"""F of a parabola from which on a line is too long: by chance once in 100 to 1000 times."""

EARLY_S: Final = 0.15
"""As long as an object is seen for less, the residuals do not tell the noise yet ..."""

EARLY_NOISE: Final = np.array([0.5e-3, 2e-3])
"""... and that of an ordinary camera is added, m and rad: 0.5 mm, 0.25 m from the origin."""

_ROUNDING: Final = 1e-24
"""Variance of rounding, m2 and rad2."""

_BLOCKS: Final = (slice(0, 3), slice(3, 6))
_EARLY_VARIANCE: Final = EARLY_NOISE**2


class LineFit(NamedTuple):
    """What a line says at time 0.

    Attributes:
        value: m and rad (6).
        slope: m/s and rad/s (6), as far as it is believed.
        noise: standard deviation of one observation, m and rad, in each direction.
    """

    value: Array
    slope: Array
    noise: tuple[float, float]


def fit_line(times: Array, rows: Array) -> LineFit:
    """Fit a line to observations.

    Args:
        times: s, ascending, the newest 0 (n), three or more.
        rows: where the object was (n, 6).
    """
    early = max(0.0, 1.0 + times[0] / EARLY_S)
    count = len(times)
    line = _Line(times, rows)
    while count > FEWEST and line.bent():
        count = max(FEWEST, count // 2)
        line = _Line(times[-count:], rows[-count:])
    return line.believed(early)


class _Line:
    """A line through all of some observations."""

    __slots__ = (
        "_count",
        "_mean",
        "_middle",
        "_offsets",
        "_residuals",
        "_slope",
        "_spread",
        "_sum",
    )

    def __init__(self, times: Array, rows: Array) -> None:
        self._count = len(times)
        self._middle = float(times.mean())
        self._offsets = times - self._middle
        self._spread = float(self._offsets @ self._offsets)
        self._mean = rows.mean(axis=0)
        self._slope = self._offsets @ rows / self._spread
        self._residuals = rows - self._mean - np.outer(self._offsets, self._slope)
        self._sum = _per_block(np.einsum("ij,ij->j", self._residuals, self._residuals))

    def bent(self) -> bool:
        """Whether a parabola fits significantly better, in translation or rotation."""
        u = self._offsets
        bow = u * u
        bow -= bow.mean() + u * (u @ bow / self._spread)
        explained = _per_block((bow @ self._residuals) ** 2) / float(bow @ bow)
        left = np.maximum(self._sum - explained, 0.0) / (3 * (self._count - 3)) + _ROUNDING
        return bool((explained / 3.0 > BENT * left).any())

    def believed(self, early: float) -> LineFit:
        """The line with the part of its slope that is not noise; see ``EARLY_S`` for ``early``."""
        variance = self._sum / (3 * (self._count - 2))
        assumed = variance + early * _EARLY_VARIANCE + _ROUNDING
        signal = _per_block(self._slope**2) * (self._spread / 3.0)
        kept = np.maximum(0.0, 1.0 - BELIEVED * assumed / np.maximum(signal, _ROUNDING))
        slope = np.repeat(kept, 3) * self._slope
        m, rad = np.sqrt(variance).tolist()
        return LineFit(self._mean - self._middle * slope, slope, (m, rad))


def _per_block(columns: Array) -> Array:
    """Sums over the three columns of the translation and of the rotation (2)."""
    return np.array([columns[block].sum() for block in _BLOCKS])

"""Derivatives of a sampled angle at its newest sample, or one period later.

Least-squares polynomials through the last samples, evaluated at the end of the window
(Savitzky and Golay): T6 travels as float32, which leaves about 3e-8 rad of noise on a joint angle,
and a plain third difference at 4 ms turns that into 2 rad/s3.

Chosen on the golden trajectories (Cartesian segment, moving goal; 5 ms), one period ahead, as the
sum of what float32 noise and what the polynomial's degree leave of velocity, acceleration, jerk::

    degree window   noise (rms)                bias (largest)
    3       4       7.6e-5  1.4e-2  1.1        1.7e-6  4.7e-4  0.08     (plain differences)
    3       8       1.3e-5  1.3e-3  0.06       8.0e-6  1.4e-3  0.14
    3       10      8.7e-6  7.2e-4  0.03       1.4e-5  2.0e-3  0.17
    4       8       3.8e-5  6.3e-3  0.61       2.2e-7  5.4e-5  0.009
    4       10      2.2e-5  3.1e-3  0.25       4.3e-7  9.1e-5  0.012    (taken)
    4       12      1.5e-5  1.8e-3  0.12       7.7e-7  1.4e-4  0.017

Degree 4 keeps its bias small when a motion is faster than the golden ones (bias grows with the
fifth power of speed, noise not at all), and ten samples bring the acceleration's noise down to
that of the samples' own second difference, 2.9e-3 rad/s2. The position itself, one period ahead,
has 1e-7 rad of noise and 1e-9 rad of bias: a tenth of a hundredth of an encoder count.
"""

from collections import deque
from itertools import islice
from operator import mul
from typing import Final

import numpy as np

from rfms_can.blend import Derivatives

WINDOW: Final = 10
"""Samples a fit looks at once so many have been seen."""

_DEGREE: Final = (0, 0, 1, 2, 3, 3, 3, 3, 4, 4, 4)
"""Degree of the fit by the number of samples; four for five would only fit the noise."""

_Weights = tuple[tuple[float, ...], ...]


def _weights(count: int, ahead: int) -> _Weights:
    """Four rows (order 0 to 3) of ``count`` weights, oldest first, for a period of one."""
    times = np.arange(1 - count, 1) - ahead
    degree = _DEGREE[count]
    fit = np.linalg.pinv(np.vander(times, degree + 1, increasing=True).astype(float))
    rows = [fit[order] * (1, 1, 2, 6)[order] for order in range(min(degree, 3) + 1)]
    rows += [np.zeros(count)] * (4 - len(rows))
    return tuple(tuple(float(weight) for weight in row) for row in rows)


_NEWEST: Final = tuple(_weights(count, 0) for count in range(1, WINDOW + 1))
_AHEAD: Final = tuple(_weights(count, 1) for count in range(1, WINDOW + 1))


class SampleHistory:
    """The last samples of an angle, one each period, and the derivatives they tell.

    Equal samples give derivatives of exactly zero: a joint at rest does not dither. With fewer
    samples than a derivative needs it is zero.
    """

    __slots__ = ("_samples",)

    def __init__(self) -> None:
        self._samples: deque[float] = deque(maxlen=WINDOW)

    def __len__(self) -> int:
        return len(self._samples)

    @property
    def newest(self) -> float:
        """The last sample, rad."""
        return self._samples[-1]

    def clear(self) -> None:
        """Forget all samples."""
        self._samples.clear()

    def push(self, sample: float) -> None:
        """Take this period's sample, rad."""
        self._samples.append(sample)

    def extrapolate(self) -> None:
        """Stand in for a sample that did not come: the newest, moved on by the last difference."""
        samples = self._samples
        if samples:
            last = samples[-1]
            samples.append(last + (last - samples[-2]) if len(samples) > 1 else last)

    def at_newest(self, period_s: float) -> Derivatives:
        """Angle and derivatives at the newest sample; rad and seconds."""
        last = self._samples[-1]
        _, velocity, acceleration, jerk = self._fit(_NEWEST, period_s)
        return (last, velocity, acceleration, jerk)

    def one_ahead(self, period_s: float) -> Derivatives:
        """Angle and derivatives one period after the newest sample; rad and seconds."""
        return self._fit(_AHEAD, period_s)

    def _fit(self, tables: tuple[_Weights, ...], period_s: float) -> Derivatives:
        samples = self._samples
        last = samples[-1]
        # Differences to the newest first: their weighted sum is exactly zero at rest.
        steps = [sample - last for sample in islice(samples, len(samples) - 1)]
        w0, w1, w2, w3 = tables[len(samples) - 1]
        return (
            last + sum(map(mul, w0, steps)),
            sum(map(mul, w1, steps)) / period_s,
            sum(map(mul, w2, steps)) / period_s**2,
            sum(map(mul, w3, steps)) / period_s**3,
        )

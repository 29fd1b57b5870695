"""Derivatives of a sampled angle at its newest sample, or one period later.

Least-squares polynomials through the last samples, evaluated at the end of the window (Savitzky
and Golay). T6 travels as float32, which leaves about 3e-8 rad of noise on a joint angle; a plain
third difference at 4 ms turns that into 2 rad/s3, and a transition carries an error of jerk on
as a path error that grows with t_acc^3. So the window grows with the acceleration time.

On the golden trajectories (Cartesian segment, moving goal; 5 ms), one period ahead::

    degree window   noise, rms                          bias, largest
                    rad     rad/s   rad/s2  rad/s3      rad     rad/s   rad/s2  rad/s3
    3       4       2.5e-7  7.6e-5  1.3e-2  1.1         4e-9    1.7e-6  4.7e-4  0.08
    3       10      5.8e-8  8.7e-6  7.2e-4  0.026       5e-8    1.4e-5  2.0e-3  0.17
    4       10      9.9e-8  2.2e-5  3.1e-3  0.25        1e-9    4.3e-7  9.1e-5  0.012
    4       16      5.7e-8  8.7e-6  8.0e-4  0.042       8e-9    2.0e-6  2.9e-4  0.027
    4       20      4.7e-8  5.8e-6  4.4e-4  0.019       2e-8    4.2e-6  5.2e-4  0.039
    4       32      3.2e-8  2.6e-6  1.3e-4  0.003       1e-7    2.0e-5  1.7e-3  0.084

Degree 4 because bias grows with the fifth power of a motion's speed and noise does not. Ten samples
reduce the acceleration's noise to that of the samples' own second difference
(2.9e-3 rad/s2); windows of half the acceleration time, 10 to 32 samples, keep the path error
under 1e-5 rad at t_acc = 0.2 s.

A transition of twice t_acc multiplies noise of jerk by its third power, and a low feed rate makes
t_acc long. One of more than 256 periods is matched over 128 samples, and derivatives that would
still cause a path error of more than 1e-4 rad rms are not matched (``matched_for``): jerk beyond
1400 periods, acceleration beyond 2800. Largest path error of a transition, rms, from 3e-8 rad of
noise (independent of the period)::

    t_acc   window      from rate   acceleration    jerk, rad
    40      20          6e-7        1.8e-6          1.6e-6
    200     32          1.2e-6      1.3e-5          3.8e-5
    256     32          1.6e-6      2.3e-5          8.1e-5
    257     128         1.9e-7      7e-7            6e-7
    1000    128         7e-7        1.0e-5          3.6e-5
    1400    128         9e-7        1.9e-5          1.0e-4
    2800    128         2.0e-6      8.3e-5          (8.4e-4)
    10000   128         7e-6        (1.0e-3)        (3.6e-2)

Where the straight part before a transition is shorter than the window, the fit reaches back into
the transition before it, by a quarter of that one's t_acc at most: the last eighth of h (3.15) is a
straight line but for 2 % of t_acc. Ten samples before a t_acc of 143 periods would be off by
8e-4 rad rms, 24 samples are by 4e-5 (``least_for``).
"""

from collections import deque
from itertools import islice
from operator import mul
from typing import Final

import numpy as np

from rfms_can.setpoint.blend import Derivatives

SHORTEST: Final = 10
"""Smallest window of a fit, samples, if available."""

LONG: Final = 32
"""Largest window of a fit, samples, unless the transition is slow."""

LONGEST: Final = 128
"""Window for a slow transition, samples; ``LONG`` if fewer are available."""

SLOW_TICKS: Final = 256
"""Acceleration time in periods beyond which a transition is slow."""

JERK_TICKS: Final = 1400
"""Acceleration time in periods beyond which an estimated jerk is worse than none."""

ACCELERATION_TICKS: Final = 2800
"""Acceleration time in periods beyond which an estimated acceleration is worse than none."""

NOISY: Final = 6
"""t_acc over the samples that are fitted, from which on noise moves the path by 5e-5 rad rms."""

REACH: Final = 4
"""t_acc over the part of it that samples may reach back into."""

_Weights = tuple[tuple[float, ...], ...]


def window_for(acceleration_ticks: int) -> int:
    """Samples to fit for a transition of twice ``acceleration_ticks``."""
    if acceleration_ticks > SLOW_TICKS:
        return LONGEST
    return min(max(acceleration_ticks // 2, SHORTEST), LONG)


def least_for(acceleration_ticks: int, before: int) -> int:
    """Samples to fit for such a transition even if they reach back into another.

    Args:
        acceleration_ticks: t_acc of the transition, periods.
        before: that of the transition that is reached back into.
    """
    if acceleration_ticks >= REACH * LONGEST:
        wanted = LONGEST
    else:
        wanted = min(acceleration_ticks // NOISY, LONG)
    return max(SHORTEST, min(wanted, before // REACH))


def matched_for(acceleration_ticks: int, difference: Derivatives) -> Derivatives:
    """``difference`` without the orders whose noise such a transition would amplify too much."""
    position, velocity, acceleration, jerk = difference
    if acceleration_ticks > JERK_TICKS:
        jerk = 0.0
    if acceleration_ticks > ACCELERATION_TICKS:
        acceleration = 0.0
    return (position, velocity, acceleration, jerk)


def _degree(count: int) -> int:
    """Degree of the fit to ``count`` samples: a jerk from fewer than eight is only noise."""
    if count >= SHORTEST:
        return 4
    return 3 if count >= 8 else min(count - 1, 2)


def _weights(count: int, ahead: int) -> _Weights:
    """Four rows (order 0 to 3) of ``count`` weights, oldest first, for a period of one."""
    degree = _degree(count)
    times = (np.arange(1 - count, 1) - ahead) / count
    fit = np.linalg.pinv(np.vander(times, degree + 1, increasing=True))
    rows = np.zeros((4, count))
    for order in range(min(degree, 3) + 1):
        rows[order] = fit[order] * (1.0, 1.0, 2.0, 6.0)[order] / float(count) ** order
    return tuple(tuple(row) for row in rows.tolist())


_COUNTS: Final = (*range(1, LONG + 1), LONGEST)
_NEWEST: Final = {count: _weights(count, 0) for count in _COUNTS}
_AHEAD: Final = {count: _weights(count, 1) for count in _COUNTS}


class SampleHistory:
    """The last samples of an angle, one each period, and the derivatives estimated from them.

    Equal samples give derivatives of exactly zero: a joint at rest does not dither. With fewer
    samples than a derivative needs it is zero. A ``window`` is the number of the last samples used,
    or all of them if there are fewer.
    """

    __slots__ = ("_samples",)

    def __init__(self) -> None:
        self._samples: deque[float] = deque(maxlen=LONGEST)

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
        """Append this period's sample, rad."""
        self._samples.append(sample)

    def extrapolate(self) -> None:
        """Replace a missing sample by extrapolation."""
        if self._samples:
            self._samples.append(self.one_ahead(1.0)[0])

    def at_newest(self, period_s: float, window: int = SHORTEST) -> Derivatives:
        """Angle and derivatives at the newest sample; rad and seconds."""
        return self._fit(_NEWEST, period_s, window)

    def one_ahead(self, period_s: float, window: int = SHORTEST) -> Derivatives:
        """Angle and derivatives one period after the newest sample; rad and seconds."""
        return self._fit(_AHEAD, period_s, window)

    def _fit(self, tables: dict[int, _Weights], period_s: float, window: int) -> Derivatives:
        samples = self._samples
        last = samples[-1]
        count = min(window, len(samples))
        if LONG < count < LONGEST:
            count = LONG
        # Differences to the newest first: their weighted sum is exactly zero at rest.
        steps = [sample - last for sample in islice(samples, len(samples) - count, None)]
        w0, w1, w2, w3 = tables[count]
        return (
            last + sum(map(mul, w0, steps)),
            sum(map(mul, w1, steps)) / period_s,
            sum(map(mul, w2, steps)) / period_s**2,
            sum(map(mul, w3, steps)) / period_s**3,
        )

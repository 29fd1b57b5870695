"""Jumps of a reference, faded within the limits of the mode that moves the arm.

An observation replaces the prediction that the arm follows by another one. What lies between them,
a translation and a rotation vector, is added to the new prediction and faded by matching
polynomials (3.18), so that the motion is continuous up to its jerk. The next observation comes long
before that is over: the fade that follows takes over all that is left, with its velocity,
acceleration and jerk. Noise that came with one observation and went with the next so leaves nothing
behind, and a horizon that recedes with each of them is a stable filter without lag at constant
velocity.

Metres, radians and seconds.
"""

import math
from collections.abc import Sequence
from typing import Final, NamedTuple, Self

import numpy as np
import numpy.typing as npt

from rfms_can.master.world.modes import Limits
from rfms_can.setpoint.blend import Derivatives, MatchingPolynomial
from rfms_can.transform import Vector6

Array = npt.NDArray[np.float64]

SHORTEST_SPAN_S: Final = 0.2
"""Noise of the observations is faded too, s: with 0.2 mm of it at 50 Hz the tool then accelerates
by 0.2 m/s2 rms. Over half of that it would be 0.6, and at the limits of the mode."""

KEPT: Final = 0.8
"""Part of the limits that is used from rest: the rest is for the noise of what is observed next."""

MOST: Final = 0.97
"""Part of the limits that is used at all: accelerations are judged at some samples only."""

NOTHING: Final = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

_SAMPLES: Final = np.linspace(0.0, 1.0, 33)
"""Values of p at which accelerations are judged."""

_BLOCK: Final = 32
"""Spans that are tried at a time."""

_BLOCKS: Final = 2
"""Blocks that are tried in motion: over longer spans a jerk that is there would do harm."""

_BLOCKS_AT_REST: Final = 4
"""Blocks that are tried at rest: up to an hour."""

_SPANS: Final = SHORTEST_SPAN_S * 1.08 ** np.arange(_BLOCK * _BLOCKS_AT_REST)

_UNITS: Final = [
    MatchingPolynomial.matching(unit, 0.5).coefficients
    for unit in (
        (1.0, 0.0, 0.0, 0.0),
        (0.0, 1.0, 0.0, 0.0),
        (0.0, 0.0, 1.0, 0.0),
        (0.0, 0.0, 0.0, 1.0),
    )
]
"""Power series in p of the fades of a unit position, velocity, acceleration and jerk per span."""

_CURVATURES: Final = np.array([np.polyval(np.polyder(unit[::-1], 2), _SAMPLES) for unit in _UNITS])
"""Their second derivatives at the samples (4, n)."""

_SCALED: Final = np.array(
    [span ** (k - 2.0) * row for span in _SPANS for k, row in enumerate(_CURVATURES)]
).reshape(len(_SPANS), 4, len(_SAMPLES))
"""The same per second squared, for all spans (spans, 4, n)."""


class Fade(NamedTuple):
    """A difference that fades.

    Before the tick it began at, its polynomials go on backwards: that is not what the arm has
    followed, but the motion it now follows, continued. The two agree at that tick in value, rate,
    acceleration and jerk.

    Attributes:
        begin: tick at which a prediction was replaced.
        step: p from one tick to the next.
        span: until nothing is left, s.
        polynomials: of the translation x, y, z and the rotation vector x, y, z.
    """

    begin: int
    step: float
    span: float
    polynomials: tuple[MatchingPolynomial, ...]

    @classmethod
    def over(
        cls, difference: Sequence[Derivatives], begin: int, span: float, period_s: float
    ) -> Self:
        """Fade six differences and their derivatives from a tick on, over ``span`` seconds."""
        polynomials = tuple(MatchingPolynomial.matching(each, 0.5 * span) for each in difference)
        return cls(begin, period_s / span, span, polynomials)

    @property
    def end(self) -> int:
        """The first tick at which nothing is left."""
        return self.begin + math.ceil(1.0 / self.step)

    def at(self, tick: int) -> Vector6:
        """Translation, m, and rotation vector, rad; ``NOTHING`` itself when it is over."""
        p = (tick - self.begin) * self.step
        if p >= 1.0:
            return NOTHING
        x, y, z, ex, ey, ez = self.polynomials
        return (x.at(p), y.at(p), z.at(p), ex.at(p), ey.at(p), ez.at(p))

    def derivatives(self, tick: int) -> tuple[Derivatives, ...]:
        """The six values and their derivatives."""
        p = min((tick - self.begin) * self.step, 1.0)
        return tuple(polynomial.derivatives(p, 0.5 * self.span) for polynomial in self.polynomials)


NO_FADE: Final = Fade.over(((0.0, 0.0, 0.0, 0.0),) * 6, -1, 1.0, 1.0)
"""Nothing to fade, and over before the first tick."""


def shortest_span(
    difference: Sequence[Derivatives],
    limits: Limits,
    lever: float,
    *,
    at_rest: bool,
    at_least: float = SHORTEST_SPAN_S,
) -> float | None:
    """The shortest span, but for 8 %, over which a difference fades within the limits.

    Args:
        difference: of six components, with three derivatives.
        limits: of the acceleration of the fade.
        lever: distance, m, at which rotations move what the limits are for.
        at_rest: whether acceleration and jerk are zero, so that there is one.
        at_least: the shortest one wanted, but for 8 % less, s.

    Returns:
        Seconds; None if it does not exist.
    """
    fraction = KEPT if at_rest else MOST
    every = np.array(difference)
    shortest = int(np.searchsorted(_SPANS, at_least * (1.0 + 1e-9), side="right")) - 1
    for block in range(_BLOCKS_AT_REST if at_rest else _BLOCKS):
        first = block * _BLOCK
        bend = every @ _SCALED[first : first + _BLOCK]  # (spans, 6, n)
        linear = np.sqrt(np.sum(bend[:, :3] ** 2, axis=1))
        angular = np.sqrt(np.sum(bend[:, 3:] ** 2, axis=1))
        keeps = np.all(linear + lever * angular <= fraction * limits.acceleration, axis=1)
        keeps &= np.all(angular <= fraction * limits.angular_acceleration, axis=1)
        keeps[: max(0, shortest - first)] = False
        if keeps.any():
            return float(_SPANS[first + int(np.argmax(keeps))])
    return float(_SPANS[-1]) if at_rest else None

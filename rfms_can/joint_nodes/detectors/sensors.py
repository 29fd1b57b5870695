"""Tachometer against encoder: two sensors of one motion, so neither is believed alone.

One-sided cumulative sums (Page, Continuous inspection schemes, Biometrika 41, 1954) of what the
encoder has moved less what the tachometer says: a difference that lasts is found in three cycles if
it is TACHOMETER_LIMIT, sooner if it is more, and a tachometer that is a few per cent off never is.
"""

from collections.abc import Mapping
from typing import Final

from rfms_can.wire.vocabulary import Parameter

FOUND_CYCLES: Final = 3
"""Cycles after which a difference of TACHOMETER_LIMIT is found."""
SLACK_FRACTION: Final = 0.05
"""Part of the speed by which a tachometer may be off: gain, temperature, ripple."""
SLACK_LIMIT_FRACTION: Final = 0.01
"""The same over the speed limit: offset of its converter, and its rounding."""
VARIATION_FRACTION: Final = 0.1
"""Variation of the encoder's rate over the speed limit: a tachometer shows another code then."""
VARIATION_COUNTS: Final = 3
"""What is added to it: counts of a cycle vary by two at one speed."""


class SensorWatch:
    """Compares what tachometer and encoder of one joint say.

    Args:
        parameters: the node's configuration.

    Attributes:
        limit: difference of rates, rad/s, that is found in ``FOUND_CYCLES``.
        variation_bound: of the way of a cycle, rad, while the tachometer shows one code.
    """

    __slots__ = (
        "_bound",
        "_code",
        "_down",
        "_highest",
        "_lowest",
        "_period",
        "_slack",
        "_up",
        "limit",
        "variation_bound",
    )

    def __init__(self, parameters: Mapping[Parameter, float]) -> None:
        p = parameters
        period, fastest = p[Parameter.PERIOD], p[Parameter.SPEED_LIMIT]
        self.limit: Final = p[Parameter.TACHOMETER_LIMIT]
        self.variation_bound: Final = VARIATION_FRACTION * fastest * period + (
            VARIATION_COUNTS / abs(p[Parameter.COUNTS_PER_UNIT])
        )
        self._period: Final = period
        self._slack: Final = SLACK_LIMIT_FRACTION * fastest
        self._bound: Final = FOUND_CYCLES * period * self.limit
        self.reset()

    def reset(self) -> None:
        """The joint is driven from now on: nothing is known against its sensors."""
        self._up = self._down = 0.0
        self._code: int | None = None
        self._lowest = self._highest = 0.0

    def differ(self, moved: float, speed: float, before: float) -> bool:
        """Take one cycle; whether tachometer and encoder no longer belong to one motion.

        Args:
            moved: by the encoder since the sample before, rad.
            speed, before: by the tachometer now and then, rad/s.
        """
        period = self._period
        off = moved - 0.5 * period * (speed + before)
        slack = period * (self._slack + SLACK_FRACTION * max(abs(speed), abs(before)))
        up, down = self._up + off - slack, self._down - off - slack
        self._up = up = up if up > 0.0 else 0.0
        self._down = down = down if down > 0.0 else 0.0
        return up > self._bound or down > self._bound

    def variation(self, code: int, moved: float) -> float:
        """How the motion has varied while the tachometer has shown one code, rad a cycle.

        Args:
            code: of the velocity ADC.
            moved: by the encoder in the cycle, rad.
        """
        if code != self._code:
            self._code = code
            self._lowest = self._highest = moved
        elif moved > self._highest:
            self._highest = moved
        elif moved < self._lowest:
            self._lowest = moved
        return self._highest - self._lowest

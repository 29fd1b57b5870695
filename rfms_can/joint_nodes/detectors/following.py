"""A rigid joint that does not follow: its torque has not the effect that it should have."""

from collections.abc import Mapping
from typing import Final, NamedTuple

from rfms_can.wire.vocabulary import Parameter


class Excess(NamedTuple):
    """A number that is beyond its bound.

    Attributes:
        value, bound: in the same unit.
    """

    value: float
    bound: float


class FollowingWatch:
    """Bounds the errors of a joint that is to follow.

    Args:
        parameters: the node's configuration.
    """

    __slots__ = ("_error_bound", "_rate_bound", "_stop_bound")

    def __init__(self, parameters: Mapping[Parameter, float]) -> None:
        p = parameters
        self._error_bound: Final = p[Parameter.FOLLOWING_ERROR_LIMIT]
        self._rate_bound: Final = p[Parameter.RATE_ERROR_LIMIT] * p[Parameter.SPEED_LIMIT]
        self._stop_bound = self._rate_bound

    def begin_stop(self, speed: float) -> None:
        """A controlled stop begins at a measured speed, rad/s: it may not get faster."""
        self._stop_bound = abs(speed) + self._rate_bound

    def servoing(self, error: float, rate: float) -> Excess | None:
        """What is too large of an error, rad, and its rate, rad/s; None if neither is."""
        if not -self._rate_bound <= rate <= self._rate_bound:
            return Excess(rate, self._rate_bound)
        return self._strays(error)

    def stopping(self, error: float, speed: float) -> Excess | None:
        """The same of a stop: of the error against its ramp, rad, and the joint's speed, rad/s."""
        if not -self._stop_bound <= speed <= self._stop_bound:
            return Excess(speed, self._stop_bound)
        return self._strays(error)

    def _strays(self, error: float) -> Excess | None:
        if -self._error_bound <= error <= self._error_bound:
            return None
        return Excess(error, self._error_bound)

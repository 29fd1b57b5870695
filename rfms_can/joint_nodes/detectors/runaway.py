"""A joint that drives away from its set-point: a motor, an encoder or an amplifier turned round.

A reversed sign makes a servo push the joint ever farther away, and the controlled stop would push
with it: the torque must go off. What is no runaway is told apart by the motion: a blocked joint
stands still, one that a load takes along, or an obstacle throws back, is brought to rest by its
servo, and so gets slower from cycle to cycle.
"""

from collections.abc import Mapping
from typing import Final

from rfms_can.wire.vocabulary import Parameter

ERROR_FRACTION: Final = 0.5
"""Error from which a motion away counts, over the error at which the proportional torque alone is
the torque limit, or over FOLLOWING_ERROR_LIMIT, the lesser: half the motor's torque pulls the other
way. Of a load that is not known no more than half the torque is planned for."""
ERROR_TIME_S: Final = 0.01
"""But no more than what the speed limit covers in this time. With a reversed sign errors grow by e
in 1 / (2.4 wn), 14 ms at 30 rad/s, so that a joint is at 0.7 of its limit by then."""
SPEED_FRACTION: Final = 0.05
"""Speed away that counts, over the speed limit: at 250 Hz two counts of the encoder in a cycle."""
FAST_FRACTION: Final = 0.5
"""Speed away, over the speed limit, of which the second cycle is enough: a fifth would be faster
than an encoder is believed to be."""
FAST_CYCLES: Final = 2
BRAKED_FRACTION: Final = 0.9
"""Speed over that of the first cycle counted, below which the servo is braking the motion: begin to
count again. In five cycles of 4 ms a servo of 30 rad/s brakes to 0.55."""


class RunawayWatch:
    """Counts the cycles in a row in which a joint moves away from its set-point.

    Args:
        parameters: the node's configuration.
        enough: the count that is a runaway.

    Attributes:
        bound: error from which it counts, rad.
    """

    __slots__ = ("_angle", "_count", "_enough", "_fast", "_first", "_least", "_size", "bound")

    def __init__(self, parameters: Mapping[Parameter, float], enough: int) -> None:
        p = parameters
        bound = p[Parameter.FOLLOWING_ERROR_LIMIT]
        if p[Parameter.KP]:
            bound = min(bound, p[Parameter.TORQUE_LIMIT] / p[Parameter.KP])
        speed = p[Parameter.SPEED_LIMIT]
        self.bound: Final = min(ERROR_FRACTION * bound, ERROR_TIME_S * speed)
        self._least: Final = SPEED_FRACTION * speed * p[Parameter.PERIOD]
        self._fast: Final = FAST_FRACTION * speed * p[Parameter.PERIOD]
        self._enough: Final = enough
        self.reset()

    def reset(self) -> None:
        """Begin to count: the joint is driven from now on."""
        self._count = 0
        self._size = self._angle = self._first = 0.0

    def watch(self, error: float, angle: float) -> bool:
        """Take a cycle's error (set-point less encoder) and encoder angle, rad; whether it runs
        away."""
        size, before, last = abs(error), self._size, self._angle
        self._size, self._angle = size, angle
        if size <= self.bound:
            self._count = 0
            return False
        away = last - angle if error > 0.0 else angle - last
        if away <= self._least or size <= before:
            self._count = 0
            return False
        if not self._count or away < BRAKED_FRACTION * self._first:
            self._first, self._count = away, 1
        else:
            self._count += 1
        return self._count >= (FAST_CYCLES if away > self._fast else self._enough)

"""A joint that drives away from its set-point: a motor, an encoder or an amplifier turned round.

A reversed sign makes a servo push the joint ever farther away, and the controlled stop would push
with it: the torque must go off. Obstacles and loads are told apart by the motion: a blocked joint
stands still, one that an obstacle throws back comes to rest within a few cycles.
"""

from collections.abc import Mapping
from typing import Final

from rfms_can.wire.vocabulary import Parameter

ERROR_FRACTION: Final = 0.5
"""Error from which a motion away counts, over the error at which the proportional torque alone is
the torque limit, or over FOLLOWING_ERROR_LIMIT, the lesser: half the motor's torque pulls the other
way. Of a load that is not known no more than half the torque is planned for."""
SPEED_FRACTION: Final = 0.05
"""Speed away that counts, over the speed limit: at 250 Hz two counts of the encoder in a cycle."""


class RunawayWatch:
    """Counts the cycles in a row in which a joint moves away from its set-point.

    Args:
        parameters: the node's configuration.

    Attributes:
        bound: error from which it counts, rad.
        cycles: counted so far.
    """

    __slots__ = ("_angle", "_size", "_step", "bound", "cycles")

    def __init__(self, parameters: Mapping[Parameter, float]) -> None:
        p = parameters
        bound = p[Parameter.FOLLOWING_ERROR_LIMIT]
        if p[Parameter.KP]:
            bound = min(bound, p[Parameter.TORQUE_LIMIT] / p[Parameter.KP])
        self.bound = ERROR_FRACTION * bound
        self._step = SPEED_FRACTION * p[Parameter.SPEED_LIMIT] * p[Parameter.PERIOD]
        self.reset()

    def reset(self) -> None:
        """Begin to count: the joint is driven from now on."""
        self.cycles = 0
        self._size = self._angle = 0.0

    def watch(self, error: float, angle: float) -> int:
        """Take a cycle's error (set-point less encoder) and encoder angle, rad; the count."""
        size, before, last = abs(error), self._size, self._angle
        self._size, self._angle = size, angle
        if size <= self.bound:
            self.cycles = 0
            return 0
        away = last - angle if error > 0.0 else angle - last
        self.cycles = self.cycles + 1 if away > self._step and size > before else 0
        return self.cycles

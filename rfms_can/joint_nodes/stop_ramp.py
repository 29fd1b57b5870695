"""The controlled stop of one joint (R2): from its commanded motion to rest, then hold."""

from typing import Final

STILL_CYCLES: Final = 12
"""Cycles without an encoder count that mean a joint has come to rest."""
SETTLING_S: Final = 0.5
"""Time after the ramp in which a joint may choose where it rests."""


class StopRamp:
    """Constant deceleration from a position and speed to rest.

    Args:
        position: commanded position when the stop begins, rad.
        speed: commanded speed then, rad/s.
        deceleration: rad/s2, positive.
        period: control period, s.

    Attributes:
        position, speed, acceleration: commanded now; speed 0 once at rest.
    """

    __slots__ = (
        "_angle",
        "_deceleration",
        "_period",
        "_settling",
        "_still",
        "acceleration",
        "position",
        "speed",
    )

    def __init__(self, position: float, speed: float, deceleration: float, period: float) -> None:
        self.position = position
        self.speed = speed
        self.acceleration = 0.0
        self._deceleration = deceleration
        self._angle = position
        self._still = 0
        self._settling = round(SETTLING_S / period)
        self._period = period

    def watch(self, angle: float) -> None:
        """Take the measured angle, rad; hold where the joint comes to rest after the ramp.

        A stopped joint has no goal but to stand still: driving it to the end of the ramp would
        move it once more. After ``SETTLING_S`` the position is fixed: it does not yield.
        """
        if self.speed or self._settling <= 0:
            return
        self._settling -= 1
        self._still = self._still + 1 if angle == self._angle else 0
        self._angle = angle
        if self._still >= STILL_CYCLES:
            self.position = angle

    def step(self) -> None:
        """Advance one control period."""
        before, change = self.speed, self._deceleration * self._period
        if abs(before) <= change:
            self.speed = 0.0
        else:
            self.speed = before - change if before > 0.0 else before + change
        self.acceleration = (self.speed - before) / self._period
        self.position += 0.5 * (before + self.speed) * self._period

"""The controlled stop of one joint (R2): from its commanded motion to rest, then hold."""


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

    __slots__ = ("_deceleration", "_period", "acceleration", "position", "speed")

    def __init__(self, position: float, speed: float, deceleration: float, period: float) -> None:
        self.position = position
        self.speed = speed
        self.acceleration = 0.0
        self._deceleration = deceleration
        self._period = period

    def step(self) -> None:
        """Advance one control period."""
        before, change = self.speed, self._deceleration * self._period
        if abs(before) <= change:
            self.speed = 0.0
        else:
            self.speed = before - change if before > 0.0 else before + change
        self.acceleration = (self.speed - before) / self._period
        self.position += 0.5 * (before + self.speed) * self._period

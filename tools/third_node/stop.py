"""The controlled stop, and a joint that runs away (docs/node-law.md, docs/node.md)."""

from third_node.configuration import Parameters


class Stop:
    """From a position, rad, and a speed, rad/s, to rest."""

    def __init__(self, p: Parameters, position: float, speed: float) -> None:
        self.p = p
        end = p.POSITION_MAX if speed > 0 else p.POSITION_MIN
        room = max(abs(end - position), 1 / abs(p.COUNTS_PER_UNIT))
        self.deceleration = max(p.ACCELERATION_LIMIT, speed**2 / (2 * room))
        self.left = round(0.5 / p.PERIOD)
        self.still = 0
        self.angle = position
        self.position = position
        self.speed = speed
        self.acceleration = 0.0

    def ramp(self, theta: float) -> None:
        """One MEASURE further; theta as measured, rad."""
        tau, before = self.p.PERIOD, self.speed
        change = self.deceleration * tau
        if abs(before) <= change:
            self.speed = 0.0
        else:
            self.speed = before - (change if before > 0 else -change)
        self.acceleration = (self.speed - before) / tau
        self.position += (before + self.speed) / 2 * tau
        if self.speed == 0 and self.left > 0:
            self.left -= 1
            self.still = self.still + 1 if theta == self.angle else 0
            self.angle = theta
            if self.still >= 12:
                self.position = theta


class Runaway:
    """Whether a rigid joint moves away from its set-point."""

    def __init__(self, p: Parameters) -> None:
        least = p.FOLLOWING_ERROR_LIMIT
        if p.KP > 0:
            least = min(least, p.TORQUE_LIMIT / p.KP)
        self.bound = min(0.5 * least, 0.01 * p.SPEED_LIMIT)
        self.step = p.SPEED_LIMIT * p.PERIOD
        self.reset()

    def reset(self) -> None:
        """The joint begins to be driven."""
        self.size = self.angle = self.first = 0.0
        self.count = 0

    def watch(self, e: float, angle: float) -> bool:
        """A cycle's error and angle, rad; whether it runs away."""
        grows = abs(e) > self.size
        away = self.angle - angle if e > 0 else angle - self.angle
        self.size, self.angle = abs(e), angle
        if abs(e) <= self.bound or away <= 0.05 * self.step or not grows:
            self.count = 0
        elif self.count == 0 or away < 0.9 * self.first:
            self.first = away
            self.count = 1
        else:
            self.count += 1
        return self.count >= 5 or (self.count >= 2 and away > 0.5 * self.step)

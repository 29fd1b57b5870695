"""docs/node-law.md: homing and the controlled stop."""

import math

from support.plain_node.law import PlainLaw, sign


class PlainHoming:
    """The search for the index, with the torque of the law above."""

    def __init__(self, law: PlainLaw) -> None:
        self.law = law
        self.zero: int | None = None
        self.begin()

    def begin(self) -> None:
        """HOMING begins."""
        self.law.reset()
        self.target: float | None = None
        self.offset: float | None = None
        self.found = self.zero is not None
        self.failed = False
        self.n = self.stuck = 0
        self.counts: int | None = None

    def cycle(
        self, counts: int, coarse_adc: int, index: int | None, speed: float, G: float
    ) -> float:
        """Torque of a cycle; see ``found`` and ``failed``."""
        p = self.law.p
        per, interval = p["COUNTS_PER_UNIT"], p["INDEX_INTERVAL_COUNTS"]
        coarse = p["COARSE_ZERO"] + coarse_adc * p["COARSE_PER_CODE"]
        theta = (counts - (self.zero or 0)) / per
        if self.target is None:
            self.target = theta
        if self.offset is None:
            self.offset = coarse - theta
        elif abs(coarse - theta - self.offset) > 0.25 * interval / abs(per):
            self.failed = True
            return 0.0
        rate = 0.0
        if not self.found:
            if index is not None:
                x = (coarse * per - (counts - index)) / interval
                if abs(x - round(x)) > 0.25:
                    self.failed = True
                    return 0.0
                self.zero, self.found = index - round(x) * round(interval), True
                new = (counts - self.zero) / per
                self.target, self.offset = self.target + new - theta, self.offset - (new - theta)
                theta = new
            else:
                self.n += 1
                stands = counts == self.counts and self.law.at_limit
                self.stuck = self.stuck + 1 if stands else 0
                self.counts = counts
                if self.n > math.ceil(p["HOMING_TIME"] / p["PERIOD"]) or self.stuck > math.ceil(
                    p["STUCK_TIME"] / p["PERIOD"]
                ):
                    self.failed = True
                    return 0.0
                middle = (p["POSITION_MIN"] + p["POSITION_MAX"]) / 2
                rate = p["HOMING_SPEED"] if coarse < middle else -p["HOMING_SPEED"]
                self.target += rate * p["PERIOD"]
        F = self.law.rigid(rate)
        return self.law.alone(self.target - theta, rate - speed, G, F, 0.0)


class PlainStop:
    """The controlled stop."""

    def __init__(self, law: PlainLaw, position: float, speed: float) -> None:
        p = law.p
        end = p["POSITION_MAX"] if speed > 0 else p["POSITION_MIN"]
        room = max(abs(end - position), 1 / abs(p["COUNTS_PER_UNIT"]))
        self.law, self.position, self.speed = law, position, speed
        self.dec = max(p["ACCELERATION_LIMIT"], speed**2 / (2 * room))
        self.left, self.still, self.angle = round(0.5 / p["PERIOD"]), 0, position

    def cycle(self, theta: float, measured_speed: float, G: float, Mi: float) -> float:
        """Torque at a MEASURE."""
        tau, before = self.law.p["PERIOD"], self.speed
        step = self.dec * tau
        self.speed = 0.0 if abs(before) <= step else before - sign(step, before)
        acc = (self.speed - before) / tau
        self.position += (before + self.speed) / 2 * tau
        if self.speed == 0 and self.left > 0:
            self.left -= 1
            self.still = self.still + 1 if theta == self.angle else 0
            self.angle = theta
            if self.still >= 12:
                self.position = theta
        F = self.law.rigid(self.speed)
        return self.law.alone(self.position - theta, self.speed - measured_speed, G, F, Mi * acc)

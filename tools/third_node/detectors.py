"""What a joint finds wrong with its sample, its drive and its rows (docs/node-detectors.md)."""

import math

from third_node.configuration import Parameters
from third_node.integral import clamp
from third_node.law import Rows

RAILS = (-2048, 2047)


class Tachometer:
    """3 and 4: a tachometer held against the encoder, and one that shows one value."""

    def __init__(self, p: Parameters) -> None:
        self.p = p
        self.most_varied = 0.1 * p.SPEED_LIMIT * p.PERIOD + 3 / abs(p.COUNTS_PER_UNIT)
        self.clear()

    def clear(self) -> None:
        """The joint is not driven."""
        self.up = self.down = 0.0
        self.code: int | None = None
        self.low = self.high = 0.0

    def differs(self, moved: float, v: float, before: float) -> bool:
        """A cycle's motion of the encoder, rad, and speeds, rad/s."""
        tau, fastest = self.p.PERIOD, self.p.SPEED_LIMIT
        d = moved - tau * (v + before) / 2
        s = tau * (0.01 * fastest + 0.05 * max(abs(v), abs(before)))
        self.up = max(0.0, self.up + d - s)
        self.down = max(0.0, self.down - d - s)
        return max(self.up, self.down) > 3 * tau * self.p.TACHOMETER_LIMIT

    def variation(self, code: int, moved: float) -> float:
        """How the encoder's motions, rad a cycle, differ under one code."""
        if code != self.code:
            self.low = self.high = moved
        self.code = code
        self.low, self.high = min(self.low, moved), max(self.high, moved)
        return self.high - self.low


class Amplifier:
    """1 and 6: the current held against the DACs."""

    def __init__(self, p: Parameters) -> None:
        self.p = p
        self.driven: list[float] = []

    def clear(self) -> None:
        """The brake holds, or the joint is not driven."""
        self.driven = []

    def drive(self, current: int, force: int) -> None:
        """A DAC that went out."""
        both = current + force * self.p.TORQUE_PER_FORCE_CODE / self.p.TORQUE_PER_CODE
        self.driven = [*self.driven[-4:], min(max(both, RAILS[0]), RAILS[1])]

    def border_passed(self, current: int) -> float | None:
        """The border that a current code is beyond; None if the DACs explain it."""
        if len(self.driven) < 5:
            return None
        low, high = min(self.driven), max(self.driven)
        low -= self.tolerance(low)
        high += self.tolerance(high)
        if current > high:
            return high
        return low if current < low else None

    def tolerance(self, code: float) -> float:
        """By which a current may be off, codes."""
        return 2048 * self.p.CURRENT_TOLERANCE + 0.1 * abs(code)


class Following:
    """8: a rigid joint that does not follow."""

    def __init__(self, p: Parameters) -> None:
        self.p = p
        self.rate_bound = self.stop_bound = p.RATE_ERROR_LIMIT * p.SPEED_LIMIT

    def begin_stop(self, v: float) -> None:
        """A stop begins at a measured speed, rad/s."""
        self.stop_bound = abs(v) + self.rate_bound

    def excess(self, error: float, rate: float) -> tuple[float, float] | None:
        """What is too large in OPERATIONAL, and its bound."""
        return self.first(((rate, self.rate_bound), (error, self.p.FOLLOWING_ERROR_LIMIT)))

    def excess_of_stop(self, error: float, v: float) -> tuple[float, float] | None:
        """The same on the stop ramp."""
        return self.first(((v, self.stop_bound), (error, self.p.FOLLOWING_ERROR_LIMIT)))

    @staticmethod
    def first(pairs: tuple[tuple[float, float], ...]) -> tuple[float, float] | None:
        """The first value that is beyond its bound."""
        return next(((value, bound) for value, bound in pairs if abs(value) > bound), None)


class Motor:
    """9 and 10: a joint that pushes and does not turn, a motor that becomes too hot."""

    def __init__(self, p: Parameters) -> None:
        self.p = p
        self.longest = math.ceil(p.STALL_TIME / p.PERIOD)
        self.bound = p.OVERLOAD_TIME * (p.TORQUE_LIMIT**2 - p.CONTINUOUS_TORQUE**2)
        self.run = 0
        self.heat = 0.0

    def stalls(self, cut: bool, v: float) -> bool:
        """A torque of the servo or the stop ramp: whether it was cut to the limit."""
        self.run = self.run + 1 if cut and abs(v) < 0.02 * self.p.SPEED_LIMIT else 0
        return self.run > self.longest

    def overheats(self, torque: float) -> bool:
        """A cycle at a torque, Nm."""
        p = self.p
        self.heat = max(0.0, self.heat + p.PERIOD * (torque**2 - p.CONTINUOUS_TORQUE**2))
        return abs(torque) > p.CONTINUOUS_TORQUE and self.heat > self.bound


def implausible(p: Parameters, joint: int, new: Rows, old: Rows) -> tuple[float, float] | None:
    """11: the number of a set of rows that cannot be, and its bound."""
    i, limit = joint - 1, p.TORQUE_LIMIT
    if abs(new.gravity) > limit:
        return new.gravity, limit
    change = new.gravity - old.gravity
    if old.set != 0 and abs(change) > 0.25 * limit:
        return change, 0.25 * limit
    own, most = new.inertia[i], 0.0
    if p.NATURAL_FREQUENCY != 0:
        most = 10 * p.KP / p.NATURAL_FREQUENCY**2
    if own < 0 or (most > 0 and own > most):
        return own, most
    if new.selection != 0:
        return None
    due, margin = new.inertia, 1e-3 * own
    if new.law == 0:
        due, margin = [float(j == i) for j in range(6)], 1e-3
    off = [abs(x - y) for x, y in zip(new.law_row, due, strict=True)]
    farthest = off.index(max(off))
    return (new.law_row[farthest], due[farthest]) if off[farthest] > margin else None


def rest_of(p: Parameters, angle: float, speed: float) -> float:
    """7: where a motion comes to rest at ACCELERATION_LIMIT, rad."""
    return angle + speed * abs(speed) / (2 * p.ACCELERATION_LIMIT)


def stop_begin(
    p: Parameters, told: tuple[float, float], measured: tuple[float, float]
) -> tuple[float, float]:
    """Where the stop ramp begins, rad, and how fast, rad/s; commanded and measured motion."""
    (at, w), (theta, v) = told, measured
    speed = 0.0
    if w * v > 0:
        speed = math.copysign(min(abs(w), abs(v), p.SPEED_LIMIT), w)
    step = 1.5 * p.SPEED_LIMIT * p.PERIOD
    return theta + clamp(at - theta, step / 4), speed

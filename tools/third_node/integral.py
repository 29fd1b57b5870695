"""The integral, and the transfer where what complies changes (docs/node-law.md)."""

from collections.abc import Sequence

from third_node.configuration import Parameters
from third_node.friction import Friction


def clamp(x: float, bound: float) -> float:
    """x cut to -bound ... bound."""
    return min(max(x, -bound), bound)


class Integral:
    """Six sums, Nm."""

    def __init__(self, joint: int, p: Parameters) -> None:
        self.i = joint - 1
        self.p = p
        self.sums = [0.0] * 6
        self.value = 0.0  # I of the cycle before
        self.was_rigid = True

    def add(
        self,
        j: int,
        e: float,
        total: float,
        share: float,
        band: float,
        bound: float,
        friction: Friction,
    ) -> None:
        """One more error of joint j (from 0)."""
        if abs(e) <= band:
            return
        if j == self.i and friction.resting and friction.turn(e):
            return
        if abs(total) >= self.p.TORQUE_LIMIT and total * share * e > 0:
            return
        self.sums[j] = clamp(self.sums[j] + self.p.KI * self.p.PERIOD * e, bound)

    def rigid(self, e: float, x_and_f: float, friction: Friction) -> float:
        """Of the own error alone."""
        p = self.p
        total = x_and_f + self.sums[self.i]
        self.add(self.i, e, total, 1, p.INTEGRAL_DEADBAND, p.INTEGRAL_LIMIT, friction)
        own = self.sums[self.i]
        self.sums = [0.0] * 6
        self.sums[self.i] = own
        self.value = own
        self.was_rigid = True
        return own

    def complying(
        self,
        errors: Sequence[float],
        x_and_f: float,
        row: Sequence[float],
        f: float,
        friction: Friction,
    ) -> float:
        """Of all six."""
        p = self.p
        if self.was_rigid:
            self.sums = [0.0] * 6
            self.value = 0.0
        self.was_rigid = False
        t = x_and_f + self.value
        for j in range(6):
            self.add(j, errors[j], t, row[j], 2.5e-4, 0.002 * p.KI, friction)
        value = f * sum(r * s for r, s in zip(row, self.sums, strict=True))
        b = 0.3 * p.INTEGRAL_LIMIT
        if abs(value) > b:
            self.sums = [s * (b / abs(value)) for s in self.sums]
            value = b if value > 0 else -b
        self.value = value
        return value


class Transfer:
    """The torque goes on from the one it had, in steps."""

    def __init__(self, limit: float) -> None:
        self.limit = limit
        self.spec: int | None = None
        self.transfer = 0.0
        self.last = 0.0

    def __call__(self, y: float, specification: int) -> float:
        """Torque y, Nm, of a cycle with a specification."""
        limit = self.limit
        if specification != self.spec:
            if self.spec is not None:
                self.transfer = self.last - clamp(y, limit)
            self.spec = specification
        if self.transfer != 0:
            self.transfer -= clamp(self.transfer, 0.006 * limit)
            y = clamp(y, limit) + self.transfer
        self.last = clamp(y, limit)
        return y

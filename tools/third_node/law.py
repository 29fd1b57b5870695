"""Torque and DAC codes, damping (docs/node-law.md)."""

from collections.abc import Sequence

from third_node.codec import Fields
from third_node.configuration import Parameters
from third_node.friction import Friction
from third_node.integral import Integral, Transfer, clamp


class Rows:
    """What a ROWS frame carries, or what holds before any."""

    def __init__(self, joint: int, fields: Fields | None = None) -> None:
        if fields is None:
            fields = {f"law_{joint}": 1.0}
        self.law_row = [fields.get(f"law_{j}", 0.0) for j in range(1, 7)]
        self.inertia = [fields.get(f"inertia_{j}", 0.0) for j in range(1, 7)]
        self.gravity: float = fields.get("gravity", 0.0)
        self.law: int = fields.get("law", 0)
        self.damping: float = fields.get("damping", 0.0)
        self.selection: int = fields.get("selection", 0)
        self.specification: int = fields.get("specification", 0)
        self.set: int = fields.get("set", 0)


def product(row: Sequence[float], of: Sequence[float]) -> float:
    """The sum of six products."""
    return sum(x * y for x, y in zip(row, of, strict=True))


class Law:
    """All memory of the torque of one joint.

    Attributes:
        terms: of the last torque, Nm, by name.
        cut: whether the last torque was cut to its limit.
    """

    def __init__(self, joint: int, parameters: Parameters) -> None:
        self.joint = joint
        self.p = parameters
        self.reset()

    def reset(self) -> None:
        """START, and when homing or a hold begins."""
        self.friction = Friction(self.p)
        self.integral = Integral(self.joint, self.p)
        self.transfer = Transfer(self.p.TORQUE_LIMIT)
        self.error_before = 0.0  # own error of the last cycle
        self.terms: dict[str, float] = {}
        self.cut = False

    def servo(
        self,
        rows: Rows,
        errors: Sequence[Sequence[float]],
        w: float,
        m: float,
        k: int,
        bias: float,
    ) -> float:
        """Torque without bias, Nm; ``errors``: six errors, six rates, six accelerations."""
        e, v, a = errors
        p, i = self.p, self.joint - 1
        own_rate, V = v[i], product(rows.law_row, v)
        wn = p.NATURAL_FREQUENCY
        if rows.law == 0:
            P, D = p.KP * product(rows.law_row, e), p.KD * V
            ratio = p.KP / wn**2 if wn != 0 else 0.0
            damp = rows.damping * ratio * (own_rate - V)
            f = 1.0
        else:
            P, D = wn**2 * product(rows.law_row, e), 2 * p.DAMPING_RATIO * wn * V
            damp = rows.damping * (product(rows.inertia, v) - V)
            f = wn**2 / p.KP if p.KP != 0 else 0.0
        inertia = product(rows.inertia, a)
        X = rows.gravity + inertia + damp + P + D
        if rows.selection == 0:
            F = self.friction.rigid(w)
            I = self.integral.rigid(e[i], X + F, self.friction)  # noqa: E741 (I of the page)
        else:
            F = self.friction.complying(w, m, self.error_before, k)
            I = self.integral.complying(e, X + F, rows.law_row, f, self.friction)  # noqa: E741
        self.error_before = e[i]
        Z = self.transfer(X + I, rows.specification)
        self.cut = abs(Z + F + bias) > p.TORQUE_LIMIT
        total = clamp(Z + F + bias, p.TORQUE_LIMIT)
        self.terms = {
            "proportional": P,
            "derivative": D,
            "integral": I,
            "gravity": rows.gravity,
            "inertia": inertia,
            "friction": F,
            "compliant_damping": damp,
            "bias": bias,
            "transfer": Z - (X + I),
            "saturation": total - (Z + F + bias),
        }
        return total - bias

    def alone(self, e: float, v: float, gravity: float, w: float, inertia: float) -> float:
        """PID on the own error, Nm, for the stop and homing."""
        p = self.p
        F = self.friction.rigid(w)
        X = gravity + F + inertia + p.KP * e + p.KD * v
        total = X + self.integral.rigid(e, X, self.friction)
        self.cut = abs(total) > p.TORQUE_LIMIT
        return clamp(total, p.TORQUE_LIMIT)

    def damped(self, rows: Rows, speed: float) -> float:
        """Torque that brakes, Nm."""
        return rows.gravity + clamp(-self.p.KD * speed, 0.2 * self.p.TORQUE_LIMIT)

    def cut_bias(self, bias: float) -> float:
        """A bias torque, Nm, as the force DAC can make it."""
        return clamp(bias, 2047 * abs(self.p.TORQUE_PER_FORCE_CODE))

    def codes(self, torque: float, bias: float) -> tuple[int, int]:
        """Current and force DAC."""
        force = 0
        if bias != 0:
            force = code(bias / self.p.TORQUE_PER_FORCE_CODE)
        return code(torque / self.p.TORQUE_PER_CODE), force


def code(x: float) -> int:
    """Halves to even, cut at the rails."""
    return int(min(max(round(x), -2048), 2047))

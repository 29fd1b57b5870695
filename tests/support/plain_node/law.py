"""docs/node-law.md: the torque of one joint."""

from collections.abc import Sequence
from typing import Any

Numbers = Sequence[float]


def clamp(x: float, bound: float) -> float:
    """x cut to -bound ... bound."""
    return max(-bound, min(bound, x))


def sign(size: float, of: float) -> float:
    """``size`` with the sign of ``of``."""
    return size if of > 0.0 else -size


class PlainLaw:
    """Torque of one joint, by its parameters (by name) and own number."""

    def __init__(self, parameters: dict[str, float], joint: int) -> None:
        self.p, self.i = parameters, joint - 1
        self.reset()

    def reset(self) -> None:
        """START, and the beginning of HOMING."""
        self.S = [0.0] * 6
        self.I = self.last_own = 0.0
        self.arm_complied = False
        self.coulomb = self.viscous = 0.0
        self.complied, self.left, self.resting = False, 0, True
        self.spec: int | None = None
        self.transferred = self.last = 0.0
        self.at_limit = False

    # friction

    def rigid(self, w: float) -> float:
        """Friction of a rigid joint at commanded speed w."""
        p = self.p
        if self.complied:
            self.left = round(0.1 / p["PERIOD"])
        self.complied = self.resting = False
        c = max(-p["COULOMB_NEGATIVE"], min(p["COULOMB_POSITIVE"], self.coulomb))
        if w > p["FRICTION_SPEED"]:
            c = p["COULOMB_POSITIVE"]
        elif w < -p["FRICTION_SPEED"]:
            c = -p["COULOMB_NEGATIVE"]
        else:
            self.resting = True
        return self.ramp(c, p["VISCOUS"] * w)

    def complying(self, w: float, m: float, k: int) -> float:
        """Friction of a complying joint."""
        p = self.p
        moving = 1.5 * abs(p["RATE_PER_CODE"])
        rests = -moving < m < moving
        wn = p["NATURAL_FREQUENCY"]
        x = w + wn * self.last_own if rests else m
        if not self.complied:
            self.left = round(0.1 / p["PERIOD"])
        self.complied, self.resting = True, False
        full = max(moving, 4 * wn / abs(p["COUNTS_PER_UNIT"])) if rests else moving
        g = clamp(x / full, 1.0)
        size = p["COULOMB_POSITIVE"] if g > 0 else p["COULOMB_NEGATIVE"]
        F = self.ramp(0.98 * g * size, p["VISCOUS"] * x)
        if p["DITHER_FRACTION"] > 0 and rests and self.left == 0:
            half = max(1, round(p["DITHER_PERIOD"] / (2 * p["PERIOD"])))
            up = k % (2 * half) < half
            wave = p["COULOMB_POSITIVE"] if up else -p["COULOMB_NEGATIVE"]
            F += p["DITHER_FRACTION"] * (wave - self.coulomb)
        return F

    def ramp(self, c: float, v: float) -> float:
        """Where compliance begins or ends."""
        if self.left > 0:
            s = 0.006 * self.p["TORQUE_LIMIT"]
            change = c + v - self.coulomb - self.viscous
            reached = abs(change) < s
            self.left = max(self.left - 1, 0 if reached else 1)
            if not reached:
                c = self.coulomb + self.viscous + sign(s, change) - v
        self.coulomb, self.viscous = c, v
        return c + v

    def turned(self, e: float) -> bool:
        """Turn the friction of a resting joint."""
        p = self.p
        s = (p["COULOMB_POSITIVE"] + p["COULOMB_NEGATIVE"]) * p["PERIOD"] / 0.25
        before = self.coulomb
        if e > 0:
            self.coulomb = min(before + s, p["COULOMB_POSITIVE"])
        else:
            self.coulomb = max(before - s, -p["COULOMB_NEGATIVE"])
        return self.coulomb != before

    # integral

    def add(self, j: int, e: float, total: float, share: float, band: float, bound: float) -> None:
        """One step of one sum."""
        if abs(e) <= band:
            return
        if j == self.i and self.resting and self.turned(e):
            return
        if abs(total) >= self.p["TORQUE_LIMIT"] and total * share * e > 0:
            return
        self.S[j] = clamp(self.S[j] + self.p["KI"] * self.p["PERIOD"] * e, bound)

    def integrate_rigid(self, e: float, X: float) -> float:
        """I of a rigid joint; X with friction."""
        p, i = self.p, self.i
        self.arm_complied = False
        self.add(i, e, X + self.S[i], 1.0, p["INTEGRAL_DEADBAND"], p["INTEGRAL_LIMIT"])
        self.I = self.S[i]
        self.S = [self.S[j] if j == i else 0.0 for j in range(6)]
        return self.I

    def integrate_complying(self, e: Numbers, R: Numbers, X: float, f: float) -> float:
        """I while the arm complies; X with friction."""
        if not self.arm_complied:
            self.arm_complied, self.S, self.I = True, [0.0] * 6, 0.0
        t = X + self.I
        for j in range(6):
            self.add(j, e[j], t, R[j], 2.5e-4, 0.002 * self.p["KI"])
        total = f * sum(r * s for r, s in zip(R, self.S, strict=True))
        b = 0.3 * self.p["INTEGRAL_LIMIT"]
        if abs(total) > b:
            self.S = [s * b / abs(total) for s in self.S]
            total = sign(b, total)
        self.I = total
        return total

    # torque

    def transfer(self, Y: float, specification: int) -> float:
        """Where what complies changes."""
        limit = self.p["TORQUE_LIMIT"]
        if specification != self.spec:
            if self.spec is not None:
                self.transferred = self.last - clamp(Y, limit)
            self.spec = specification
        if self.transferred != 0:
            self.transferred -= clamp(self.transferred, 0.006 * limit)
            Y = clamp(Y, limit) + self.transferred
        self.last = clamp(Y, limit)
        return Y

    def torque(self, c: Any, k: int, desired: float, speed: float, bias: float) -> float:
        """Torque without bias; ``c`` has e, v, a, R, M, G, law, mu, selection, specification."""
        p, i = self.p, self.i
        F = self.complying(desired, speed, k) if c.selection else self.rigid(desired)
        B = clamp(bias, 2047 * abs(p["TORQUE_PER_FORCE_CODE"]))
        E = sum(r * e for r, e in zip(c.R, c.e, strict=True))
        V = sum(r * v for r, v in zip(c.R, c.v, strict=True))
        KP, wn = p["KP"], p["NATURAL_FREQUENCY"]
        if c.law == 0:
            P, D, f = KP * E, p["KD"] * V, 1.0
            damp = c.mu * (KP / wn**2 if wn else 0.0) * (c.v[i] - V)
        else:
            P, D, f = wn**2 * E, 2 * p["DAMPING_RATIO"] * wn * V, wn**2 / KP if KP else 0.0
            damp = c.mu * (sum(m * v for m, v in zip(c.M, c.v, strict=True)) - V)
        X = c.G + sum(m * a for m, a in zip(c.M, c.a, strict=True)) + damp + P + D
        self.last_own = c.e[i]
        if c.selection:
            integral = self.integrate_complying(c.e, c.R, X + F, f)
        else:
            integral = self.integrate_rigid(c.e[i], X + F)
        Z = self.transfer(X + integral, c.specification)
        return clamp(Z + F + B, p["TORQUE_LIMIT"]) - B

    def alone(self, e: float, v: float, G: float, F: float, inertia: float) -> float:
        """Torque of one joint alone."""
        X = G + F + inertia + self.p["KP"] * e + self.p["KD"] * v
        total = X + self.integrate_rigid(e, X)
        self.at_limit = abs(total) > self.p["TORQUE_LIMIT"]
        return clamp(total, self.p["TORQUE_LIMIT"])

    def codes(self, torque: float, B: float) -> tuple[int, int]:
        """current_dac and force_dac."""
        current = round(torque / self.p["TORQUE_PER_CODE"])
        force = round(B / self.p["TORQUE_PER_FORCE_CODE"]) if B else 0
        return max(-2048, min(2047, current)), max(-2048, min(2047, force))

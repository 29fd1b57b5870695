"""The friction of a joint (docs/node-law.md, Friction)."""

from third_node.configuration import Parameters


class Friction:
    """What is added against friction, Nm, and its memory."""

    def __init__(self, p: Parameters) -> None:
        self.p = p
        self.coulomb = self.viscous = 0.0
        self.complied = False
        self.left = 0
        self.resting = False
        self.dither = 0.0
        self.ramp_cycles = round(0.1 / p.PERIOD)  # N

    def rigid(self, w: float) -> float:
        """At a commanded speed w, rad/s."""
        p = self.p
        self.dither = 0.0
        if self.complied:
            self.left = self.ramp_cycles
        self.complied = False
        self.resting = False
        c = min(max(self.coulomb, -p.COULOMB_NEGATIVE), p.COULOMB_POSITIVE)
        if w > p.FRICTION_SPEED:
            c = p.COULOMB_POSITIVE
        elif w < -p.FRICTION_SPEED:
            c = -p.COULOMB_NEGATIVE
        else:
            self.resting = True
        return self.ramp(c, p.VISCOUS * w)

    def turn(self, e: float) -> bool:
        """Turn the friction of a resting joint towards an error; whether it did."""
        p = self.p
        s = (p.COULOMB_POSITIVE + p.COULOMB_NEGATIVE) * p.PERIOD / 0.25
        if e > 0:
            new = min(self.coulomb + s, p.COULOMB_POSITIVE)
        else:
            new = max(self.coulomb - s, -p.COULOMB_NEGATIVE)
        turned = new != self.coulomb
        self.coulomb = new
        return turned

    def complying(self, w: float, m: float, error_before: float, k: int) -> float:
        """At commanded speed w and measured speed m, rad/s, in cycle k."""
        p = self.p
        wn = p.NATURAL_FREQUENCY
        moving = 1.5 * abs(p.RATE_PER_CODE)
        rests = -moving < m < moving
        x = w + wn * error_before if rests else m
        if not self.complied:
            self.left = self.ramp_cycles
        self.complied = True
        self.resting = False
        full = max(moving, 4 * wn / abs(p.COUNTS_PER_UNIT)) if rests else moving
        g = min(max(x / full, -1.0), 1.0)
        side = p.COULOMB_POSITIVE if g > 0 else p.COULOMB_NEGATIVE
        f = self.ramp(0.98 * g * side, p.VISCOUS * x)
        self.dither = 0.0
        if p.DITHER_FRACTION > 0 and rests and self.left == 0:
            half = max(1, round(p.DITHER_PERIOD / (2 * p.PERIOD)))
            goal = p.COULOMB_POSITIVE if k % (2 * half) < half else -p.COULOMB_NEGATIVE
            self.dither = p.DITHER_FRACTION * (goal - self.coulomb)
        return f + self.dither

    def ramp(self, c: float, v: float) -> float:
        """Coulomb and viscous torque, in steps where compliance begins or ends."""
        if self.left > 0:
            s = 0.006 * self.p.TORQUE_LIMIT
            change = c + v - self.coulomb - self.viscous
            reached = abs(change) < s
            self.left = max(self.left - 1, 0 if reached else 1)
            if not reached:
                c = self.coulomb + self.viscous + (s if change > 0 else -s) - v
        self.coulomb, self.viscous = c, v
        return c + v

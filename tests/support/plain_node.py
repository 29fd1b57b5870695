"""The handbook's formulas once more, plain and slow, as docs/node.md and its pages print them.

Written after the pages, line for line, and not after the code: where the two disagree a page is wrong.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

Numbers = Sequence[float]
NAN = math.nan


def clamp(x: float, bound: float) -> float:
    """x cut to -bound ... bound."""
    return max(-bound, min(bound, x))


def sign(size: float, of: float) -> float:
    """``size`` with the sign of ``of``."""
    return size if of > 0.0 else -size


class PlainReceiver:
    """docs/node.md, "Protection": the rule of the counters."""

    def __init__(self) -> None:
        self.last: int | None = None
        self.provisional = False
        self.stray, self.row, self.needed = 0, 0, 3
        self.taken_since_stray = False

    def take(self, c: int) -> bool:
        """Whether a frame with counter ``c`` is taken."""
        if self.last is None:
            self.provisional, self.last = True, c
            self.taken_since_stray = True
            return True
        step = (c - self.last) % 256
        taken = 1 <= step <= 16 or (self.provisional and step > 0)
        if not taken:
            in_row = self.row > 0 and not self.taken_since_stray
            self.row = self.row + 1 if in_row and 1 <= (c - self.stray) % 256 <= 16 else 1
            self.stray, self.taken_since_stray = c, False
            if self.row == self.needed:
                taken, self.row, self.needed = True, 0, 2 * self.needed
        if taken:
            self.last, self.provisional, self.taken_since_stray = c, False, True
        return taken


# --- docs/node-kinematics.md --------------------------------------------------------------------


def pose_of(o: Numbers, a: Numbers) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """n, o, a, orthonormal; None for no pose."""
    ov, av = np.array(o, float), np.array(a, float)
    aa, oo, oa = av @ av, ov @ ov, ov @ av
    if not (abs(aa - 1) < 1e-5 and abs(oo - 1) < 1e-5 and abs(oa) < 1e-5):
        return None
    av = av / math.sqrt(aa)
    ov = ov - oa / math.sqrt(aa) * av
    ov = ov / math.sqrt(ov @ ov)
    return np.cross(ov, av), ov, av


def link(a: float, d: float, alpha: float, theta: float) -> np.ndarray:
    """Rz(theta) Tz(d) Tx(a) Rx(alpha)."""
    ct, st, ca, sa = math.cos(theta), math.sin(theta), math.cos(alpha), math.sin(alpha)
    return np.array(
        [
            [ct, -st * ca, st * sa, a * ct],
            [st, ct * ca, -ct * sa, a * st],
            [0.0, sa, ca, d],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def solve_all(
    lengths: Numbers, o: Numbers, a: Numbers, p: Numbers, code: int, held: float = 0.0
) -> list[float]:
    """Six angles without turns; NaN where there is no solution."""
    a2, a3, d4, d = lengths
    frame = pose_of(o, a)
    if frame is None:
        return [NAN] * 6
    _, (ox, oy, oz), (ax, ay, az) = frame
    px, py, pz = p
    right, down, flip = code & 1, code & 2, code & 4
    L2 = a3 * a3 + d4 * d4
    L, phi, e = math.sqrt(L2), math.atan2(d4, a3), 1e-6
    q = px * px + py * py
    if q < max(abs(d) - e, 1e-6) ** 2:
        return [NAN] * 6
    V114 = math.sqrt(max(q - d * d, 0.0))
    V114 = -V114 if right else V114
    s = 1.0 / math.sqrt(q * (V114 * V114 + d * d))
    C1, S1 = (V114 * px - d * py) * s, (V114 * py + d * px) * s
    theta1 = math.atan2(S1, C1)
    rho2 = V114 * V114 + pz * pz
    if rho2 < max(abs(a2 - L) - e, 1e-6) ** 2 or rho2 > (a2 + L + e) ** 2:
        return [theta1, *[NAN] * 5]
    K = rho2 + (a2 - L) * (a2 + L)
    M = math.sqrt(max(((a2 + L) ** 2 - rho2) * (rho2 - (a2 - L) ** 2), 0.0))
    M = -M if down else M
    theta2 = math.atan2(K * pz - M * V114, K * V114 + M * pz)
    theta3 = math.atan2(M, rho2 - (a2 * a2 + L2)) - phi
    x = V114 - (K * V114 + M * pz) / (2 * rho2)
    y = pz - (K * pz - M * V114) / (2 * rho2)
    C23, S23 = (x * a3 + y * d4) / L2, (y * a3 - x * d4) / L2
    V113 = C1 * ax + S1 * ay
    V313, V323 = C23 * V113 + S23 * az, C1 * ay - S1 * ax
    C5 = C23 * az - S23 * V113
    h = math.sqrt(V313 * V313 + V323 * V323)
    if h < 1e-5:
        C4, S4 = math.cos(held), math.sin(held)
    else:
        C4, S4 = V313 / h, V323 / h
        if not flip:
            C4, S4 = -C4, -S4
    S5 = -C4 * V313 - S4 * V323
    V112, V132 = C1 * ox + S1 * oy, S1 * ox - C1 * oy
    V312, V332 = C23 * V112 + S23 * oz, C23 * oz - S23 * V112
    S6 = C5 * (S4 * V132 - C4 * V312) - S5 * V332
    C6 = -S4 * V312 - C4 * V132
    wrist = [math.atan2(S4, C4), math.atan2(S5, C5), math.atan2(S6, C6)]
    return [theta1, theta2, theta3, *wrist]


def turn(angle: float, previous: float, low: float, high: float) -> float:
    """The turn that is taken; NaN for none."""
    b = angle - previous
    if -math.pi <= b <= math.pi and low <= angle <= high:
        return angle
    if not math.isfinite(b):
        return NAN
    angle -= 2 * math.pi * round(b / (2 * math.pi))
    if angle > high:
        angle -= 2 * math.pi * math.ceil((angle - high) / (2 * math.pi))
    elif angle < low:
        angle += 2 * math.pi * math.ceil((low - angle) / (2 * math.pi))
    return angle if low <= angle <= high else NAN


# --- docs/node-setpoint.md ----------------------------------------------------------------------


def fit(samples: list[float], asked: int, ahead: int) -> list[float]:
    """Value and three derivatives, for a period of 1."""
    m = min(asked, len(samples))
    m = 32 if 33 <= m <= 127 else m
    g = 4 if m >= 10 else 3 if m >= 8 else min(m - 1, 2)
    newest = samples[-1]
    y = np.array(samples[-m:]) - newest
    t = np.arange(1 - m, 1) - ahead
    scale = float(m)
    c, *_ = np.linalg.lstsq(np.vander(t / scale, g + 1, increasing=True), y, rcond=None)
    c = [*(c / scale ** np.arange(g + 1)), 0.0, 0.0, 0.0, 0.0]
    return [newest + c[0], c[1], 2 * c[2], 6 * c[3]]


class PlainSetpoint:
    """The set-point of one joint; states as their names."""

    def __init__(self, tau: float, theta: float) -> None:
        self.tau = tau
        self.theta = self.prev = theta
        self.s1 = self.s2 = self.theta_BC = self.r = self.r_step = 0.0
        self.rate = self.acceleration = 0.0
        self.since = 0
        self.Q = (0.0, 0.0, 0.0, 0.0)
        self.base: list[float] = []
        self.next: list[float] = []
        self.state = "IDLE"

    def may_follow(self, state: str, mode: str, p: float) -> bool:
        """The table of successions."""
        if state == "LINEAR" and self.state == "IDLE":
            return mode == "CARTESIAN" and p > 0
        return self.state in {
            "IDLE": ("IDLE", "LINEAR", "BLEND"),
            "LINEAR": ("LINEAR", "PRE", "START", "BLEND"),
            "PRE": ("LINEAR", "PRE", "BLEND"),
            "START": ("IDLE", "LINEAR", "PRE"),
            "BLEND": ("START", "BLEND"),
        }[state]

    def cycle(
        self,
        *,
        state: str,
        mode: str,
        blend: str,
        r: float,
        p: float,
        t_acc: float,
        q1: float,
        q2: float | None,
    ) -> bool:
        """One set-point; False if it is refused."""
        if not self.may_follow(state, mode, p) or (state == "START" and mode == "JOINT" and q2 is None):
            return False
        if state == "START":
            angle = self.hand_over(mode, blend, r, p, t_acc, q1, q2)
        else:
            angle = self.along(state, mode, r, p, q1, q2)
        self.r, self.state = r, state
        s = angle - self.prev
        self.rate = (11 * s - 7 * self.s1 + 2 * self.s2) / (6 * self.tau)
        self.acceleration = (2 * s - 3 * self.s1 + self.s2) / self.tau**2
        self.s2, self.s1 = self.s1, s
        self.theta = self.prev = angle
        return True

    def along(
        self, state: str, mode: str, r: float, p: float, q1: float, q2: float | None
    ) -> float:
        """All states but START."""
        angle = q1
        if state == "IDLE":
            if not self.base:
                self.prev = q1
            elif self.rests_before_goal(q1):
                self.base = []
            self.theta_BC = 0.0
        else:
            if self.theta_BC != 0 and mode == "CARTESIAN":
                self.base, self.theta_BC = [], 0.0
            if mode == "JOINT":
                angle += r * self.theta_BC
            if state == "BLEND":
                Q0, Q1, Q2, Q3 = self.Q
                angle += (1 - p) ** 4 * (Q0 + Q1 * p + Q2 * p**2 + Q3 * p**3)
            if p > 0:
                self.since = 0
        self.since += 1
        self.base = [*self.base, q1][-128:]
        self.next = [] if q2 is None else [*self.next, q2][-128:]
        self.r_step = r - self.r
        return angle

    def rests_before_goal(self, q1: float) -> bool:
        """At IDLE with a base."""
        if self.state == "LINEAR":
            return self.r != 0
        goal = self.base[-1]
        if self.state == "IDLE" or abs(self.theta - goal) <= 1e-6:
            return False
        return abs(q1 - self.theta) < abs(q1 - goal)

    def hand_over(
        self, mode: str, blend: str, r: float, p: float, t_acc: float, B: float, C: float | None
    ) -> float:
        """START."""
        tau = self.tau
        n = round(t_acc / tau)
        w = 128 if n > 256 else min(max(n // 2, 10), 32)
        if blend == "THESIS":
            y0, y1, y2, y3 = self.prev + self.s1, self.s1 / tau, 0.0, 0.0
        elif not self.base:
            y0, y1, y2, y3 = self.theta, 0.0, 0.0, 0.0
        else:
            least = 1 if self.state == "IDLE" else 10
            y = fit(self.base, min(w, max(self.since, least)), 1)
            y0 = y[0] + (self.r + self.r_step) * self.theta_BC
            y1 = y[1] / tau + self.r_step * self.theta_BC / tau
            y2, y3 = y[2] / tau**2, y[3] / tau**3
        goal = B if mode == "CARTESIAN" or C is None else C
        self.next = [*self.next, goal][-128:]
        z = fit(self.next, w, 0)
        D0, D1 = y0 - B, y1 - z[1] / tau
        D2, D3 = y2 - z[2] / tau**2, y3 - z[3] / tau**3
        D3 = 0.0 if n > 1400 else D3
        D2 = 0.0 if n > 2800 else D2
        t = 2 * t_acc * p
        D0, D1, D2 = (
            D0 - t * (D1 - t * (D2 / 2 - t * D3 / 6)),
            D1 - t * (D2 - t * D3 / 2),
            D2 - t * D3,
        )
        T = 2 * t_acc
        A0, A1, A2, A3 = D0, T * D1, T**2 * D2 / 2, T**3 * D3 / 6
        self.Q = (A0, A1 + 4 * A0, A2 + 4 * A1 + 10 * A0, A3 + 4 * A2 + 10 * A1 + 20 * A0)
        self.theta_BC = B - goal if mode == "JOINT" else 0.0
        angle = goal + r * self.theta_BC if mode == "JOINT" and p >= 1 else y0
        self.base, self.next = self.next, self.base
        self.r_step = 0.0
        return angle

    def miss(self) -> None:
        """A cycle without a set-point."""
        self.base, self.next = (
            [*h, fit(h, 10, 1)[0]][-128:] if h else [] for h in (self.base, self.next)
        )
        self.since += 1
        self.r += self.r_step
        s = 2 * self.s1 - self.s2
        self.prev += s
        self.s2, self.s1 = self.s1, s


# --- docs/node-law.md ---------------------------------------------------------------------------


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
        """Torque without the bias; ``c`` has e, v, a, R, M, G, law, mu, selection, specification."""
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
        return clamp(X + self.integrate_rigid(e, X), self.p["TORQUE_LIMIT"])

    def codes(self, torque: float, B: float) -> tuple[int, int]:
        """current_dac and force_dac."""
        current = round(torque / self.p["TORQUE_PER_CODE"])
        force = round(B / self.p["TORQUE_PER_FORCE_CODE"]) if B else 0
        return max(-2048, min(2047, current)), max(-2048, min(2047, force))


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

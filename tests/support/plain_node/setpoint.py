"""docs/node-setpoint.md: the set-point of one joint."""

import numpy as np


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
    c0, c1, c2, c3, *_ = [*(c / scale ** np.arange(g + 1)), 0.0, 0.0, 0.0, 0.0]
    return [newest + c0, c1, 2 * c2, 6 * c3]


class PlainSetpoint:
    """The set-point of one joint; states as their names."""

    def __init__(self, tau: float, theta: float) -> None:
        self.tau = tau
        self.theta = self.prev = theta
        self.s1 = self.s2 = self.theta_BC = self.r = self.r_step = 0.0
        self.rate = self.acceleration = 0.0
        self.since = self.entered = 0
        self.Q = (0.0, 0.0, 0.0, 0.0)
        self.base: list[float] = []
        self.next: list[float] = []
        self.state = "IDLE"

    def may_follow(self, state: str, mode: str, p: float) -> bool:
        """The table of successions."""
        if state == "LINEAR" and self.state == "IDLE":
            return mode == "CARTESIAN" and p > 0
        return (
            self.state
            in {
                "IDLE": ("IDLE", "LINEAR", "BLEND"),
                "LINEAR": ("LINEAR", "PRE", "START", "BLEND"),
                "PRE": ("LINEAR", "PRE", "BLEND"),
                "START": ("IDLE", "LINEAR", "PRE"),
                "BLEND": ("START", "BLEND"),
            }[state]
        )

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
        if not self.may_follow(state, mode, p) or (
            state == "START" and mode == "JOINT" and q2 is None
        ):
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
            wanted = 128 if n >= 512 else min(n // 6, 32)
            least = 1 if self.state == "IDLE" else max(10, min(wanted, self.entered // 4))
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
        self.entered = n
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

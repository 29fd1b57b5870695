"""The joint's set-point from the master's (docs/node-setpoint.md)."""

from third_node.codec import Fields
from third_node.fit import fit, remember

IDLE, LINEAR, PRE, START, BLEND = range(5)
JOINT, CARTESIAN = 0, 1
THESIS, CONTINUOUS = 0, 1

FOLLOWS = {
    IDLE: (IDLE, LINEAR, BLEND),
    LINEAR: (LINEAR, PRE, START, BLEND),
    PRE: (LINEAR, PRE, BLEND),
    START: (IDLE, LINEAR, PRE),
    BLEND: (START, BLEND),
}


class SetPoint:
    """The memory of one joint, as the NMT command START leaves it: at rest where it is, rad."""

    def __init__(self, tau: float, measured: float) -> None:
        self.tau = tau
        self.theta = measured
        self.prev = measured
        self.s1 = self.s2 = 0.0
        self.rate = self.acceleration = 0.0
        self.base: list[float] = []
        self.next: list[float] = []
        self.theta_bc = 0.0
        self.r = self.r_step = 0.0
        self.since = 0
        self.entered = 0
        self.match = [0.0] * 4
        self.state = IDLE

    # --- before a cycle

    def may_follow(self, state: int, mode: int, p: float, has_second: bool) -> bool:
        """Whether a state may follow the last one."""
        if state == START and mode == JOINT and not has_second:
            return False
        if state == LINEAR and self.state == IDLE:
            return mode == CARTESIAN and p > 0
        return self.state in FOLLOWS[state]

    def previous_of_q1(self, state: int, mode: int) -> float:
        """The angle to which the turn of q1 is chosen, rad."""
        leaves = self.theta_bc != 0 and mode == CARTESIAN and state != START
        if state == IDLE or not self.base or leaves:
            return self.theta
        return self.base[-1]

    def previous_of_q2(self) -> float:
        """The same of q2."""
        for history in (self.next, self.base):
            if history:
                return history[-1]
        return self.theta

    # --- a cycle

    def step(self, told: Fields, q1: float, q2: float | None) -> None:
        """A cycle's SETPOINT_1 and its solutions, rad; q2 is None without a second pose."""
        state, r = told["state"], told["r"]
        if state == START:
            angle = self.hand_over(told, q1, q2)
        else:
            angle = self.go_on(told, q1)
            self.since += 1
            remember(self.base, q1)
            if q2 is None:
                self.next = []
            else:
                remember(self.next, q2)
            self.r_step = r - self.r
        self.r = r
        self.state = state
        self.differentiate(angle)
        self.theta = self.prev = angle

    def go_on(self, told: Fields, q1: float) -> float:
        """All states but START: the angle of this cycle."""
        state, mode, r, p = told["state"], told["mode"], told["r"], told["blend_p"]
        if state == IDLE:
            self.rest(q1)
            self.theta_bc = 0.0
            return q1
        if self.theta_bc != 0 and mode == CARTESIAN:
            self.base = []
            self.theta_bc = 0.0
        angle = q1
        if mode == JOINT:
            angle = angle + r * self.theta_bc
        if state == BLEND:
            angle = angle + self.matching(p)
        if p > 0:
            self.since = 0
        return angle

    def matching(self, p: float) -> float:
        """The matching polynomial."""
        q = self.match
        return float((1 - p) ** 4 * (q[0] + q[1] * p + q[2] * p * p + q[3] * p**3))

    def rest(self, q1: float) -> None:
        """IDLE."""
        if not self.base:
            self.prev = q1
        elif self.rests_before_goal(q1):
            self.base = []

    def rests_before_goal(self, q1: float) -> bool:
        """Whether the arm rests before the goal of its base."""
        if self.state == LINEAR:
            return self.r != 0
        if self.state == IDLE or abs(self.theta - self.base[-1]) <= 1e-6:
            return False
        return abs(q1 - self.theta) < abs(q1 - self.base[-1])

    def differentiate(self, angle: float) -> None:
        """Rate and acceleration of a cubic through the last four set-points."""
        s, s1, s2, tau = angle - self.prev, self.s1, self.s2, self.tau
        self.rate = (11 * s - 7 * s1 + 2 * s2) / (6 * tau)
        self.acceleration = (2 * s - 3 * s1 + s2) / tau**2
        self.s2, self.s1 = s1, s

    # --- START

    def hand_over(self, told: Fields, q1: float, q2: float | None) -> float:
        """The angle at START; the transition's matching polynomial."""
        tau, r, p, t_acc = self.tau, told["r"], told["blend_p"], told["acceleration_time"]
        in_joints = told["mode"] == JOINT
        goal = q2 if in_joints else q1  # C, or B
        assert goal is not None, "a joint segment without a second pose was refused before"
        n = round(t_acc / tau)
        w = 128 if n > 256 else min(max(n // 2, 10), 32)
        y = self.old_motion(told["blend"], n, w)
        remember(self.next, goal)
        z = fit(self.next, w, False, tau)
        diff = [y[0] - q1, y[1] - z[1], y[2] - z[2], y[3] - z[3]]
        if n > 1400:
            diff[3] = 0.0
        if n > 2800:
            diff[2] = 0.0
        self.match = polynomial(taken_back(diff, 2 * t_acc * p), 2 * t_acc)
        self.theta_bc = q1 - goal if in_joints else 0.0
        angle = y[0]
        if in_joints and p >= 1:
            angle = goal + r * self.theta_bc
        self.base, self.next = self.next, self.base
        self.r_step = 0.0
        self.entered = n
        return angle

    def old_motion(self, blend: int, n: int, w: int) -> list[float]:
        """Value, rate, acceleration, jerk of the motion that ends."""
        tau = self.tau
        if blend == THESIS:
            return [self.prev + self.s1, self.s1 / tau, 0.0, 0.0]
        if not self.base:
            return [self.theta, 0.0, 0.0, 0.0]
        if self.state == IDLE:
            least = 1
        else:
            longest = 128 if n >= 512 else min(n // 6, 32)
            least = max(10, min(longest, self.entered // 4))
        v = min(w, max(self.since, least))
        y = fit(self.base, v, True, tau)
        y[0] += (self.r + self.r_step) * self.theta_bc
        y[1] += self.r_step * self.theta_bc / tau
        return y

    # --- a cycle without a set-point

    def hold(self) -> None:
        """The set-point stays, the histories go on."""
        for history in (self.base, self.next):
            if history:
                remember(history, fit(history, 10, True, self.tau)[0])
        self.since += 1
        self.r += self.r_step
        s = 2 * self.s1 - self.s2
        self.prev += s
        self.s2, self.s1 = self.s1, s


def taken_back(diff: list[float], t: float) -> list[float]:
    """The difference at p = 0, where START came t later, s."""
    d0, d1, d2, d3 = diff
    return [
        d0 - t * (d1 - t * (d2 / 2 - t * d3 / 6)),
        d1 - t * (d2 - t * d3 / 2),
        d2 - t * d3,
        d3,
    ]


def polynomial(diff: list[float], t: float) -> list[float]:
    """Q0 to Q3 for a transition of t, s."""
    a0, a1 = diff[0], t * diff[1]
    a2, a3 = t**2 * diff[2] / 2, t**3 * diff[3] / 6
    return [a0, a1 + 4 * a0, a2 + 4 * a1 + 10 * a0, a3 + 4 * a2 + 10 * a1 + 20 * a0]

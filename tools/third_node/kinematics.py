"""The angle of one joint from a pose (docs/node-kinematics.md). None is "no solution"."""

import math
from collections.abc import Sequence

from third_node.configuration import Geometry

REACH = 1e-6  # e, tolerance of the reach, m
STRAIGHT = 1e-5  # h below which the wrist is straight
LIMIT_MARGIN = 1e-5  # of the range, rad

Vector = Sequence[float]


def dot(u: Vector, v: Vector) -> float:
    """u . v."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def orthonormal(o: Vector, a: Vector) -> tuple[list[float], list[float]] | None:
    """o and a, or None where they make no pose."""
    aa, oo, oa = dot(a, a), dot(o, o), dot(o, a)
    if not (abs(aa - 1) < 1e-5 and abs(oo - 1) < 1e-5 and abs(oa) < 1e-5):
        return None
    length = math.sqrt(aa)
    a = [x / length for x in a]
    o = [x - oa / length * y for x, y in zip(o, a, strict=True)]
    length = math.sqrt(dot(o, o))
    return [x / length for x in o], a


class Held:
    """Cosine and sine of theta4 for a straight wrist."""

    def __init__(self) -> None:
        self.set_angle(0.0)

    def set_angle(self, angle: float) -> None:
        """Hold an angle, rad."""
        self.c4, self.s4 = math.cos(angle), math.sin(angle)


class Arm:
    """The lines of the arm: C1, S1, V114, rho2, K, M; None where it does not reach."""

    def __init__(self, g: Geometry, p: Vector, code: int) -> None:
        px, py, self.pz = p
        self.g = g
        self.l2 = g.a3 * g.a3 + g.d4 * g.d4
        self.l = math.sqrt(self.l2)
        q = px * px + py * py
        self.in_shoulder = q < max(abs(g.d) - REACH, 1e-6) ** 2
        if self.in_shoulder:
            return
        v114 = math.sqrt(max(q - g.d * g.d, 0.0))
        self.v114 = -v114 if code & 1 else v114
        s = 1 / math.sqrt(q * (self.v114 * self.v114 + g.d * g.d))
        self.c1 = (self.v114 * px - g.d * py) * s
        self.s1 = (self.v114 * py + g.d * px) * s
        self.bend(code)

    def bend(self, code: int) -> None:
        """The elbow."""
        a2, l = self.g.a2, self.l  # noqa: E741 (L of the page)
        rho2 = self.rho2 = self.v114 * self.v114 + self.pz * self.pz
        near, far = max(abs(a2 - l) - REACH, 1e-6) ** 2, (a2 + l + REACH) ** 2
        self.out_of_reach = rho2 < near or rho2 > far
        self.k = rho2 + (a2 - l) * (a2 + l)
        m = math.sqrt(max(((a2 + l) ** 2 - rho2) * (rho2 - (a2 - l) ** 2), 0.0))
        self.m = -m if code & 2 else m

    def theta1(self) -> float:
        """Joint 1, rad."""
        return math.atan2(self.s1, self.c1)

    def theta2(self) -> float:
        """Joint 2, rad."""
        k, m, pz, v114 = self.k, self.m, self.pz, self.v114
        return math.atan2(k * pz - m * v114, k * v114 + m * pz)

    def theta3(self) -> float:
        """Joint 3, rad."""
        phi = math.atan2(self.g.d4, self.g.a3)
        return math.atan2(self.m, self.rho2 - (self.g.a2 * self.g.a2 + self.l2)) - phi

    def forearm(self) -> tuple[float, float]:
        """Cosine and sine of theta2 + theta3."""
        g, k, m, pz, v114 = self.g, self.k, self.m, self.pz, self.v114
        x = v114 - (k * v114 + m * pz) / (2 * self.rho2)
        y = pz - (k * pz - m * v114) / (2 * self.rho2)
        return (x * g.a3 + y * g.d4) / self.l2, (y * g.a3 - x * g.d4) / self.l2


def solve(
    joint: int, geometry: Geometry, o: Vector, a: Vector, p: Vector, code: int, held: Held
) -> float | None:
    """The angle of the joint, rad, up to whole turns; ``held`` may change."""
    pose = orthonormal(o, a)
    if pose is None:
        return None
    arm = Arm(geometry, p, code)
    if arm.in_shoulder:
        return None
    if joint == 1:
        return arm.theta1()
    if arm.out_of_reach:
        return None
    if joint in (2, 3):
        return arm.theta2() if joint == 2 else arm.theta3()
    return wrist(joint, arm, *pose, code, held)


def wrist(joint: int, arm: Arm, o: Vector, a: Vector, code: int, held: Held) -> float:
    """The angle of joint 4, 5 or 6, rad."""
    (ox, oy, oz), (ax, ay, az) = o, a
    c1, s1 = arm.c1, arm.s1
    c23, s23 = arm.forearm()
    v113 = c1 * ax + s1 * ay
    v313 = c23 * v113 + s23 * az
    v323 = c1 * ay - s1 * ax
    c5 = c23 * az - s23 * v113
    h = math.sqrt(v313 * v313 + v323 * v323)
    if h >= STRAIGHT:
        sign = 1 if code & 4 else -1
        held.c4, held.s4 = sign * v313 / h, sign * v323 / h
    c4, s4 = held.c4, held.s4
    if joint == 4:
        return math.atan2(s4, c4)
    s5 = -c4 * v313 - s4 * v323
    if joint == 5:
        return math.atan2(s5, c5)
    v112 = c1 * ox + s1 * oy
    v132 = s1 * ox - c1 * oy
    v312 = c23 * v112 + s23 * oz
    v332 = c23 * oz - s23 * v112
    s6 = c5 * (s4 * v132 - c4 * v312) - s5 * v332
    c6 = -s4 * v312 - c4 * v132
    return math.atan2(s6, c6)


def nearest_turn(angle: float, previous: float, lower: float, upper: float) -> float | None:
    """The turn of an angle that is nearest to ``previous`` and in the range; rad."""
    low, high = lower - LIMIT_MARGIN, upper + LIMIT_MARGIN
    b = angle - previous
    if -math.pi <= b <= math.pi and low <= angle <= high:
        return angle
    if not math.isfinite(b):
        return None
    turn = 2 * math.pi
    angle = angle - turn * round(b / turn)
    if angle > high:
        angle = angle - turn * math.ceil((angle - high) / turn)
    if angle < low:
        angle = angle + turn * math.ceil((low - angle) / turn)
    return angle if low <= angle <= high else None


def told(angle: float, lower: float, upper: float) -> float | None:
    """An angle of JOINT_SETPOINT, rad: as it is, if it is in the range."""
    return angle if lower - LIMIT_MARGIN <= angle <= upper + LIMIT_MARGIN else None

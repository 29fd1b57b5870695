"""The closed-form inverse solution, one quantity at a time (A.37 to A.64, with a3).

Each joint follows from what the joints before it gave, as in Appendix A, but from ratios instead
of angles: sine and cosine of theta1 and theta23 come out of the arm's triangle by square roots, so
a solution costs one atan2 a joint and no other trigonometry, and loses no digits near the
border of the reach where asin and acos do.

In the arm's plane let P = (V114, pz) be the wrist centre, rho its length and L = hypot(a3, d4) the
forearm. The triangle of a2, L and rho gives (times 2 a2 rho)

    cos psi: K = rho^2 + a2^2 - L^2        sin psi: M = sqrt(((a2+L)^2 - rho^2)(rho^2 - (a2-L)^2))

M takes the elbow's sign, up positive; theta2 = atan2(pz, V114) - psi.

Nothing here raises: a pose out of reach, or not finite, yields NaN, and NaN runs through to every
angle that depends on it.
"""

import math
from typing import Final, NamedTuple

from rfms_can.kinematics.geometry import Geometry
from rfms_can.transform import Transform

SHOULDER_POINT_BOUND: Final = 1e-6
"""Distance of wrist centre and shoulder, m, below which theta2 is undefined."""

WRIST_BOUND: Final = 1e-5
"""|S5| below which theta4 is open: sixty times the float32 noise of set-points in S5."""

EXACT_WRIST_BOUND: Final = 1e-7
"""The same along a path in double precision: rounding moves theta4 by 3e-9 rad there."""

CosSin = tuple[float, float]
"""Cosine and sine of an angle, passed from one joint's solution to the next."""


class Tolerance(NamedTuple):
    """Tolerance for rounding of a pose on a boundary of the workspace.

    Attributes:
        reach: metres, on distances from joint-1 axis and shoulder.
        angle: radians, on joint ranges.
    """

    reach: float
    angle: float


EXACT: Final = Tolerance(reach=1e-9, angle=1e-9)
"""For poses in double precision: the master's own."""

WIRE: Final = Tolerance(reach=1e-6, angle=1e-5)
"""For set-points sent as float32: every node accepts what the master accepts."""


class ClosedForm:
    """Appendix A for one arm: its constants computed once, its quantities as methods.

    ``tolerance`` (metres) allows for rounding of the pose's distance. T6 is passed whole and
    unpacked where it is used.
    """

    __slots__ = (
        "a3",
        "cylinder_squared",
        "d4",
        "farthest_squared",
        "forearm_angle",
        "forearm_squared",
        "k_offset",
        "nearest_squared",
        "offset",
        "offset_squared",
        "rho_max_squared",
        "rho_min_squared",
        "triangle_offset",
    )

    def __init__(self, arm: Geometry, tolerance: float) -> None:
        a2, self.a3, self.d4 = arm.a2, arm.a3, arm.d4
        forearm = math.hypot(self.a3, self.d4)
        self.forearm_squared = forearm * forearm
        self.forearm_angle = math.atan2(self.d4, self.a3)
        self.offset = arm.shoulder_offset
        self.offset_squared = self.offset * self.offset
        self.k_offset = (a2 - forearm) * (a2 + forearm)
        self.triangle_offset = a2 * a2 + self.forearm_squared
        self.farthest_squared = (a2 + forearm) ** 2
        self.nearest_squared = (a2 - forearm) ** 2
        self.cylinder_squared = max(abs(self.offset) - tolerance, SHOULDER_POINT_BOUND) ** 2
        self.rho_max_squared = (a2 + forearm + tolerance) ** 2
        self.rho_min_squared = max(abs(a2 - forearm) - tolerance, SHOULDER_POINT_BOUND) ** 2

    def v114(self, t6: Transform, left: bool) -> float:
        """V114 of (A.43), metres: the wrist centre's distance from the joint-1 axis, signed."""
        px, py = t6[3], t6[7]
        squared = px * px + py * py
        if not squared >= self.cylinder_squared:
            return math.nan
        squared -= self.offset_squared
        v114 = math.sqrt(squared) if squared > 0.0 else 0.0
        return v114 if left else -v114

    def waist(self, t6: Transform, v114: float) -> CosSin:
        """C1 and S1 (A.41) without asin: theta1 turns (V114, -d) into (px, py)."""
        px, py, d = t6[3], t6[7], self.offset
        scale = 1.0 / math.sqrt((px * px + py * py) * (v114 * v114 + d * d))
        return (v114 * px - d * py) * scale, (v114 * py + d * px) * scale

    def triangle(self, v114: float, pz: float, up: bool) -> tuple[float, float, float]:
        """rho^2, K and signed M of the arm's triangle, square metres."""
        rho2 = v114 * v114 + pz * pz
        if not self.rho_min_squared <= rho2 <= self.rho_max_squared:
            return math.nan, math.nan, math.nan
        m2 = (self.farthest_squared - rho2) * (rho2 - self.nearest_squared)
        m = math.sqrt(m2) if m2 > 0.0 else 0.0
        return rho2, rho2 + self.k_offset, m if up else -m

    def theta2(self, v114: float, pz: float, k: float, m: float) -> float:
        """(A.48): P turned back by psi."""
        return math.atan2(k * pz - m * v114, k * v114 + m * pz)

    def theta3(self, rho2: float, m: float) -> float:
        """(A.52) from the law of cosines at the elbow, less the forearm's own angle."""
        return math.atan2(m, rho2 - self.triangle_offset) - self.forearm_angle

    def forearm(self, v114: float, pz: float, rho2: float, k: float, m: float) -> CosSin:
        """C23 and S23 (A.44): the forearm runs from the elbow to P."""
        scale = 0.5 / rho2
        x = v114 - (k * v114 + m * pz) * scale
        y = pz - (k * pz - m * v114) * scale
        a3, d4, scale = self.a3, self.d4, 1.0 / self.forearm_squared
        return (x * a3 + y * d4) * scale, (y * a3 - x * d4) * scale

    @staticmethod
    def approach(t6: Transform, waist: CosSin, forearm: CosSin) -> tuple[float, float, float]:
        """V313, V323 and C5 (A.57, A.59): the approach vector a, seen from the forearm."""
        ax, ay, az = t6[2], t6[6], t6[10]
        c1, s1 = waist
        c23, s23 = forearm
        v113 = c1 * ax + s1 * ay
        return c23 * v113 + s23 * az, c1 * ay - s1 * ax, c23 * az - s23 * v113

    @staticmethod
    def roll(
        v313: float, v323: float, noflip: bool, held: CosSin, bound: float = WRIST_BOUND
    ) -> CosSin:
        """C4 and S4 (A.55); ``held`` where |S5| is below ``bound``: theta4 is undefined."""
        s5 = math.hypot(v313, v323)
        if s5 < bound:
            return held
        scale = -1.0 / s5 if noflip else 1.0 / s5
        return v313 * scale, v323 * scale

    @staticmethod
    def theta6(t6: Transform, waist: CosSin, forearm: CosSin, roll: CosSin, bend: CosSin) -> float:
        """(A.62, A.63): the orientation vector o, seen from the wrist; ``bend`` is C5 and S5."""
        ox, oy, oz = t6[1], t6[5], t6[9]
        c1, s1 = waist
        c23, s23 = forearm
        c4, s4 = roll
        c5, s5 = bend
        v112, v132 = c1 * ox + s1 * oy, s1 * ox - c1 * oy
        v312, v332 = c23 * v112 + s23 * oz, c23 * oz - s23 * v112
        s6 = c5 * (s4 * v132 - c4 * v312) - s5 * v332
        return math.atan2(s6, -s4 * v312 - c4 * v132)

"""Homogeneous transforms (thesis section II.2): twelve plain floats, because six joints compose
only a few of them a cycle, and the overhead of an array exceeds the multiplication."""

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

from rfms_can.errors import KinematicsError

_new = tuple.__new__
"""The base constructor of ``NamedTuple``: half its cost on the per-cycle path."""

Vector3 = tuple[float, float, float]

RIGID_TOLERANCE: Final = 1e-6
"""Largest ``rigidity_error`` of a user's pose; six printed digits are sufficient."""

WIRE_ROTATION_TOLERANCE: Final = 1e-5
"""Largest deviation of o and a from orthonormal on the wire: a hundred times float32's rounding."""

MAX_CORRECTION: Final = 0.05
"""Largest change of an element that still corrects rounding; two printed digits need a tenth."""

_NEWTON_STEPS: Final = 8
"""Steps of a quadratically convergent iteration that starts within ``MAX_CORRECTION``."""

_NAN: Final = math.nan


class Transform(NamedTuple):
    """The pose of one frame in another, [n o a p] of (2.1), without the last row.

    Immutable; the twelve elements are in row order, so that ``==`` compares values and a transform
    unpacks like a tuple. Rotation elements have no unit, px, py, pz are metres.
    """

    nx: float
    ox: float
    ax: float
    px: float
    ny: float
    oy: float
    ay: float
    py: float
    nz: float
    oz: float
    az: float
    pz: float

    @staticmethod
    def identity() -> "Transform":
        """The identity."""
        return _IDENTITY

    @staticmethod
    def translation(x: float, y: float, z: float) -> "Transform":
        """Trans(x, y, z), metres."""
        return Transform(1.0, 0.0, 0.0, x, 0.0, 1.0, 0.0, y, 0.0, 0.0, 1.0, z)

    @staticmethod
    def rotation(axis: Sequence[float], angle: float) -> "Transform":
        """Rot(axis, angle): ``angle`` radians about ``axis`` (any length but zero).

        Raises:
            KinematicsError: the axis has no direction, or the angle is not finite.
        """
        if len(axis) != 3:
            raise KinematicsError(f"rotation axis {axis!r}: give three numbers, e.g. (0, 0, 1)")
        x, y, z = axis
        length = math.sqrt(x * x + y * y + z * z)
        if not 0.0 < length < math.inf:
            raise KinematicsError(
                f"rotation axis ({x}, {y}, {z}) has no direction: "
                f"give a finite vector other than zero"
            )
        if not math.isfinite(angle):
            raise KinematicsError(
                f"rotation angle {angle} about ({x}, {y}, {z}) is not finite: give radians"
            )
        x, y, z = x / length, y / length, z / length
        s, c = math.sin(angle), math.cos(angle)
        v = 1.0 - c
        # fmt: off
        return Transform(
            x * x * v + c,     x * y * v - z * s, x * z * v + y * s, 0.0,
            x * y * v + z * s, y * y * v + c,     y * z * v - x * s, 0.0,
            x * z * v - y * s, y * z * v + x * s, z * z * v + c,     0.0,
        )
        # fmt: on

    @staticmethod
    def rpy(phi: float, theta: float, psi: float) -> "Transform":
        """Paul's RPY: Rot(z, phi) Rot(y, theta) Rot(x, psi), radians."""
        return _ROT_Z(phi) @ _ROT_Y(theta) @ _ROT_X(psi)

    @staticmethod
    def euler(phi: float, theta: float, psi: float) -> "Transform":
        """Paul's Euler angles: Rot(z, phi) Rot(y, theta) Rot(z, psi), radians."""
        return _ROT_Z(phi) @ _ROT_Y(theta) @ _ROT_Z(psi)

    @staticmethod
    def from_rows(rows: Sequence[Sequence[float]]) -> "Transform":
        """The transform whose first three rows, four numbers each, are ``rows``.

        Raises:
            KinematicsError: not three rows of four.
        """
        if [len(row) for row in rows] != [4, 4, 4]:
            raise KinematicsError(
                f"a transform is 3 rows of 4 numbers [n o a p], not {[len(r) for r in rows]}"
            )
        return Transform(*(float(element) for row in rows for element in row))

    @staticmethod
    def nearest_rotation(rows: "Sequence[Sequence[float]] | Transform") -> "NearestRotation":
        """The transform whose rotation is nearest to a matrix of rounded or measured numbers.

        Nearest in the sum of squares of the elements: the orthogonal factor of the polar
        decomposition (Higham, SIAM J. Sci. Stat. Comput. 7, 1986), which prefers no axis.

        Args:
            rows: three rows [n o a] or [n o a p], a 4 x 4 matrix, or a transform that is not rigid;
                p, m, is kept.

        Returns:
            The transform, and the largest change of an element of n, o, a.

        Raises:
            KinematicsError: not such rows; left-handed; or more than ``MAX_CORRECTION`` from any
                rotation, so that more is wrong than rounding.
        """
        n, o, a, p = _columns(rows.rows() if isinstance(rows, Transform) else rows)
        given = (*n, *o, *a)
        determinant = _dot(n, _cross(o, a))
        if determinant < 0.0:
            raise KinematicsError(
                f"n, o, a have the determinant {determinant:.3g}: left-handed axes; change the "
                f"sign of one, or exchange two"
            )
        for _ in range(_NEWTON_STEPS):
            if not determinant:
                break
            half = 0.5 / determinant
            n, o, a = (
                _halves(n, half, _cross(o, a)),
                _halves(o, half, _cross(a, n)),
                _halves(a, half, _cross(n, o)),
            )
            determinant = _dot(n, _cross(o, a))
        correction = max(abs(x - y) for x, y in zip((*n, *o, *a), given, strict=True))
        if not (determinant and correction <= MAX_CORRECTION):  # also NaN
            raise KinematicsError(
                f"no rotation is within {MAX_CORRECTION:g} of n = {given[:3]}, o = {given[3:6]}, "
                f"a = {given[6:]}: see whether rows and columns are exchanged, or one is scaled"
            )
        found = Transform(*(element for row in zip(n, o, a, p, strict=True) for element in row))
        return NearestRotation(found, correction)

    @staticmethod
    def from_o_a_p(o: Sequence[float], a: Sequence[float], p: Sequence[float]) -> "Transform":
        """The pose of a SETPOINT frame: n = o x a, with o and a orthonormalised.

        float32 leaves an error of about 1e-7 in o and a. Beyond ``WIRE_ROTATION_TOLERANCE`` they
        do not define a rotation, and all elements are NaN: on the nodes' path an unusable set-point
        gives NaN and never raises.
        """
        ox, oy, oz = o
        ax, ay, az = a
        aa = ax * ax + ay * ay + az * az
        oo = ox * ox + oy * oy + oz * oz
        oa = ox * ax + oy * ay + oz * az
        off = WIRE_ROTATION_TOLERANCE
        if not (-off < aa - 1.0 < off and -off < oo - 1.0 < off and -off < oa < off):
            return _NO_ROTATION
        k = 1.0 / math.sqrt(aa)
        ax, ay, az = ax * k, ay * k, az * k
        k *= oa
        ox, oy, oz = ox - k * ax, oy - k * ay, oz - k * az
        k = 1.0 / math.sqrt(ox * ox + oy * oy + oz * oz)
        ox, oy, oz = ox * k, oy * k, oz * k
        nx, ny, nz = oy * az - oz * ay, oz * ax - ox * az, ox * ay - oy * ax
        px, py, pz = p
        return _new(Transform, (nx, ox, ax, px, ny, oy, ay, py, nz, oz, az, pz))

    def __matmul__(self, other: "Transform") -> "Transform":
        """Composition (2.2): ``self`` places A, ``other`` places B in A; the product places B."""
        if not isinstance(other, Transform):
            return NotImplemented
        a, b, c, x, d, e, f, y, g, h, i, z = self
        nx, ox, ax, px, ny, oy, ay, py, nz, oz, az, pz = other
        return _new(
            Transform,
            (
                a * nx + b * ny + c * nz,
                a * ox + b * oy + c * oz,
                a * ax + b * ay + c * az,
                a * px + b * py + c * pz + x,
                d * nx + e * ny + f * nz,
                d * ox + e * oy + f * oz,
                d * ax + e * ay + f * az,
                d * px + e * py + f * pz + y,
                g * nx + h * ny + i * nz,
                g * ox + h * oy + i * oz,
                g * ax + h * ay + i * az,
                g * px + h * py + i * pz + z,
            ),
        )

    def inverse(self) -> "Transform":
        """The inverse (2.3); exact for rigid transforms only."""
        nx, ox, ax, px, ny, oy, ay, py, nz, oz, az, pz = self
        return _new(
            Transform,
            (
                *(nx, ny, nz, -(px * nx + py * ny + pz * nz)),
                *(ox, oy, oz, -(px * ox + py * oy + pz * oz)),
                *(ax, ay, az, -(px * ax + py * ay + pz * az)),
            ),
        )

    def apply(self, point: Sequence[float]) -> Vector3:
        """A point of the inner frame, metres, in the outer frame."""
        x, y, z = point
        return (
            self.nx * x + self.ox * y + self.ax * z + self.px,
            self.ny * x + self.oy * y + self.ay * z + self.py,
            self.nz * x + self.oz * y + self.az * z + self.pz,
        )

    def rows(self) -> list[list[float]]:
        """Three rows [n o a p] of four, for JSON."""
        return [list(self[0:4]), list(self[4:8]), list(self[8:12])]

    def rigidity_error(self) -> float:
        """Largest deviation of n, o, a from a right-handed orthonormal set; inf if not finite."""
        nx, ox, ax, _, ny, oy, ay, _, nz, oz, az, _ = self
        if not math.isfinite(sum(self)):
            return math.inf
        return max(
            abs(ox * ox + oy * oy + oz * oz - 1.0),
            abs(ax * ax + ay * ay + az * az - 1.0),
            abs(ox * ax + oy * ay + oz * az),
            abs(oy * az - oz * ay - nx),
            abs(oz * ax - ox * az - ny),
            abs(ox * ay - oy * ax - nz),
        )

    def is_rigid(self, tolerance: float = RIGID_TOLERANCE) -> bool:
        """Whether this is a rotation and a translation only."""
        return self.rigidity_error() <= tolerance


class NearestRotation(NamedTuple):
    """What ``Transform.nearest_rotation`` found.

    Attributes:
        transform: rigid, to rounding.
        correction: largest change of an element of n, o, a.
    """

    transform: Transform
    correction: float


def _columns(rows: Sequence[Sequence[float]]) -> tuple[Vector3, Vector3, Vector3, Vector3]:
    """n, o, a and p of three or four rows.

    Raises:
        KinematicsError: not 3 x 3, 3 x 4 or 4 x 4 finite numbers, or not 0 0 0 1 in the last row.
    """
    sizes = [len(row) for row in rows]
    if sizes not in ([3] * 3, [4] * 3, [4] * 4):
        raise KinematicsError(f"a rotation is 3 rows [n o a] or [n o a p], not {sizes}")
    if len(rows) == 4 and [float(element) for element in rows[3]] != [0.0, 0.0, 0.0, 1.0]:
        raise KinematicsError(f"the last row of a transform is 0 0 0 1, not {list(rows[3])}")
    x, y, z = ([*map(float, row), 0.0][:4] for row in rows[:3])
    if not math.isfinite(sum((*x, *y, *z))):
        raise KinematicsError(f"rows {x}, {y}, {z} have an element that is not finite")
    n, o, a, p = zip(x, y, z, strict=True)
    return n, o, a, p


def _dot(a: Vector3, b: Vector3) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vector3, b: Vector3) -> Vector3:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def _halves(a: Vector3, factor: float, b: Vector3) -> Vector3:
    """a / 2 + factor b."""
    return (0.5 * a[0] + factor * b[0], 0.5 * a[1] + factor * b[1], 0.5 * a[2] + factor * b[2])


_IDENTITY: Final = Transform.translation(0.0, 0.0, 0.0)
_NO_ROTATION: Final = Transform(*(_NAN,) * 12)


def _ROT_X(angle: float) -> Transform:
    return Transform.rotation((1.0, 0.0, 0.0), angle)


def _ROT_Y(angle: float) -> Transform:
    return Transform.rotation((0.0, 1.0, 0.0), angle)


def _ROT_Z(angle: float) -> Transform:
    return Transform.rotation((0.0, 0.0, 1.0), angle)

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
            KinematicsError: the axis has no direction.
        """
        x, y, z = axis
        length = math.sqrt(x * x + y * y + z * z)
        if not 0.0 < length < math.inf:
            raise KinematicsError(
                f"rotation axis ({x}, {y}, {z}) has no direction: "
                f"give a finite vector other than zero"
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


_IDENTITY: Final = Transform.translation(0.0, 0.0, 0.0)
_NO_ROTATION: Final = Transform(*(_NAN,) * 12)


def _ROT_X(angle: float) -> Transform:
    return Transform.rotation((1.0, 0.0, 0.0), angle)


def _ROT_Y(angle: float) -> Transform:
    return Transform.rotation((0.0, 1.0, 0.0), angle)


def _ROT_Z(angle: float) -> Transform:
    return Transform.rotation((0.0, 0.0, 1.0), angle)

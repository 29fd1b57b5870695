"""The drive transform D(r) of straight-line motion (3.20 to 3.40, as corrected)."""

import math
from typing import Final, Self

from rfms_can.transform.homogeneous import Transform, Vector3

HALF_TURN_BOUND: Final = 1e-10
"""Distance from pi, radians, below which the sign of the axis is chosen by convention."""


class DriveTransform:
    """D(r): a rotation of r psi about a fixed axis and a translation of r p.

    D(1) places the start of a segment in its goal, D(0) is the identity; r = 1 - h runs from 1 to
    0. Straight-line motion is that of the origin of the frame D acts on.

    Attributes:
        psi: rotation angle, radians, 0 to pi. Keep it under 0.8 pi or split the motion: close to
            pi a small change of the goal reverses the rotation.
        axis: unit vector e of (3.24); z where psi is zero. At exactly pi both senses reach the
            goal; the one whose first non-zero component is positive is taken.
        p: translation, metres.
    """

    __slots__ = ("_ez", "_xx", "_xy", "_xz", "_yy", "_yz", "_zz", "axis", "p", "psi")

    def __init__(self, start: Transform) -> None:
        """Solve for psi, e and p from ``start`` = D(1), a rigid transform."""
        self.p: Final[Vector3] = (start.px, start.py, start.pz)
        self.psi, self.axis = _angle_and_axis(start)
        x, y, z = self.axis
        self._xx, self._xy, self._xz = x * x, x * y, x * z
        self._yy, self._yz, self._zz = y * y, y * z, z * z

    @classmethod
    def between(cls, left: Transform, start: Transform, right: Transform) -> Self:
        """The drive from ``start`` to the goal L R: D(1) = L^-1 B R^-1 (3.22)."""
        return cls(left.inverse() @ start @ right.inverse())

    @property
    def theta(self) -> float:
        """Second Euler angle of the axis (3.38), radians, 0 to pi inclusive."""
        x, y, z = self.axis
        return math.atan2(math.hypot(x, y), z)

    @property
    def phi(self) -> float:
        """First Euler angle of the axis (3.40), radians; 0 where the axis is along z."""
        return math.atan2(self.axis[1], self.axis[0])

    def at(self, r: float) -> Transform:
        """D(r) of (3.25); r = 1 at the segment's start, 0 at its goal."""
        angle = r * self.psi
        s, c = math.sin(angle), math.cos(angle)
        v = 1.0 - c
        x, y, z = self.axis
        xs, ys, zs = x * s, y * s, z * s
        xy, xz, yz = self._xy * v, self._xz * v, self._yz * v
        px, py, pz = self.p
        return tuple.__new__(
            Transform,
            (
                *(self._xx * v + c, xy - zs, xz + ys, r * px),
                *(xy + zs, self._yy * v + c, yz - xs, r * py),
                *(xz - ys, yz + xs, self._zz * v + c, r * pz),
            ),
        )


def motion_of(change: Transform) -> tuple[float, float, float, float, float, float]:
    """Displacement of a frame from the identity: translation, m, and rotation vector, rad (6)."""
    psi, (x, y, z) = _angle_and_axis(change)
    return (change.px, change.py, change.pz, psi * x, psi * y, psi * z)


def _angle_and_axis(start: Transform) -> tuple[float, Vector3]:
    """Psi (3.33) and the axis; beyond 120 degrees from the symmetric part, as sin psi vanishes."""
    x, y, z = start.oz - start.ay, start.ax - start.nz, start.ny - start.ox
    twice_sine = math.sqrt(x * x + y * y + z * z)
    twice_cosine = start.nx + start.oy + start.az - 1.0
    psi = math.atan2(twice_sine, twice_cosine)
    if twice_cosine < -1.0:
        axis = _axis_of_symmetric_part(start, 0.5 * twice_cosine)
        if math.pi - psi < HALF_TURN_BOUND:
            return math.pi, axis
        along = axis[0] * x + axis[1] * y + axis[2] * z
        return psi, axis if along > 0.0 else (-axis[0], -axis[1], -axis[2])
    if twice_sine == 0.0:
        return 0.0, (0.0, 0.0, 1.0)
    return psi, (x / twice_sine, y / twice_sine, z / twice_sine)


def _axis_of_symmetric_part(start: Transform, cosine: float) -> Vector3:
    """The axis, first non-zero component positive, from (R + R^T)/2 = c I + (1 - c) e e^T."""
    versine = 1.0 - cosine
    xy = (start.ox + start.ny) / 2.0
    xz = (start.ax + start.nz) / 2.0
    yz = (start.ay + start.oz) / 2.0
    columns = (
        (start.nx - cosine, xy, xz),
        (xy, start.oy - cosine, yz),
        (xz, yz, start.az - cosine),
    )
    largest = max(range(3), key=lambda k: columns[k][k])
    length = math.sqrt(versine * columns[largest][largest])
    x, y, z = (element / length for element in columns[largest])
    first = next(component for component in (x, y, z) if abs(component) > HALF_TURN_BOUND)
    return (x, y, z) if first > 0.0 else (-x, -y, -z)

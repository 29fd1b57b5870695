"""Paul's drive transform: a line and two rotations, one of the approach vector, one about it."""

import math
from typing import Final, NamedTuple, Self

from rfms_can.transform import Transform

NO_TURN: Final = 1e-9
"""Radians of theta under which its axis is rounding."""


class DoubleTurn(NamedTuple):
    """D of Paul (1979): Trans(x, y, z) Rot(k, theta) Rot(z, phi), k = (-sin psi, cos psi, 0).

    Metres and radians. Of D(h), x, y, z, theta and phi are h of their values, psi is constant.
    """

    x: float
    y: float
    z: float
    theta: float
    phi: float
    psi: float

    @classmethod
    def still(cls) -> Self:
        """No motion."""
        return cls(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    @classmethod
    def of(cls, place: Transform) -> Self:
        """The parameters of ``place`` = D(1): theta from 0 to pi, phi from -pi to pi."""
        theta = math.atan2(math.hypot(place.ax, place.ay), place.az)
        psi = math.atan2(place.ay, place.ax)
        first = _turn_of_approach(theta, psi)
        rest = first.inverse() @ place
        return cls(place.px, place.py, place.pz, theta, math.atan2(rest.ny, rest.nx), psi)

    @classmethod
    def in_one_sense(cls, ahead: Self, behind: Self) -> tuple[Self, Self]:
        """Both so that psi runs a quarter turn at most from one to the other.

        The axis at psi + pi is the same one with the other sign of theta. Without theta there is
        no axis: the other's is taken.
        """
        if behind.theta < NO_TURN:
            return ahead, behind._replace(psi=ahead.psi)
        if ahead.theta < NO_TURN:
            return ahead._replace(psi=behind.psi), behind
        apart = math.remainder(behind.psi - ahead.psi, math.tau)
        theta = behind.theta
        if abs(apart) > math.pi / 2.0:
            apart, theta = apart - math.copysign(math.pi, apart), -theta
        return ahead, behind._replace(psi=ahead.psi + apart, theta=theta)

    @property
    def even(self) -> tuple[float, float, float, float, float]:
        """What a motion changes evenly: all but psi."""
        return self[:5]

    def at(self, h: float) -> "DoubleTurn":
        """D(h)."""
        x, y, z, theta, phi, psi = self
        return DoubleTurn(h * x, h * y, h * z, h * theta, h * phi, psi)

    def transform(self) -> Transform:
        """As a homogeneous transform."""
        turned = _turn_of_approach(self.theta, self.psi) @ Transform.rotation(
            (0.0, 0.0, 1.0), self.phi
        )
        return turned._replace(px=self.x, py=self.y, pz=self.z)


def _turn_of_approach(theta: float, psi: float) -> Transform:
    return Transform.rotation((-math.sin(psi), math.cos(psi), 0.0), theta)

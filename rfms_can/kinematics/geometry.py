"""Geometry of an arm as the kinematics need it, and their types."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Protocol

from rfms_can.errors import KinematicsError

Joints = tuple[float, float, float, float, float, float]
"""theta1 to theta6, radians, convention B (alpha = +90, 0, -90, +90, -90, 0 degrees)."""

Limits = tuple[tuple[float, float], ...]
"""Six (lower, upper) pairs, radians."""


class Geometry(Protocol):
    """A six-joint arm with a spherical wrist, the structure of Appendix A with any lengths.

    Lengths are metres. a3 is zero in the thesis' PUMA 260; the formulas here include it.
    """

    @property
    def name(self) -> str:
        """The arm's name in errors."""

    @property
    def a2(self) -> float:
        """Length of the upper arm."""

    @property
    def a3(self) -> float:
        """Offset of the forearm at the elbow."""

    @property
    def d4(self) -> float:
        """Length of the forearm, elbow to wrist centre."""

    @property
    def shoulder_offset(self) -> float:
        """d2 + d3: distance of the forearm's plane from the joint-1 axis."""

    @property
    def joint_limits(self) -> Limits:
        """Range of each joint."""


class DhLink(Protocol):
    """One link of a chain, Denavit-Hartenberg: Rz(theta + offset) Tz(d) Tx(a) Rx(alpha)."""

    @property
    def a(self) -> float:
        """Length, m."""

    @property
    def d(self) -> float:
        """Offset along the joint's axis, m."""

    @property
    def alpha(self) -> float:
        """Twist, rad."""

    @property
    def offset(self) -> float:
        """Of the joint's zero, rad."""


TWISTS: Final = tuple(math.radians(angle) for angle in (90.0, 0.0, -90.0, 90.0, -90.0, 0.0))
"""alpha of the closed form, rad."""


@dataclass(frozen=True, slots=True)
class SphericalWrist:
    """An arm of the closed form, by its six links: what a node knows of the arm it is part of.

    Attributes:
        name: in errors.
        a2, a3, d4, shoulder_offset, joint_limits: see ``Geometry``.
    """

    name: str
    a2: float
    a3: float
    d4: float
    shoulder_offset: float
    joint_limits: Limits

    @classmethod
    def of(cls, links: Sequence[DhLink], joint_limits: Limits, name: str) -> "SphericalWrist":
        """The arm that six links make.

        Raises:
            KinematicsError: they have another structure than the closed form.
        """
        if tuple(link.alpha for link in links) != TWISTS or any(link.offset for link in links):
            raise KinematicsError(f"{name}: twists and offsets are not those of the closed form")
        first, upper, fore, wrist, *rest = links
        zero = (first.a, first.d, wrist.a, *(link.a for link in rest), *(x.d for x in rest))
        if any(zero) or not upper.a > 0.0 or not wrist.d > 0.0:
            raise KinematicsError(
                f"{name}: a1, d1, a4 to a6, d5 and d6 must be 0, a2 and d4 positive"
            )
        return cls(name, upper.a, fore.a, wrist.d, upper.d + fore.d, joint_limits)

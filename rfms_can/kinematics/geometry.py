"""Geometry of an arm as the kinematics need it, and their types."""

from typing import Protocol

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

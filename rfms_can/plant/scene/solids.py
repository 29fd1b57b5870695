"""Tools put together from solid parts along the hand's axis: their mass, centre and inertia."""

import math
from typing import Final, NamedTuple

from rfms_can.plant.scene.shape import Kind, Shape, Tool
from rfms_can.transform import Transform, Vector3

STEEL_DENSITY: Final = 7850.0
"""kg/m3."""


class Part(NamedTuple):
    """A solid part of steel on z of T6.

    Attributes:
        kind: BOX, CYLINDER or SPHERE.
        size: by ``kind``, m.
        middle: of it, on z of T6, m.
        solid: whether it can touch a fixture.
    """

    kind: Kind
    size: Vector3
    middle: float
    solid: bool = True

    @property
    def mass(self) -> float:
        """kg."""
        a, b, c = self.size
        if self.kind is Kind.BOX:
            return STEEL_DENSITY * 8.0 * a * b * c
        if self.kind is Kind.CYLINDER:
            return STEEL_DENSITY * math.pi * a**2 * 2.0 * b
        return STEEL_DENSITY * 4.0 / 3.0 * math.pi * a**3

    @property
    def inertia(self) -> Vector3:
        """About its middle, along x, y and z, kg m2."""
        a, b, c = self.size
        mass = self.mass
        if self.kind is Kind.BOX:
            third = mass / 3.0
            return third * (b**2 + c**2), third * (a**2 + c**2), third * (a**2 + b**2)
        if self.kind is Kind.CYLINDER:
            across = mass * (3.0 * a**2 + 4.0 * b**2) / 12.0
            return across, across, mass * a**2 / 2.0
        return (0.4 * mass * a**2,) * 3


def assemble(parts: tuple[Part, ...], tip: float) -> Tool:
    """The tool made of ``parts``, its tip at ``tip`` on z of T6 (m), its frame along that of T6."""
    mass = sum(part.mass for part in parts)
    middle = sum(part.mass * part.middle for part in parts) / mass
    across = sum(part.mass * (part.middle - middle) ** 2 for part in parts)
    xx, yy, zz = (sum(part.inertia[axis] for part in parts) for axis in range(3))
    shapes = tuple(
        Shape(part.kind, part.size, Transform.translation(0.0, 0.0, part.middle), solid=part.solid)
        for part in parts
    )
    return Tool(
        mass,
        (0.0, 0.0, middle),
        (xx + across, yy + across, zz),
        shapes,
        Transform.translation(0.0, 0.0, tip),
    )


def holder(end: float) -> Part:
    """What the hand grips: a cylinder of 40 mm up to ``end`` on z of T6 (m); it meets nothing."""
    return Part(Kind.CYLINDER, (0.018, 0.020, 0.0), end - 0.020, solid=False)


def stylus() -> Tool:
    """A ball of 20 mm on a rod; its tip is the ball's foremost point, 160 mm from T6."""
    rod = Part(Kind.CYLINDER, (0.006, 0.020, 0.0), 0.120, solid=False)
    ball = Part(Kind.SPHERE, (0.010, 0.0, 0.0), 0.150)
    return assemble((holder(0.100), rod, ball), 0.160)


def block() -> Tool:
    """A cube of 40 mm; its tip is its middle, 120 mm from T6."""
    return assemble((holder(0.100), Part(Kind.BOX, (0.020, 0.020, 0.020), 0.120)), 0.120)

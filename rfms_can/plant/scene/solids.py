"""Tools put together from solid parts along the hand's axis: their mass, centre and inertia."""

import math
from collections.abc import Callable
from typing import Final, NamedTuple

from rfms_can.plant.scene.shape import Kind, Shape, Tool
from rfms_can.tables import complete
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
        return _SOLIDS[self.kind].mass(self.size)

    @property
    def inertia(self) -> Vector3:
        """About its middle, along x, y and z, kg m2."""
        return _SOLIDS[self.kind].inertia(self.mass, self.size)


class _Solid(NamedTuple):
    """Formulas of a kind of solid, of steel.

    Attributes:
        mass: from its size; kg.
        inertia: from its mass and size, about its middle, along x, y and z; kg m2.
    """

    mass: Callable[[Vector3], float]
    inertia: Callable[[float, Vector3], Vector3]


def _box_mass(size: Vector3) -> float:
    a, b, c = size
    return STEEL_DENSITY * 8.0 * a * b * c


def _box_inertia(mass: float, size: Vector3) -> Vector3:
    a, b, c = size
    third = mass / 3.0
    return third * (b**2 + c**2), third * (a**2 + c**2), third * (a**2 + b**2)


def _cylinder_mass(size: Vector3) -> float:
    radius, half, _ = size
    return STEEL_DENSITY * math.pi * radius**2 * 2.0 * half


def _cylinder_inertia(mass: float, size: Vector3) -> Vector3:
    radius, half, _ = size
    across = mass * (3.0 * radius**2 + 4.0 * half**2) / 12.0
    return across, across, mass * radius**2 / 2.0


def _sphere_mass(size: Vector3) -> float:
    return STEEL_DENSITY * 4.0 / 3.0 * math.pi * size[0] ** 3


def _sphere_inertia(mass: float, size: Vector3) -> Vector3:
    return (0.4 * mass * size[0] ** 2,) * 3


_SOLIDS: Final = complete(
    {
        Kind.BOX: _Solid(_box_mass, _box_inertia),
        Kind.CYLINDER: _Solid(_cylinder_mass, _cylinder_inertia),
        Kind.SPHERE: _Solid(_sphere_mass, _sphere_inertia),
    },
    [kind for kind in Kind if kind is not Kind.PLANE],  # infinite: it cannot be held
)


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

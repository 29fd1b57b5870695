"""A peg in the hand and a hole with a chamfer (thesis Fig. 1.1).

The hole is a ring of boxes whose inner faces touch the round hole from outside: in the middle of a
face the radius is exact, at a corner it is larger by radius (1 / cos(pi / facets) - 1), and a peg
is never held tighter than by the round hole.
"""

import math
from dataclasses import dataclass
from typing import Final

from rfms_can.plant.scene.shape import Contact, Kind, Scene, Shape, Tool
from rfms_can.transform import Transform

STEEL_DENSITY: Final = 7850.0  # kg/m3
WALL: Final = 0.006
"""Half thickness of a wall's box, m: more than any contact sinks in."""


@dataclass(frozen=True, slots=True)
class PegInHole:
    """Dimensions, m.

    Attributes:
        radius: of the peg.
        length: of the peg, from the flange of the hand to its end.
        grip: from T6 to where the peg leaves the hand.
        clearance: radius of the hole less that of the peg.
        chamfer: of the hole, at 45 degrees.
        depth: of the hole, chamfer included; open below.
        facets: boxes around the hole.
    """

    radius: float = 0.010
    length: float = 0.060
    grip: float = 0.10
    clearance: float = 0.0002
    chamfer: float = 0.003
    depth: float = 0.050
    facets: int = 64

    @property
    def facet_error(self) -> float:
        """How much wider than round the hole is at its corners, m."""
        return (self.radius + self.clearance) * (1.0 / math.cos(math.pi / self.facets) - 1.0)

    def tool(self) -> Tool:
        """The peg, along z of T6."""
        mass = STEEL_DENSITY * math.pi * self.radius**2 * self.length
        across = mass * (3.0 * self.radius**2 + self.length**2) / 12.0
        along = mass * self.radius**2 / 2.0
        middle = self.grip + self.length / 2.0
        pose = Transform.translation(0.0, 0.0, middle)
        shape = Shape(Kind.CYLINDER, (self.radius, self.length / 2.0, 0.0), pose)
        tip = Transform.translation(0.0, 0.0, self.grip + self.length)
        return Tool(mass, (0.0, 0.0, middle), (across, across, along), (shape,), tip)

    def hole(self) -> tuple[Shape, ...]:
        """The hole, its mouth at the origin, its axis along z, open towards +z."""
        return tuple(
            shape
            for k in range(self.facets)
            for shape in self._sector(2.0 * math.pi * k / self.facets)
        )

    def _sector(self, angle: float) -> tuple[Shape, Shape]:
        """Wall and chamfer at an angle about z."""
        turn = Transform.rotation((0.0, 0.0, 1.0), angle)
        bore = self.radius + self.clearance
        half = math.tan(math.pi / self.facets)
        height = (self.depth - self.chamfer) / 2.0
        wall = Shape(
            Kind.BOX,
            (WALL, (bore + 2.0 * WALL) * half, height),
            turn @ Transform.translation(bore + WALL, 0.0, -self.chamfer - height),
        )
        # The face of the chamfer runs from (bore, -chamfer) to (bore + chamfer, 0) in (r, z); the
        # box lies behind it, along its normal (1, -1) / sqrt 2.
        lies = WALL / math.sqrt(2.0)
        centre = Transform.translation(
            bore + self.chamfer / 2.0 + lies, 0.0, -self.chamfer / 2.0 - lies
        )
        tilt = Transform.rotation((0.0, 1.0, 0.0), math.pi / 4.0)
        width = (bore + self.chamfer + 2.0 * WALL) * half
        face = Shape(Kind.BOX, (WALL, width, self.chamfer / math.sqrt(2.0)), turn @ centre @ tilt)
        return wall, face

    def scene(self, hole: Transform, contact: Contact) -> Scene:
        """The scene with the mouth of the hole at ``hole`` in the base frame, z out of it."""
        fixtures = tuple(Shape(shape.kind, shape.size, hole @ shape.pose) for shape in self.hole())
        return Scene("peg", fixtures, self.tool(), contact, longest_step_s=2.5e-4)

"""A peg in the hand and a hole with a chamfer (thesis Fig. 1.1).

The hole is a ring of boxes whose inner faces touch the round hole from outside: in the middle of a
face the radius is exact, at a corner it is larger by radius (1 / cos(pi / facets) - 1), and a peg
is never held tighter than by the round hole. The edges of a box are rounded, so it is wide and high
enough for only those edges to be so that a hole has: at its mouth, and from chamfer to bore.
"""

import math
from dataclasses import dataclass
from typing import Final

from rfms_can.plant.scene.parameters import FRICTION, Key, Values, displaced
from rfms_can.plant.scene.shape import (
    CONTACT_STEP_S,
    EDGE_RADIUS,
    STEEL,
    Contact,
    Kind,
    Scene,
    Shape,
    Tool,
)
from rfms_can.plant.scene.solids import Part, assemble
from rfms_can.transform import Transform

HOLE: Final = Transform.translation(0.6, 0.15, 0.0)
"""Where the mouth of the hole should be, in the base frame of the PUMA 560; z out of it."""

KEYS: Final = (
    Key("x_mm", 0.0, -5.0, 5.0, "the hole lies off along x"),
    Key("y_mm", 0.0, -5.0, 5.0, "the hole lies off along y"),
    Key("tilt_x_deg", 0.0, -5.0, 5.0, "its axis leans, turned about x at the mouth"),
    Key("tilt_y_deg", 0.0, -5.0, 5.0, "its axis leans, turned about y at the mouth"),
    Key("clearance_mm", 0.2, 0.02, 2.0, "radius of the hole less that of the peg"),
    FRICTION,
)

WALL: Final = 0.006
"""Half thickness of a wall's box, m: more than any contact sinks in."""
BLUNT: Final = EDGE_RADIUS * (1.0 - math.tan(math.pi / 8.0))
"""How much higher than the bore a wall's box is, m: the rounding of an edge of 135 degrees, which
the bore has there, begins that much nearer to it than the box' own, of 90."""
FACET_ERROR: Final = 0.1
"""Largest error of the facets, over the clearance."""


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
    """

    radius: float = 0.010
    length: float = 0.060
    grip: float = 0.10
    clearance: float = 0.0002
    chamfer: float = 0.003
    depth: float = 0.050

    @property
    def facets(self) -> int:
        """Boxes around the hole: as few as keep the error under a tenth of the clearance."""
        bore = self.radius + self.clearance
        return math.floor(math.pi / math.acos(bore / (bore + FACET_ERROR * self.clearance))) + 1

    @property
    def facet_error(self) -> float:
        """How much wider than round the hole is at its corners, m."""
        return (self.radius + self.clearance) * (1.0 / math.cos(math.pi / self.facets) - 1.0)

    def tool(self) -> Tool:
        """The peg, along z of T6, and its end."""
        end = self.grip + self.length
        half = self.length / 2.0
        return assemble((Part(Kind.CYLINDER, (self.radius, half, 0.0), end - half),), end)

    def hole(self) -> tuple[Shape, ...]:
        """The hole, its mouth at the origin, its axis along z, open towards +z."""
        facets = self.facets
        return tuple(
            shape for k in range(facets) for shape in self._sector(2.0 * math.pi * k / facets)
        )

    def _sector(self, angle: float) -> tuple[Shape, Shape]:
        """Wall and chamfer at an angle about z."""
        turn = Transform.rotation((0.0, 0.0, 1.0), angle)
        bore = self.radius + self.clearance
        half = math.tan(math.pi / self.facets)
        height = (self.depth - self.chamfer + BLUNT) / 2.0
        wall = Shape(
            Kind.BOX,
            (WALL, (bore + 2.0 * WALL) * half + EDGE_RADIUS, height),
            turn @ Transform.translation(bore + WALL, 0.0, BLUNT - self.chamfer - height),
        )
        # The face of the chamfer runs from (bore, -chamfer) to (bore + chamfer, 0) in (r, z); the
        # box lies behind it, along its normal (1, -1) / sqrt 2.
        lies = WALL / math.sqrt(2.0)
        centre = Transform.translation(
            bore + self.chamfer / 2.0 + lies, 0.0, -self.chamfer / 2.0 - lies
        )
        tilt = Transform.rotation((0.0, 1.0, 0.0), math.pi / 4.0)
        width = (bore + self.chamfer + 2.0 * WALL) * half + EDGE_RADIUS
        face = Shape(Kind.BOX, (WALL, width, self.chamfer / math.sqrt(2.0)), turn @ centre @ tilt)
        return wall, face

    def scene(self, hole: Transform = HOLE, contact: Contact = STEEL) -> Scene:
        """The scene with the mouth of the hole at ``hole`` in the base frame, z out of it."""
        fixtures = tuple(Shape(shape.kind, shape.size, hole @ shape.pose) for shape in self.hole())
        return Scene("peg", fixtures, self.tool(), hole, contact, CONTACT_STEP_S)


def build(values: Values) -> Scene:
    """The scene with the values of :data:`KEYS`."""
    peg = PegInHole(clearance=1e-3 * values["clearance_mm"])
    return peg.scene(displaced(HOLE, values), Contact(friction=values["friction"]))

"""Tracing a corner (thesis Fig. 5.1): a block in the hand slides along AB, then along BC.

The thesis shows the walls and leaves open on which side of them the block is. Here it is inside, so
that AB ends at the other wall and contact is never lost. Seen from above, in the corner's frame::

            A                        B = origin
      ======|========================#
                        ->    [ ]    #          y
                       block   |     #          |
                               v     #          +-- x
                                     - C

Along AB the block complies in y and about z and x: what its face against the wall takes away. At B
it meets BC, and from there to C it complies along x and about z and y.
"""

from typing import Final

from rfms_can.plant.scene.parameters import FRICTION, Key, Values, displaced
from rfms_can.plant.scene.shape import CONTACT_STEP_S, Contact, Kind, Scene, Shape
from rfms_can.plant.scene.solids import block
from rfms_can.transform import Transform

CORNER: Final = Transform.translation(0.6, 0.2, 0.0)
"""Where B should be, in the base frame of the PUMA 560, at the height of the block's middle. The
wall AB is the plane y = 0, the wall BC the plane x = 0; the block comes from -x, leaves to -y."""

KEYS: Final = (
    Key("x_mm", 0.0, -20.0, 20.0, "the walls lie off along x"),
    Key("y_mm", 0.0, -20.0, 20.0, "the walls lie off along y"),
    Key("turn_deg", 0.0, -10.0, 10.0, "both walls are turned about z at B"),
    FRICTION,
)

LENGTH: Final = 0.25  # of either wall, m
HALF_HEIGHT: Final = 0.03  # m
HALF_THICKNESS: Final = 0.010  # m


def build(values: Values) -> Scene:
    """The scene with the values of :data:`KEYS`."""
    place = displaced(CORNER, values)
    half = LENGTH / 2.0
    behind = HALF_THICKNESS
    ab = Shape(
        Kind.BOX,
        (half, HALF_THICKNESS, HALF_HEIGHT),
        place @ Transform.translation(-half, behind, 0.0),
    )
    bc = Shape(
        Kind.BOX,
        (HALF_THICKNESS, half + behind, HALF_HEIGHT),
        place @ Transform.translation(behind, behind - half, 0.0),
    )
    contact = Contact(friction=values["friction"])
    return Scene("corner", (ab, bc), block(), place, contact, CONTACT_STEP_S)

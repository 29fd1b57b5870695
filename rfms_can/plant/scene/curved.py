"""A round back under a ball-ended stylus: a lying cylinder, followed along x over its crown."""

import math
from typing import Final

from rfms_can.plant.scene.parameters import FRICTION, Key, Values, displaced
from rfms_can.plant.scene.shape import CONTACT_STEP_S, Contact, Kind, Scene, Shape
from rfms_can.plant.scene.solids import stylus
from rfms_can.transform import Transform

CROWN: Final = Transform.translation(0.6, 0.15, 0.0)
"""Where the middle of the crown should be, in the base frame of the PUMA 560: z out of it, the
cylinder's axis along y."""

RADIUS_KEY: Final = "radius_mm"
KEYS: Final = (
    Key(RADIUS_KEY, 400.0, 150.0, 1000.0, "of the cylinder"),
    Key("x_mm", 0.0, -50.0, 50.0, "its crown lies off along x"),
    Key("z_mm", 0.0, -50.0, 50.0, "its crown lies higher"),
    FRICTION,
)

HALF_LENGTH: Final = 0.10  # m


def build(values: Values) -> Scene:
    """The scene with the values of :data:`KEYS`."""
    place, radius = displaced(CROWN, values), 1e-3 * values[RADIUS_KEY]
    lying = Transform.rotation((1.0, 0.0, 0.0), math.pi / 2.0)
    back = Shape(
        Kind.CYLINDER,
        (radius, HALF_LENGTH, 0.0),
        place @ Transform.translation(0.0, 0.0, -radius) @ lying,
    )
    contact = Contact(friction=values["friction"])
    return Scene("curved", (back,), stylus(), place, contact, CONTACT_STEP_S)

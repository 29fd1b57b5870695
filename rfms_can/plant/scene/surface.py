"""A flat plate under a ball-ended stylus: tilted or not, to be met, pressed on and followed."""

from typing import Final

from rfms_can.plant.scene.parameters import FRICTION, Key, Values, displaced
from rfms_can.plant.scene.shape import CONTACT_STEP_S, Contact, Kind, Scene, Shape
from rfms_can.plant.scene.solids import stylus
from rfms_can.transform import Transform

SURFACE: Final = Transform.translation(0.6, 0.15, 0.0)
"""Where the middle of the plate's top should be, in the base frame of the PUMA 560; z out of it."""

KEYS: Final = (
    Key("z_mm", 0.0, -50.0, 50.0, "the plate lies higher"),
    Key("tilt_x_deg", 0.0, -30.0, 30.0, "it is turned about x at its middle"),
    Key("tilt_y_deg", 0.0, -30.0, 30.0, "it is turned about y at its middle"),
    FRICTION,
)

HALF_SIZE: Final = 0.15  # m, along x and y
HALF_THICKNESS: Final = 0.010  # m: more than any contact sinks in


def build(values: Values) -> Scene:
    """The scene with the values of :data:`KEYS`."""
    place = displaced(SURFACE, values)
    below = Transform.translation(0.0, 0.0, -HALF_THICKNESS)
    plate = Shape(Kind.BOX, (HALF_SIZE, HALF_SIZE, HALF_THICKNESS), place @ below)
    contact = Contact(friction=values["friction"])
    return Scene("surface", (plate,), stylus(), place, contact, CONTACT_STEP_S)

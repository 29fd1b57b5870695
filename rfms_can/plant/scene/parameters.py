"""Parameters of a scene, parsed strictly from ``NAME`` or ``NAME:key=value,key=value``."""

import math
from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

from rfms_can.errors import PlantError
from rfms_can.transform import Transform

Values = Mapping[str, float]
"""Value of every key of a scene, in the units of its name."""


class Key(NamedTuple):
    """A parameter of a scene.

    Attributes:
        name: with its unit, e.g. ``x_mm``.
        default: its value when it is not given.
        minimum, maximum: bounds, both included.
        meaning: short description.
    """

    name: str
    default: float
    minimum: float
    maximum: float
    meaning: str


FRICTION: Final = Key("friction", 0.2, 0.0, 1.0, "sliding coefficient of the contact")


def read(scene: str, text: str, keys: Sequence[Key]) -> dict[str, float]:
    """The value of every key of a scene, as ``key=value,key=value`` gives them, or as default.

    Raises:
        PlantError: an unknown key, a key given twice, or a value out of bounds or not a number.
    """
    known = {key.name: key for key in keys}
    values = {key.name: key.default for key in keys}
    given = set()
    for pair in text.split(",") if text else ():
        name, equals, number = (part.strip() for part in pair.partition("="))
        if name not in known:
            there_are = ", ".join(known) or "none"
            raise PlantError(f"scene {scene!r} has no key {name!r}; there are: {there_are}")
        if name in given:
            raise PlantError(f"scene {scene!r}: {name} is given twice")
        given.add(name)
        key = known[name]
        values[name] = _number(scene, name, number if equals else "")
        if not key.minimum <= values[name] <= key.maximum:
            raise PlantError(
                f"scene {scene!r}: {name} {number} is not in {key.minimum:g}..{key.maximum:g}"
            )
    return values


def _number(scene: str, name: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise PlantError(f"scene {scene!r}: {name}={text} is not a number; write e.g. {name}=0.5")
    return value


def displaced(place: Transform, values: Values) -> Transform:
    """A frame displaced, in its own axes, by x_mm, y_mm, z_mm, then rotated about x, y and z by
    tilt_x_deg, tilt_y_deg and turn_deg."""
    x, y, z = (1e-3 * values.get(name, 0.0) for name in ("x_mm", "y_mm", "z_mm"))
    moved = place @ Transform.translation(x, y, z)
    for axis, name in (
        ((1.0, 0.0, 0.0), "tilt_x_deg"),
        ((0.0, 1.0, 0.0), "tilt_y_deg"),
        ((0.0, 0.0, 1.0), "turn_deg"),
    ):
        moved @= Transform.rotation(axis, math.radians(values.get(name, 0.0)))
    return moved

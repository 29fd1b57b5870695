"""The available scenes by name."""

from collections.abc import Callable, Mapping
from functools import lru_cache
from types import MappingProxyType
from typing import Final, NamedTuple

from rfms_can.errors import PlantError
from rfms_can.plant.scene import corner, curved, peg_in_hole, surface
from rfms_can.plant.scene.parameters import Key, Values, read
from rfms_can.plant.scene.shape import FREE, Scene

ARM: Final = "puma560"
"""The arm of all scenes but ``free``; the PUMA 260 does not reach them."""


class Entry(NamedTuple):
    """An available scene.

    Attributes:
        meaning: short description.
        keys: its parameters.
        build: builds it from their values.
    """

    meaning: str
    keys: tuple[Key, ...]
    build: Callable[[Values], Scene]


SCENES: Final[Mapping[str, Entry]] = MappingProxyType(
    {
        "free": Entry("nothing but the arm", (), lambda _: FREE),
        "peg": Entry("a peg in the hand, and its hole", peg_in_hole.KEYS, peg_in_hole.build),
        "surface": Entry("a stylus in the hand, and a plate", surface.KEYS, surface.build),
        "curved": Entry("a stylus in the hand, and a round back", curved.KEYS, curved.build),
        "corner": Entry("a block in the hand, and two walls", corner.KEYS, corner.build),
    }
)


@lru_cache(maxsize=64)
def scene_from(text: str, arm: str) -> Scene:
    """The scene ``NAME`` or ``NAME:key=value,key=value`` for an arm (its name).

    Raises:
        PlantError: the scene does not exist, or not for this arm; the message lists those that do.
    """
    name, _, rest = text.partition(":")
    if name not in SCENES:
        raise PlantError(f"scene {name!r} does not exist; there are: {', '.join(SCENES)}")
    entry = SCENES[name]
    scene = entry.build(read(name, rest, entry.keys))
    if scene.tool is not None and arm != ARM:
        raise PlantError(
            f"scene {name!r} stands in front of {ARM}, out of the reach of {arm}: give --arm {ARM}"
        )
    return scene

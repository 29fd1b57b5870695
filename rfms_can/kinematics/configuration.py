"""The eight branches of the inverse solution, by the thesis' labels (A.41, A.48, A.56).

The labels are algebraic: the elbow is geometrically *above* the arm in "left down" and "right up".
"""

from collections.abc import Sequence
from typing import Final, NamedTuple

from rfms_can.errors import KinematicsError
from rfms_can.kinematics.geometry import Geometry
from rfms_can.kinematics.singularity import singularity_margins

_WORDS: Final = (("left", "right"), ("up", "down"), ("flip", "noflip"))


class Configuration(NamedTuple):
    """One branch of the inverse solution.

    Attributes:
        left: V114 = C1 px + S1 py >= 0 (A.41a); else right (A.41b).
        up: the forearm bends to positive angles, C3 >= 0 where a3 = 0 (A.48b); else down (A.48a).
        noflip: S5 >= 0 (A.56b); else flip (A.56a).
    """

    left: bool
    up: bool
    noflip: bool

    @classmethod
    def parse(cls, text: str) -> "Configuration":
        """The configuration of three words in any order, e.g. ``"left up noflip"``.

        Raises:
            KinematicsError: a word is unknown, missing or contradicted.
        """
        words = text.split()
        if len(words) != 3 or any(len({*pair} & {*words}) != 1 for pair in _WORDS):
            raise KinematicsError(
                f"configuration {text[:60]!r}: give one word of each pair, in any order: "
                + ", ".join(f"{first}|{second}" for first, second in _WORDS)
            )
        return cls("left" in words, "up" in words, "noflip" in words)

    @property
    def code(self) -> int:
        """0 to 7 for the wire: bit 0 right, bit 1 down, bit 2 flip."""
        left, up, noflip = self
        return (not left) | (not up) << 1 | (not noflip) << 2

    @staticmethod
    def from_code(code: int) -> "Configuration":
        """The configuration of a wire code; bits above the third are ignored."""
        return CONFIGURATIONS[code & 7]

    def __str__(self) -> str:
        left, up, noflip = self
        return (
            f"{'left' if left else 'right'} {'up' if up else 'down'} "
            f"{'noflip' if noflip else 'flip'}"
        )


CONFIGURATIONS: Final = tuple(
    Configuration(not code & 1, not code & 2, not code & 4) for code in range(8)
)
"""All eight, each at the index of its ``code``."""


def configuration_of(arm: Geometry, q: Sequence[float]) -> Configuration:
    """The configuration the arm is in at ``q``; on a border left, up and noflip win."""
    margins = singularity_margins(arm, q)
    return Configuration(margins.shoulder >= 0.0, margins.elbow >= 0.0, margins.wrist >= 0.0)

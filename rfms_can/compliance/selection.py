"""Compliant directions: RCCL's words and the selection matrix S of (5.1)."""

from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from rfms_can.errors import ProgramError

DIRECTIONS: Final = ("fx", "fy", "fz", "rx", "ry", "rz")
"""Words of the six directions of the compliance frame: along and about its axes."""
MAX_BIAS: Final = 1e5
"""Largest bias force or moment of a request, N or N m: far beyond any arm."""

Bias = tuple[float, float, float, float, float, float]
"""Forces and moments, N and N m, in the order of ``DIRECTIONS``."""


class SelectionError(ProgramError, ValueError):
    """An unknown or repeated direction, or a lock of one that does not comply."""


class Selection(NamedTuple):
    """s1 to s6, the diagonal of S (5.1): True where force is controlled and the arm complies."""

    fx: bool = False
    fy: bool = False
    fz: bool = False
    rx: bool = False
    ry: bool = False
    rz: bool = False

    @classmethod
    def parse(cls, word: str) -> "Selection":
        """The directions of a word, e.g. ``"fx fy rx ry"`` for the peg in hole (5.2).

        Raises:
            SelectionError: an empty word, an unknown direction, or one named twice.
        """
        names = word.split()
        if not names:
            raise SelectionError(
                f"selection {word!r} names no direction: give some of {' '.join(DIRECTIONS)}"
            )
        for name in names:
            if name not in DIRECTIONS:
                raise SelectionError(
                    f"selection {word!r}: {name!r} is not a direction; there are: "
                    f"{', '.join(DIRECTIONS)}"
                )
            if names.count(name) > 1:
                raise SelectionError(f"selection {word!r} names {name} twice: name it once")
        return cls(*(name in names for name in DIRECTIONS))

    @classmethod
    def of(cls, selected: Iterable[bool]) -> "Selection":
        """The selection with these six booleans."""
        return cls(*(bool(s) for s in selected))

    @property
    def word(self) -> str:
        """The word for it; empty if nothing complies."""
        return " ".join(name for name, s in zip(DIRECTIONS, self, strict=True) if s)

    @property
    def size(self) -> int:
        """Number of compliant directions, 0 to 6."""
        return sum(self)

    @property
    def mask(self) -> npt.NDArray[np.bool_]:
        """(6,), True where the arm complies: picks rows of a Jacobian."""
        return np.array(self, dtype=np.bool_)

    def with_(self, other: "Selection") -> "Selection":
        """The union: the selection after ``comply``."""
        return Selection.of(a or b for a, b in zip(self, other, strict=True))

    def without(self, other: "Selection") -> "Selection":
        """The difference: the selection after ``lock``.

        Raises:
            SelectionError: a direction to be locked does not comply.
        """
        rigid = [n for n, a, b in zip(DIRECTIONS, self, other, strict=True) if b and not a]
        if rigid:
            raise SelectionError(
                f"lock {other.word!r}: {' '.join(rigid)} does not comply; "
                f"what does: {self.word or 'nothing'}"
            )
        return Selection.of(a and not b for a, b in zip(self, other, strict=True))


def parse_bias(word: str, values: Sequence[float]) -> tuple[Selection, Bias]:
    """Parse a ``comply`` request: directions, and the bias force or moment along each.

    Args:
        word: directions, e.g. ``"fx fy rx ry"``.
        values: one for each direction of the word, in its order, N or N m.

    Returns:
        The selection, and the bias in the order of ``DIRECTIONS`` (6), zero where it is rigid.

    Raises:
        SelectionError: as :meth:`Selection.parse`; not one value for each, or not a number.
    """
    selection, names = Selection.parse(word), word.split()
    if len(values) != len(names):
        raise SelectionError(
            f"comply {word!r}: {len(values)} values for {len(names)} directions; give the bias "
            f"force or moment of each, 0.0 for none"
        )
    for name, value in zip(names, values, strict=True):
        if not abs(value) <= MAX_BIAS:  # also NaN
            raise SelectionError(
                f"comply {word!r}: the bias of {name} is {value}; give N or N m, "
                f"{MAX_BIAS:g} at most"
            )
    bias = dict(zip(names, values, strict=True))
    x, y, z, rx, ry, rz = (bias.get(name, 0.0) for name in DIRECTIONS)
    return selection, (x, y, z, rx, ry, rz)

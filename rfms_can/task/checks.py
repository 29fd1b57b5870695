"""What the primitives refuse: each error names the call, the value, the bound, and the way out."""

import math
from collections.abc import Mapping, Sequence

from rfms_can.compliance.selection import DIRECTIONS, parse_bias
from rfms_can.coordinator import ProgramError, SelectionError

FARTHEST_M = 1.0
"""How far off a frame a motion of a task may begin or end, m."""


def number(what: str, name: str, value: object, least: float, most: float, unit: str) -> float:
    """A number within bounds.

    Raises:
        ProgramError: it is not a number, or outside of them.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not least <= value <= most:
        raise ProgramError(
            f"{what}: {name} {value!r}: give a number of {unit}, {least:g} to {most:g}"
        )
    return float(value)


def positive(what: str, name: str, value: object, most: float, unit: str) -> float:
    """A number more than 0, and at most as large as a bound.

    Raises:
        ProgramError: it is not.
    """
    if number(what, name, value, 0.0, most, unit) == 0.0:
        raise ProgramError(f"{what}: {name} 0: give more than 0 {unit}, up to {most:g}")
    return float(value)  # type: ignore[arg-type]  # number() has seen to it


def offset(what: str, by: object) -> tuple[float, float, float]:
    """A displacement along the axes of a frame, m.

    Raises:
        ProgramError: not three numbers, none at all, or too far.
    """
    if isinstance(by, str) or not isinstance(by, Sequence) or len(by) != 3:
        raise ProgramError(
            f"{what}: by {by!r}: give three metres along the axes of the frame, as in (0, 0, -0.05)"
        )
    x, y, z = (number(what, f"by {by!r}:", one, -FARTHEST_M, FARTHEST_M, "m") for one in by)
    if not 0.0 < math.hypot(x, y, z) <= FARTHEST_M:
        raise ProgramError(
            f"{what}: by {by!r} is {math.hypot(x, y, z):g} m: more than 0, and {FARTHEST_M:g} m at "
            f"most, has to be between the frame and the point off it"
        )
    return x, y, z


def forces(what: str, name: str, given: object, *, signed: bool) -> dict[str, float]:
    """Directions of the compliance frame, each with a force or moment, N or N m.

    Args:
        what, name: call and argument, for the error.
        given: the mapping.
        signed: whether they may be zero and negative, as a bias may; a bound may not.

    Raises:
        SelectionError: not a mapping, an unknown direction, or a value out of bounds.
    """
    if not isinstance(given, Mapping) or not given:
        raise SelectionError(
            f"{what}: {name} {given!r}: give directions of {' '.join(DIRECTIONS)}, each with N or "
            f"N m, as in {{'fz': 10.0}}"
        )
    for direction, value in given.items():
        if direction not in DIRECTIONS:
            raise SelectionError(
                f"{what}: {name} {dict(given)!r}: {direction!r} is not a direction; there are: "
                f"{', '.join(DIRECTIONS)}"
            )
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise SelectionError(f"{what}: {name}: {direction} is {value!r}: give N or N m")
        if not signed and not value > 0.0:  # also NaN
            raise SelectionError(
                f"{what}: {name}: {direction} is {value!r}: a bound is more than 0, and holds in "
                f"both senses"
            )
    parse_bias(" ".join(given), list(given.values()))
    return {direction: float(value) for direction, value in given.items()}

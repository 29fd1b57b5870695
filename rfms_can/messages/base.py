"""Base class of all messages, and the bounds of their fields. SI units, radians."""

from typing import Annotated, Final

import msgspec

T6: Final = "t6"
"""The name every position equation uses for the arm itself."""

MAX_BYTES: Final = 64 * 1024
"""Largest message on the link, bytes; longer ones are refused before they are parsed."""

Name = Annotated[str, msgspec.Meta(min_length=1, max_length=64)]
Word = Annotated[str, msgspec.Meta(max_length=64)]
Vector3 = tuple[float, float, float]
Vector6 = tuple[float, float, float, float, float, float]
Rigid = tuple[float, float, float, float, float, float, float, float, float, float, float, float]
"""The first three rows of a homogeneous transform, row-major; metres."""
Seconds = Annotated[float, msgspec.Meta(gt=0.0, le=100.0)]
Positive = Annotated[float, msgspec.Meta(gt=0.0, le=1e6)]
FARTHEST_CORNER: Final = 1.0
"""Deviation of a corner that may be asked for at most, m: more than any arm here makes."""
Deviation = Annotated[float, msgspec.Meta(gt=0.0, le=FARTHEST_CORNER)]
"""Of a corner, m."""
Mass = Annotated[float, msgspec.Meta(ge=0.0, le=1e3)]
Factor = Annotated[float, msgspec.Meta(ge=1.0, le=1e6)]
Fraction = Annotated[float, msgspec.Meta(gt=0.0, le=1.0)]
Directions = Annotated[dict[str, float], msgspec.Meta(min_length=1, max_length=6)]
"""Directions of the compliance frame, and a number for each."""


class Message(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag=True):
    """Base of all messages: immutable, typed, unknown fields forbidden."""

"""Functional transforms: coordinates as functions of the motion parameters (h, t).

A closed set of data types: the server evaluates them and never runs code of a client. ``u`` below
is the parameter: h, the completed fraction of the segment (0 to 1), or t, the time within the
segment, s (-t_acc where its transition begins, t_seg at its goal; thesis III.3.2, III.3.4).
"""

from typing import Annotated, Literal

import msgspec

from rfms_can.messages.base import Vector3, Vector6

Parameter = Literal["h", "t"]


class Function(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag=True):
    """Base of all functions."""


class Linear(Function, frozen=True, tag="LINEAR"):
    """Translation ``along`` u and rotation vector ``turn`` u.

    Attributes:
        along: metres per unit of the parameter (m/s with t).
        turn: rotation vector, radians per unit of the parameter.
        parameter: ``"h"`` or ``"t"``.
    """

    along: Vector3 = (0.0, 0.0, 0.0)
    turn: Vector3 = (0.0, 0.0, 0.0)
    parameter: Parameter = "h"


class Circular(Function, frozen=True, tag="CIRCULAR"):
    """A circle in the x-y plane: (radius cos a, radius sin a, 0) with a = phase + angle u.

    Attributes:
        radius: metres.
        angle: radians per unit of the parameter.
        phase: radians at u = 0.
        turns: whether the frame turns with the angle, about z.
        parameter: ``"h"`` or ``"t"``.
    """

    radius: float
    angle: float
    phase: float = 0.0
    turns: bool = False
    parameter: Parameter = "h"


class Weave(Function, frozen=True, tag="WEAVE"):
    """A sinusoidal weave: ``amplitude`` sin(2 pi ``cycles`` u).

    Attributes:
        amplitude: metres, as a vector: the direction across the seam.
        cycles: periods per unit of the parameter (hertz with t).
        parameter: ``"h"`` or ``"t"``.
    """

    amplitude: Vector3
    cycles: float
    parameter: Parameter = "h"


class TableRow(msgspec.Struct, frozen=True, array_like=True, forbid_unknown_fields=True):
    """One row of a table: the parameter, x y z in metres and a rotation vector in radians."""

    u: float
    coordinates: Vector6


class Table(Function, frozen=True, tag="TABLE"):
    """Coordinates by a table; before its first and after its last row they are constant.

    Attributes:
        rows: at least two, with increasing u.
        interpolation: ``"cubic"`` is a spline whose ends are at rest; ``"linear"`` has corners.
        parameter: ``"h"`` or ``"t"``.
    """

    rows: Annotated[list[TableRow], msgspec.Meta(min_length=2, max_length=512)]
    interpolation: Literal["linear", "cubic"] = "cubic"
    parameter: Parameter = "h"


AnyFunction = Linear | Circular | Weave | Table

"""Constants and terms of the simplified Lagrangian dynamics (Eq. 4.9, 4.11, 4.12 as corrected).

The equations are linear in their constants: gravity, effective inertia and coupling of a joint are
each a row of functions of the angles times the constants named here. ``c`` in Nm, ``b`` in kg m2;
``b10``, ``b20``, ... ``b60`` include the actuator's inertia Ia, as the thesis measures them.

Corrections: D44 goes with S5^2, D11 with C2^2 (printed S^2, C^2); c22 (sideways centre of mass of
link 2, 3 % of c21) and the wrist's terms of D2 and D3 were dropped in print and cost nothing.

**Conventions.** Appendix A (B here, and everywhere in this package) and Chapter IV (A) differ in
their zero poses and axes: ``q_B = q_A + (pi, pi, -pi, 0, 0, pi)``. The equations are the same in
both; constants that go with C2, S2, C3 or S3 alone change their sign.
"""

from collections.abc import Mapping, Sequence
from math import cos, pi, sin
from typing import Final

GRAVITY: Final = ("c21", "c22", "c31", "c32", "c50")
"""Constants of D_i (Eq. 4.9), Nm."""
INERTIA: Final = (
    *("b10", "b11", "b12", "b13", "b14", "b15"),
    *("b20", "b25", "b26"),
    *("b30", "b31"),
    *("b40", "b41"),
    *("b50", "b60"),
)
"""Constants of D_ii + Ia_i (Eq. 4.11), kg m2."""
COUPLING: Final = ("b230", "b231", "b232")
"""Constants of D_23 (Eq. 4.12), kg m2."""
CONSTANTS: Final = (*GRAVITY, *INERTIA, *COUPLING)

SIGN_CHANGED: Final = frozenset(("c21", "c22", "b13", "b14", "b25", "b26", "b231", "b232"))
"""Constants whose sign differs between the conventions."""
OFFSET: Final = (pi, pi, -pi, 0.0, 0.0, pi)
"""q_B - q_A, rad."""

Row = dict[str, float]
"""Function values by the constant they are multiplied with; absent ones are zero."""


def gravity_row(joint: int, q: Sequence[float]) -> Row:
    """Functions of ``q`` (6, rad) in D_i of ``joint`` (1 to 6), Eq. 4.9."""
    _, q2, q3, q4, q5, _ = q
    s23, c23, s4, c4, s5, c5 = sin(q2 + q3), cos(q2 + q3), sin(q4), cos(q4), sin(q5), cos(q5)
    if joint == 4:
        return {"c50": -s23 * s4 * s5}
    if joint == 5:
        return {"c50": c23 * s5 + s23 * c4 * c5}
    if joint not in (2, 3):
        return {}
    row = {"c31": c23, "c32": s23, "c50": s23 * c5 + c23 * c4 * s5}
    return {"c21": cos(q2), "c22": sin(q2), **row} if joint == 2 else row


def inertia_row(joint: int, q: Sequence[float]) -> Row:
    """Functions of ``q`` (6, rad) in D_ii + Ia_i of ``joint`` (1 to 6), Eq. 4.11."""
    _, q2, q3, _, q5, _ = q
    if joint == 1:
        c2, s23, c23 = cos(q2), sin(q2 + q3), cos(q2 + q3)
        return {
            "b10": 1.0,
            "b11": c2 * c2,
            "b12": c23 * c23,
            "b13": c2 * c23,
            "b14": c2 * s23,
            "b15": s23 * c23,
        }
    if joint == 2:
        return {"b20": 1.0, "b25": cos(q3), "b26": sin(q3)}
    if joint == 3:
        return {"b30": 1.0, "b31": cos(q5)}
    if joint == 4:
        return {"b40": 1.0, "b41": sin(q5) ** 2}
    return {"b50": 1.0} if joint == 5 else {"b60": 1.0}


def coupling_row(q: Sequence[float]) -> Row:
    """Functions of ``q`` (6, rad) in D_23, Eq. 4.12."""
    return {"b230": 1.0, "b231": cos(q[2]), "b232": sin(q[2])}


def value(row: Row, constants: Mapping[str, float]) -> float:
    """A row times the constants."""
    return sum(factor * constants[name] for name, factor in row.items())


def in_other_convention(constants: Mapping[str, float]) -> dict[str, float]:
    """The constants in the other convention, either way."""
    return {name: -v if name in SIGN_CHANGED else v for name, v in constants.items()}


def from_convention_a(q: Sequence[float]) -> tuple[float, ...]:
    """Angles of convention B of the pose that has ``q`` (6, rad) in convention A."""
    return tuple(angle + offset for angle, offset in zip(q, OFFSET, strict=True))

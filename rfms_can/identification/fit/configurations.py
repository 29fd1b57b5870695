"""The thesis' own configurations, as printed and as corrected, and their observability.

Angles are convention A's, in degrees. Table 4.2: two of eight equations are printed with a wrong
sign. Eq. 4.29: as printed two of six rows are equal, b15 appears in none of them alone, and the
six equations have rank 5; corrected they have rank 6.
"""

from math import radians
from typing import Final, NamedTuple

import numpy as np

from rfms_can.dynamics.terms import Row, gravity_row, inertia_row
from rfms_can.identification.fit.least_squares import matrix_of


class Configuration(NamedTuple):
    """One row of Table 4.2.

    Attributes:
        joint: whose torque is read.
        angles_deg: theta1 to theta6.
        printed: the equation as the thesis has it.
    """

    joint: int
    angles_deg: tuple[float, float, float, float, float, float]
    printed: Row


TABLE_4_2: Final = (
    Configuration(3, (0, 0, 0, 0, 0, 0), {"c31": 1.0}),
    Configuration(3, (0, -90, 90, 0, 0, 0), {"c31": 1.0}),
    Configuration(3, (0, 0, 90, 0, 0, 0), {"c32": 1.0}),
    Configuration(3, (0, -90, 180, 0, 0, 0), {"c32": 1.0}),
    Configuration(2, (0, 0, 180, 0, 0, 0), {"c21": 1.0, "c31": -1.0}),
    Configuration(2, (0, 180, 180, 0, 0, 0), {"c21": 1.0, "c31": 1.0}),
    Configuration(4, (0, -90, 180, 90, 90, 0), {"c50": -1.0}),
    Configuration(4, (0, -90, 0, 90, 90, 0), {"c50": -1.0}),
)
CORRECTED_4_2: Final = {5: (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)}
"""Row 6 is then as printed: D2 = c21 + c31. Row 8 is correct with + c50 at the printed angles."""

Shapes = tuple[tuple[float, float], ...]
PRINTED_4_29: Final[Shapes] = ((-90, 0), (0, 0), (90, 90), (0, 90), (45, 45), (90, 90))
CORRECTED_4_29: Final[Shapes] = ((-90, 0), (0, 0), (-90, 90), (0, 90), (-90, 135), (45, 90))
BETTER_4_29: Final[Shapes] = (
    *((-90, 30), (30, 225), (-195, 0)),
    *((-165, 135), (-195, 75), (-105, 120)),
)
"""theta2, theta3 of the six rows that are to isolate b10 to b15."""


class Observability(NamedTuple):
    """Observability of the unknowns of a set of equations.

    Attributes:
        rank: of the matrix.
        unknowns: constants in it.
        condition: of the matrix; infinite below full rank.
    """

    rank: int
    unknowns: int
    condition: float


def first_joint(shapes: Shapes) -> Observability:
    """Observability of b10 to b15 from D11 at some shapes of the arm."""
    names = ("b10", "b11", "b12", "b13", "b14", "b15")
    rows = [
        inertia_row(1, (0.0, radians(two), radians(three), 0.0, 0.0, 0.0)) for two, three in shapes
    ]
    singular = np.linalg.svd(matrix_of(names, rows), compute_uv=False)
    rank = int((singular > 1e-9 * singular[0]).sum())
    condition = float(singular[0] / singular[-1]) if rank == len(names) else float("inf")
    return Observability(rank, len(names), condition)


def equation_of(configuration: Configuration) -> Row:
    """The thesis' equation at a row's angles, without c22 and the wrist, which it neglects."""
    angles = [radians(angle) for angle in configuration.angles_deg]
    row = gravity_row(configuration.joint, angles)
    if configuration.joint in (2, 3):
        row = {name: factor for name, factor in row.items() if name not in ("c50", "c22")}
    return {name: round(factor, 9) for name, factor in row.items() if abs(factor) > 1e-9}

"""Least squares with named unknowns: solution, deviations, condition."""

from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

import numpy as np

from rfms_can.analysis.cycles import Floats
from rfms_can.errors import RfmsError

RANK: Final = 1e-9
"""Singular value over the largest, columns scaled, below which a direction is unobservable."""


class IdentificationError(RfmsError):
    """The data do not determine the parameters."""


class Fit(NamedTuple):
    """A least-squares solution.

    Attributes:
        values, deviations: of the unknowns, by name; the latter one standard deviation.
        residual: of the equations, root mean square, in the units of their right sides.
        equations: their number.
        condition: of the matrix, its columns scaled to length 1.
    """

    values: dict[str, float]
    deviations: dict[str, float]
    residual: float
    equations: int
    condition: float


def solve(names: Sequence[str], matrix: Floats, right: Floats, what: str) -> Fit:
    """Solve ``matrix`` (n, k) times the unknowns called ``names`` (k) = ``right`` (n).

    Raises:
        IdentificationError: fewer equations than unknowns, or unobservable unknowns; the message
            names them.
    """
    count, unknowns = matrix.shape
    if count < unknowns:
        raise IdentificationError(f"{what}: {count} equations for {unknowns} unknowns")
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0.0] = 1.0
    left, singular, right_vectors = np.linalg.svd(matrix / scale, full_matrices=False)
    if singular[-1] <= RANK * singular[0]:
        unseen = np.abs(right_vectors[-1])
        involved = [name for name, weight in zip(names, unseen, strict=True) if weight > 0.1]
        raise IdentificationError(
            f"{what}: the data do not distinguish {', '.join(involved)}: "
            f"rank {int((singular > RANK * singular[0]).sum())} of {unknowns}"
        )
    solution = right_vectors.T @ ((left.T @ right) / singular) / scale
    errors = right - matrix @ solution
    variance = float(errors @ errors) / max(count - unknowns, 1)
    spread = np.sqrt(variance * ((right_vectors.T / singular) ** 2).sum(axis=1)) / scale
    return Fit(
        dict(zip(names, solution.tolist(), strict=True)),
        dict(zip(names, spread.tolist(), strict=True)),
        float(np.sqrt(np.mean(errors**2))),
        count,
        float(singular[0] / singular[-1]),
    )


def matrix_of(names: Sequence[str], rows: Sequence[Mapping[str, float]]) -> Floats:
    """Rows by name as a matrix; missing names are zero."""
    return np.array([[row.get(name, 0.0) for name in names] for row in rows], dtype=np.float64)

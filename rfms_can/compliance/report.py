"""Conflicts of a compliance specification at a pose: directions that are not independent."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rfms_can.compliance.projector import Projection
from rfms_can.compliance.selection import DIRECTIONS, Selection

Matrix = npt.NDArray[np.float64]

_NAMED = 0.4
"""Fraction of the largest component above which a direction is named."""


class Conflict(NamedTuple):
    """A compliant and a rigid direction that are not independent at this pose.

    Attributes:
        compliant: words of the directions that stay compliant.
        rigid: words of those whose position is not held.
        coupling: the cotangent that was damped; infinite at the singularity.
    """

    compliant: tuple[str, ...]
    rigid: tuple[str, ...]
    coupling: float

    def __str__(self) -> str:
        return (
            f"comply {' '.join(self.compliant)}: near a singularity {' '.join(self.rigid)} "
            f"cannot be held as well (coupling {self.coupling:.3g})"
        )


def conflicts(projection: Projection, J: Matrix, selection: Selection) -> tuple[Conflict, ...]:
    """The damped couplings of a projector in terms of the compliance frame.

    Args:
        projection: of ``hybrid_rows`` with this Jacobian and selection.
        J: (6, 6), Jacobian of the compliance frame.
        selection: what complies.
    """
    mask = selection.mask
    beyond = projection.couplings[len(projection.couplings) - len(projection.blocked) :]
    return tuple(
        Conflict(_words(J[mask], blocked, mask), _words(J[~mask], measured, ~mask), coupling)
        for coupling, blocked, measured in zip(
            beyond, projection.blocked, projection.measured, strict=True
        )
    )


def out_of_reach(
    J: Matrix, selection: Selection, length: float, bound: float = 0.01
) -> tuple[str, ...]:
    """Compliant directions in which the arm can hardly move: its structure takes a force there.

    Args:
        J: (6, 6), Jacobian of the compliance frame.
        selection: what complies.
        length: length equivalent of a radian, m; of the size of the arm's links.
        bound: smallest singular value of the compliant rows, lengths in ``length``.

    Returns:
        The words of the lost direction; empty without one.
    """
    mask = selection.mask
    if not mask.any():
        return ()
    scaled = (J / np.repeat([length, 1.0], 3)[:, np.newaxis])[mask]
    left, sizes, _ = np.linalg.svd(scaled)
    return _largest(left[:, -1], mask) if sizes[-1] < bound else ()


def _words(rows: Matrix, covector: Matrix, mask: npt.NDArray[np.bool_]) -> tuple[str, ...]:
    """The main directions of a row over joint angles, by their contributions to its length."""
    weights = np.linalg.lstsq(rows.T, covector, rcond=None)[0]
    return _largest(weights * np.linalg.norm(rows, axis=1), mask)


def _largest(weights: Matrix, mask: npt.NDArray[np.bool_]) -> tuple[str, ...]:
    names = [name for name, there in zip(DIRECTIONS, mask, strict=True) if there]
    sizes = np.abs(weights)
    return tuple(n for n, size in zip(names, sizes, strict=True) if size >= _NAMED * sizes.max())

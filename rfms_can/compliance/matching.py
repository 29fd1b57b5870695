"""Pairing of free joints with compliant directions (Paul and Shimano's free-joint method)."""

from itertools import permutations
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from rfms_can.compliance.selection import Selection

Matrix = npt.NDArray[np.float64]

_HELD: Final = 1e-3
"""Smallest singular value, of columns scaled to length 1, with which the remaining joints count as
able to hold the rigid directions."""


class Matching(NamedTuple):
    """The freed joints.

    Attributes:
        joints: indices (0 to 5), one for each compliant direction, in the order of S.
        abilities: fraction of the joint's motion along its direction, 0 to 1; 1 is a joint that
            moves only in this direction.
    """

    joints: tuple[int, ...]
    abilities: tuple[float, ...]


def match_joints(J: Matrix, selection: Selection, length: float) -> Matching:
    """Pair each compliant direction with the joint best able to provide it.

    The ability of joint j in direction i is |J_ij| over the length of column j, metres divided by
    ``length``. Of all pairings of the directions with joints (720 at most) the one with the
    largest sum of abilities is taken, the lowest joints where sums are equal; pairings whose
    remaining joints cannot hold the rigid directions come last. The thesis' "most closely" leaves
    the measure open; this one is ours.

    Match once for a segment: at another pose another pairing may win, and C_theta would jump.

    Args:
        J: (6, 6), Jacobian of the compliance frame.
        selection: what complies.
        length: length equivalent of a radian, m; of the size of the arm's links.
    """
    scaled = J / np.repeat([length, 1.0], 3)[:, np.newaxis]
    scaled = scaled / np.linalg.norm(scaled, axis=0)
    compliant = scaled[selection.mask]
    rigid = scaled[~selection.mask]
    directions = range(len(compliant))
    best: tuple[bool, float] | None = None
    found: tuple[int, ...] = ()
    for joints in permutations(range(6), len(compliant)):
        ability = float(sum(abs(compliant[i, joints[i]]) for i in directions))
        if best is not None and best[0] and ability <= best[1] + 1e-12:
            continue
        held = _smallest(np.delete(rigid, joints, axis=1)) > _HELD
        if best is None or (held, ability) > (best[0], best[1] + 1e-12):
            best, found = (held, ability), joints
    return Matching(found, tuple(float(abs(compliant[i, found[i]])) for i in directions))


def _smallest(square: Matrix) -> float:
    """Smallest singular value; 1 for an empty matrix."""
    return float(np.linalg.svd(square, compute_uv=False)[-1]) if square.size else 1.0

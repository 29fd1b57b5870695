"""How far a transition stays from the position it cuts the corner at.

For two straight segments with velocities v1 and v2 relative to that position, entered with the
same t_acc, the tool is there at p = 1/2 by 5/32 t_acc (v2 - v1): h t_seg of (3.15) is
5/32 t_acc then, and what remains of the old motion the same, by the symmetry of (3.15) and (3.18).
"""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from rfms_can.kinematics import Geometry, direct
from rfms_can.master.trajectory.planning.curve import Floats
from rfms_can.transform import DriveTransform, Transform

LEVER: Final = 1e-5
"""Metres a radian counts for, so that the nearest point of a mere turn is well defined."""

_NODES: Final = 8
_REFINED: Final = (1.0, 0.25, 0.05)
"""Steps, in samples, of the parabolas the nearest point is looked for with."""


class Deviation(NamedTuple):
    """Smallest distance from the via position, m, and the rotation to it there, rad."""

    distance: float
    rotation: float


def deviation(arm: Geometry, angles: Floats, left: Transform, right: Transform) -> Deviation:
    """Deviation from the goal T6 = ``left`` ``right`` of a transition with joint ``angles``.

    Args:
        arm: whose geometry it is.
        angles: at evenly spaced p, rad; shape (n, 6).
        left, right: what stands left and right of the goal's drive.
    """
    out, back = left.inverse(), right.inverse()

    def off(q: Sequence[float]) -> DriveTransform:
        q1, q2, q3, q4, q5, q6 = q
        return DriveTransform(out @ direct(arm, (q1, q2, q3, q4, q5, q6)) @ back)

    coarse = [_measure(off(q)) for q in angles.tolist()]
    nearest = float(np.argmin(coarse))
    for step in _REFINED:
        nearest = min(max(nearest, step), len(angles) - 1.0 - step)
        places = (nearest - step, nearest, nearest + step)
        before, here, after = (_measure(off(_interpolated(angles, place))) for place in places)
        bend = before - 2.0 * here + after
        if bend > 0.0:
            nearest += step * min(max(0.5 * (before - after) / bend, -1.0), 1.0)
    there = off(_interpolated(angles, nearest))
    return Deviation(sum(x * x for x in there.p) ** 0.5, there.psi)


def _measure(off: DriveTransform) -> float:
    return sum(x * x for x in off.p) + (LEVER * off.psi) ** 2


def _interpolated(angles: Floats, place: float) -> list[float]:
    """Angles between samples, by Lagrange's polynomial of the nearest ones."""
    first = min(max(int(place) - _NODES // 2 + 1, 0), len(angles) - _NODES)
    x = place - first
    nodes = np.arange(float(_NODES))
    weights = [
        np.prod([(x - other) / (node - other) for other in nodes if other != node])
        for node in nodes
    ]
    return list(np.array(weights) @ angles[first : first + _NODES])

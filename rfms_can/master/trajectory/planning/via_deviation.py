"""How far a transition stays from the position it cuts the corner at.

For two straight segments with velocities v1 and v2 relative to that position, entered with the
same t_acc, the tool is there at p = 1/2 by 5/32 t_acc (v2 - v1): h t_seg of (3.15) is
5/32 t_acc then, and what remains of the old motion the same, by the symmetry of (3.15) and (3.18).
"""

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from rfms_can.kinematics import Geometry, direct
from rfms_can.master.trajectory.planning.curve import Floats
from rfms_can.transform import DriveTransform, Transform

LEVER: Final = 1e-5
"""Metres a radian counts for, so that the nearest point of a mere turn is well defined."""

_INTERVALS: Final = 32
_EVERY: Final = 2
_NODES: Final = 8
_INVERSE_PRODUCTS: Final = [
    (-1.0) ** (_NODES - 1 - k) / (math.factorial(k) * math.factorial(_NODES - 1 - k))
    for k in range(_NODES)
]
_REFINED: Final = (2.0, 0.5, 0.1)
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

    def off(q: Sequence[float]) -> Transform:
        q1, q2, q3, q4, q5, q6 = q
        return out @ direct(arm, (q1, q2, q3, q4, q5, q6)) @ back

    angles = angles[:: max(1, (len(angles) - 1) // _INTERVALS)]
    coarse = [_measure(off(q)) for q in angles[::_EVERY].tolist()]
    nearest = float(_EVERY * np.argmin(coarse))
    for step in _REFINED:
        nearest = min(max(nearest, step), len(angles) - 1.0 - step)
        places = (nearest - step, nearest, nearest + step)
        before, here, after = (_measure(off(_interpolated(angles, place))) for place in places)
        bend = before - 2.0 * here + after
        if bend > 0.0:
            nearest += step * min(max(0.5 * (before - after) / bend, -1.0), 1.0)
    there = DriveTransform(off(_interpolated(angles, nearest)))
    return Deviation(sum(x * x for x in there.p) ** 0.5, there.psi)


def _measure(off: Transform) -> float:
    """Square of the distance, and a little of 2 (1 - cos psi)."""
    distance2 = off.px * off.px + off.py * off.py + off.pz * off.pz
    return distance2 + LEVER * LEVER * (3.0 - off.nx - off.oy - off.az)


def _interpolated(angles: Floats, place: float) -> list[float]:
    """Angles between samples, by Lagrange's polynomial of the nearest ones."""
    first = min(max(int(place) - _NODES // 2 + 1, 0), len(angles) - _NODES)
    x = place - first
    weights = []
    for node in range(_NODES):
        weight = _INVERSE_PRODUCTS[node]
        for other in range(_NODES):
            if other != node:
                weight *= x - other
        weights.append(weight)
    nearest: list[float] = (np.array(weights) @ angles[first : first + _NODES]).tolist()
    return nearest

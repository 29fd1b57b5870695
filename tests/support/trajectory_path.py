"""The path of a run: joint angles as functions of local time, and how far two paths are apart."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rfms_can.master.trajectory.states import Stage
from support.trajectory_rig import Rig

Floats = npt.NDArray[np.float64]
NODES = 8
"""Samples an angle between two samples is interpolated from."""


class Passage(NamedTuple):
    """From one hand-over to the next: local time, and six angles of each cycle."""

    n: Floats
    q: Floats


def passages(rig: Rig) -> list[Passage]:
    """The segments of a run, each with the transition into it; without cycles at rest."""
    found: list[tuple[list[float], list[list[float]]]] = []
    last, last_n = Stage.IDLE, 0.0
    for setpoint, stage, q in zip(rig.setpoints, rig.stages, rig.q, strict=True):
        if stage is not Stage.IDLE:
            begins = stage is Stage.CURVE and (last is not Stage.CURVE or setpoint.n < last_n)
            if stage is Stage.START or begins:
                found.append(([], []))
            found[-1][0].append(setpoint.n)
            found[-1][1].append(q)
        last, last_n = stage, setpoint.n
    return [Passage(np.array(n), np.array(q)) for n, q in found]


def interpolated(passage: Passage, n: Floats) -> Floats:
    """The angles at local times ``n``, by Lagrange's polynomial of the nearest samples."""
    first = np.clip(np.searchsorted(passage.n, n) - NODES // 2, 0, len(passage.n) - NODES)
    angles = np.zeros((len(n), 6))
    for row, (k, x) in enumerate(zip(first, n, strict=True)):
        nodes = passage.n[k : k + NODES]
        for i, node in enumerate(nodes):
            others = np.delete(nodes, i)
            angles[row] += np.prod((x - others) / (node - others)) * passage.q[k + i]
    return angles


def deviation(rig: Rig, nominal: Rig) -> float:
    """Largest distance, rad, between the angles of two runs at the same local times."""
    mine, reference = passages(rig), passages(nominal)
    assert len(mine) == len(reference)
    largest = 0.0
    for passage, whole in zip(mine, reference, strict=True):
        inside = (passage.n >= whole.n[0]) & (passage.n <= whole.n[-1])
        assert np.any(inside)
        apart = passage.q[inside] - interpolated(whole, passage.n[inside])
        largest = max(largest, float(np.max(np.abs(apart))))
    return largest

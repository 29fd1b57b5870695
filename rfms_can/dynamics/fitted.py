"""Constants of the simplified dynamics fitted to a full model over random poses."""

import random
from collections.abc import Sequence
from typing import Final

import numpy as np

from rfms_can.arm import Arm
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.dynamics.terms import (
    COUPLING,
    GRAVITY,
    INERTIA,
    Row,
    coupling_row,
    gravity_row,
    inertia_row,
)

POSES: Final = 300
SEED: Final = 1986


def random_poses(arm: Arm, count: int, seed: int) -> list[list[float]]:
    """``count`` poses (6, rad) inside the joint ranges."""
    draw = random.Random(seed)
    return [[draw.uniform(lower, upper) for lower, upper in arm.joint_limits] for _ in range(count)]


def fitted_constants(dynamics: ArmDynamics) -> dict[str, float]:
    """Least-squares fit of the constants (``dynamics/terms.py``) to a full model."""
    poses = random_poses(dynamics.arm, POSES, SEED)
    states = []
    for q in poses:
        dynamics.update(q)
        states.append((q, dynamics.M, dynamics.g))
    constants: dict[str, float] = {}
    constants.update(
        _fit(
            GRAVITY,
            [(gravity_row(joint, q), g[joint - 1]) for q, _, g in states for joint in (2, 3, 4, 5)],
        )
    )
    for joint in range(1, 7):
        names = tuple(name for name in INERTIA if name[1] == str(joint))
        i = joint - 1
        constants.update(_fit(names, [(inertia_row(joint, q), M[i, i]) for q, M, _ in states]))
    constants.update(_fit(COUPLING, [(coupling_row(q), M[1, 2]) for q, M, _ in states]))
    return constants


def _fit(names: Sequence[str], equations: Sequence[tuple[Row, float]]) -> dict[str, float]:
    matrix = np.array([[row.get(name, 0.0) for name in names] for row, _ in equations])
    right = np.array([value for _, value in equations])
    solution = np.linalg.lstsq(matrix, right, rcond=None)[0]
    return dict(zip(names, solution.tolist(), strict=True))

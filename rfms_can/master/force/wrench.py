"""Forces between frames, and the weight of what the hand holds. Wrenches: N, N m, linear first."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from rfms_can.dynamics import GRAVITY
from rfms_can.master.force.specification import Load
from rfms_can.messages import Vector6
from rfms_can.transform import Transform

Matrix = npt.NDArray[np.float64]


def in_frame(wrench: Sequence[float], E: Transform) -> Vector6:
    """A wrench at T6, along its axes, as one at the origin of frame E along E's axes (2.20)."""
    fx, fy, fz, mx, my, mz = wrench
    nx, ox, ax, px, ny, oy, ay, py, nz, oz, az, pz = E
    mx, my, mz = mx - (py * fz - pz * fy), my - (pz * fx - px * fz), mz - (px * fy - py * fx)
    return (
        nx * fx + ny * fy + nz * fz,
        ox * fx + oy * fy + oz * fz,
        ax * fx + ay * fy + az * fz,
        nx * mx + ny * my + nz * mz,
        ox * mx + oy * my + oz * mz,
        ax * mx + ay * my + az * mz,
    )


def weight(load: Load, T6: Transform) -> Vector6:
    """What gravity does to a load, as a wrench at T6 along its axes."""
    pull = -load.mass * GRAVITY
    x, y, z = T6.nz * pull, T6.oz * pull, T6.az * pull
    cx, cy, cz = load.centre
    return (x, y, z, cy * z - cz * y, cz * x - cx * z, cx * y - cy * x)


def load_rows(load: Load, J: Matrix, T6: Transform) -> tuple[Matrix, Matrix]:
    """What a load adds to the inertia matrix, (6, 6), kg m2, and to gravity, (6,), Nm.

    A point mass at its centre: what turns about it is the tool's own small inertia.

    Args:
        load: what the hand holds.
        J: (6, 6), Jacobian in the T6 frame at its origin.
        T6: pose of the hand.
    """
    cx, cy, cz = load.centre
    turns = np.array([[0.0, cz, -cy], [-cz, 0.0, cx], [cy, -cx, 0.0]])
    at_centre = J[:3] + turns @ J[3:]
    up = load.mass * GRAVITY * np.array([T6.nz, T6.oz, T6.az])
    return load.mass * (at_centre.T @ at_centre), at_centre.T @ up

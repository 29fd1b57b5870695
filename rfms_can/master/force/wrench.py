"""Forces between frames, and the weight of what the hand holds. Wrenches: N, N m, linear first."""

from collections.abc import Sequence

from rfms_can.arm import Load
from rfms_can.dynamics.rigid_body import GRAVITY
from rfms_can.messages import Vector6
from rfms_can.transform import Transform


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
    cx, cy, cz = load.com
    return (x, y, z, cy * z - cz * y, cz * x - cx * z, cx * y - cy * x)

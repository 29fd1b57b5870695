"""Differential motion and forces between frames (thesis sections II.4 and II.5, as corrected).

Six-vectors have the linear part first: velocities (vx, vy, vz, wx, wy, wz) of (2.10), differential
changes (dx, dy, dz, rx, ry, rz) of (2.15), forces (fx, fy, fz, mx, my, mz) of (2.19).
"""

from rfms_can.transform.homogeneous import Transform

Vector6 = tuple[float, float, float, float, float, float]
Vector4 = tuple[float, float, float, float]
Matrix4 = tuple[Vector4, Vector4, Vector4, Vector4]
Matrix6 = tuple[Vector6, Vector6, Vector6, Vector6, Vector6, Vector6]


def differential_transform(transform: Transform) -> Matrix6:
    """The matrix X of (2.11): transforms a velocity of the outer frame into the inner one.

    Its transpose transforms a force of the inner frame into the outer one, F = X^T (cF) (2.20),
    since the virtual work is the same in both.

    Returns:
        Six rows of six; [R^T, -R^T p^; 0, R^T], p^ the cross-product matrix of p (metres).
    """
    nx, ox, ax, px, ny, oy, ay, py, nz, oz, az, pz = transform
    zero = 0.0
    return (
        (nx, ny, nz, py * nz - pz * ny, pz * nx - px * nz, px * ny - py * nx),
        (ox, oy, oz, py * oz - pz * oy, pz * ox - px * oz, px * oy - py * ox),
        (ax, ay, az, py * az - pz * ay, pz * ax - px * az, px * ay - py * ax),
        (zero, zero, zero, nx, ny, nz),
        (zero, zero, zero, ox, oy, oz),
        (zero, zero, zero, ax, ay, az),
    )


def differential_operator(change: Vector6) -> Matrix4:
    """Delta of (2.16), its last element 0 instead of the printed 1, so that Delta T = T (T^Delta).

    Changes add: a sequence of small ones is the product of (I + Delta_i), to first order
    I + sum Delta_i, and not the product of the Deltas printed as (2.18).
    """
    dx, dy, dz, rx, ry, rz = change
    return (
        (0.0, -rz, ry, dx),
        (rz, 0.0, -rx, dy),
        (-ry, rx, 0.0, dz),
        (0.0, 0.0, 0.0, 0.0),
    )

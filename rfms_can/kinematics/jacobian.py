"""The Jacobian in the T6 frame and its partitioned inverse (A.22 to A.30, with a3).

The thesis' second and third columns belong to theta2 and theta23 = theta2 + theta3. Here columns
belong to theta1 to theta6: J = J' E, E = I + e3 e2^T, so column 2 includes the theta23 column, and
in the inverse row 2 is subtracted from row 3.

Plain floats: for an array, ``numpy.array`` of the six tuples is the fastest conversion.
"""

import math
from collections.abc import Sequence

from rfms_can.kinematics.geometry import Geometry
from rfms_can.kinematics.singularity import require_regular
from rfms_can.transform import Matrix6, Vector3, Vector6


def jacobian(arm: Geometry, q: Sequence[float]) -> Matrix6:
    """d(velocity of T6, in T6 axes) / d(theta1 .. theta6) at ``q``, radians.

    Returns:
        Six rows: vx, vy, vz (metres per radian), wx, wy, wz (1), each of six columns.
    """
    (ax, ay, az), (bx, by, bz), (cx, cy, cz), (ux, uy, uz), (wx, wy, wz) = _arm_columns(arm, q)
    s5, c5, s6, c6 = math.sin(q[4]), math.cos(q[4]), math.sin(q[5]), math.cos(q[5])
    return (
        (ax, bx + cx, cx, 0.0, 0.0, 0.0),
        (ay, by + cy, cy, 0.0, 0.0, 0.0),
        (az, bz + cz, cz, 0.0, 0.0, 0.0),
        (ux, wx, wx, s5 * c6, -s6, 0.0),
        (uy, wy, wy, -s5 * s6, -c6, 0.0),
        (uz, wz, wz, c5, 0.0, 1.0),
    )


def inverse_jacobian(arm: Geometry, q: Sequence[float]) -> Matrix6:
    """The inverse of ``jacobian`` by partition (A.27): rows theta1 .. theta6.

    Raises:
        SingularityError: elbow, shoulder or wrist are singular at ``q``.
    """
    require_regular(arm, q)
    a, b, c, u, w = _arm_columns(arm, q)
    bc, ca, ab = _cross(b, c), _cross(c, a), _cross(a, b)
    k = 1.0 / (a[0] * bc[0] + a[1] * bc[1] + a[2] * bc[2])  # (A.30)
    x1, y1, z1 = k * bc[0], k * bc[1], k * bc[2]
    x2, y2, z2 = k * ca[0], k * ca[1], k * ca[2]
    x23, y23, z23 = k * ab[0], k * ab[1], k * ab[2]

    def wrist_row(x: float, y: float, z: float) -> Vector6:
        """A row of J22^-1 with its row of -J22^-1 J21 J11^-1 before it."""
        by_1 = x * u[0] + y * u[1] + z * u[2]
        by_23 = x * w[0] + y * w[1] + z * w[2]
        return (
            *(-by_1 * x1 - by_23 * x23, -by_1 * y1 - by_23 * y23, -by_1 * z1 - by_23 * z23),
            *(x, y, z),
        )

    s5, c5, s6, c6 = math.sin(q[4]), math.cos(q[4]), math.sin(q[5]), math.cos(q[5])
    return (
        (x1, y1, z1, 0.0, 0.0, 0.0),
        (x2, y2, z2, 0.0, 0.0, 0.0),
        (x23 - x2, y23 - y2, z23 - z2, 0.0, 0.0, 0.0),
        wrist_row(c6 / s5, -s6 / s5, 0.0),  # (A.28)
        wrist_row(-s6, -c6, 0.0),
        wrist_row(-c5 * c6 / s5, c5 * s6 / s5, 1.0),
    )


def _arm_columns(
    arm: Geometry, q: Sequence[float]
) -> tuple[Vector3, Vector3, Vector3, Vector3, Vector3]:
    """Linear columns of theta1, theta2, theta23 and angular ones of theta1, theta23 (A.24, A.25).

    theta2 rotates no frame while theta23 is constant: its angular column is zero.
    """
    sin, cos = math.sin, math.cos
    _, q2, q3, q4, q5, q6 = q
    s3, c3, s23, c23 = sin(q3), cos(q3), sin(q2 + q3), cos(q2 + q3)
    s4, c4, s5, c5, s6, c6 = sin(q4), cos(q4), sin(q5), cos(q5), sin(q6), cos(q6)
    a2, a3, d4, d = arm.a2, arm.a3, arm.d4, arm.shoulder_offset
    u511, u512, u521, u522 = c5 * c6, -c5 * s6, s5 * c6, -s5 * s6
    u411, u421 = c4 * u511 - s4 * s6, s4 * u511 + c4 * s6
    u412, u422 = c4 * u512 - s4 * c6, s4 * u512 + c4 * c6
    u413, u423 = -c4 * s5, -s4 * s5
    u211, u221 = c23 * u411 - s23 * u521, s23 * u411 + c23 * u521
    u212, u222 = c23 * u412 - s23 * u522, s23 * u412 + c23 * u522
    u213, u223 = c23 * u413 - s23 * c5, s23 * u413 + c23 * c5
    u214 = a2 * cos(q2) + a3 * c23 - d4 * s23
    return (
        (u211 * d + u421 * u214, u212 * d + u422 * u214, u213 * d + u423 * u214),
        (
            a2 * (s3 * u411 + c3 * u521),
            a2 * (s3 * u412 + c3 * u522),
            a2 * (s3 * u413 + c3 * c5),
        ),
        (a3 * u521 - d4 * u411, a3 * u522 - d4 * u412, a3 * c5 - d4 * u413),
        (u221, u222, u223),
        (-u421, -u422, -u423),
    )


def _cross(a: Vector3, b: Vector3) -> Vector3:
    ax, ay, az = a
    bx, by, bz = b
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx

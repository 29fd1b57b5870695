"""The Jacobian of the compliance frame, in whose origin and axes the arm complies."""

import numpy as np
import numpy.typing as npt

from rfms_can.errors import TransformError
from rfms_can.transform import RIGID_TOLERANCE, Transform, differential_transform

Matrix = npt.NDArray[np.float64]


def compliance_jacobian(J: Matrix, frame: Transform) -> Matrix:
    """Joint rates to velocities of the compliance frame, at its origin and along its axes.

    A velocity of T6 becomes one of the frame by the matrix of (2.11); the frame rides on T6.

    Args:
        J: (6, 6), Jacobian in the T6 frame at its origin.
        frame: pose of the compliance frame in T6.

    Returns:
        (6, 6): rows vx vy vz (m) wx wy wz (rad) per radian of theta1 .. theta6.

    Raises:
        TransformError: ``frame`` is not rigid.
    """
    deviation = frame.rigidity_error()
    if not deviation <= RIGID_TOLERANCE:
        raise TransformError(
            f"compliance frame {tuple(frame)} is not rigid: n, o, a deviate by {deviation:.3g} "
            f"from a right-handed orthonormal set, {RIGID_TOLERANCE:g} at most"
        )
    product: Matrix = np.array(differential_transform(frame)) @ J
    return product

"""Raibert and Craig's hybrid control: the error computed between poses (5.7, 5.8).

Their law is tau = K_theta J^-1 (I-S) dx with dx from the desired and the actual pose; ours puts
J dtheta for dx. Both have the same Jacobian and so the same rows, poles and behaviour for small
errors. The difference is of second order in the error: dx - J dtheta. The nodes exchange only joint
errors, so the master, which knows both poses, computes it and sends it as bias torque, one period
late; it is zero where the arm is on its set-point.
"""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from rfms_can.arm import Arm
from rfms_can.kinematics import direct
from rfms_can.transform import Transform, motion_of

Matrix = npt.NDArray[np.float64]


def cartesian_error(desired: Transform, actual: Transform, frame: Transform) -> Matrix:
    """Displacement of the compliance frame from its actual to its desired pose.

    Args:
        desired, actual: T6, set-point and from the encoders.
        frame: pose of the compliance frame in T6.

    Returns:
        (6,): displacement, m, and rotation vector, rad, in the actual compliance frame.
    """
    return np.array(motion_of((actual @ frame).inverse() @ (desired @ frame)))


def cartesian_part(J: Matrix, C: Matrix, dx: Matrix, errors: Matrix) -> Matrix:
    """J^-1 (I-S) dx less C dtheta: Raibert and Craig's real error less ours.

    Written C J^+ (dx - J dtheta), so that the bounded C bounds it too. Multiplied by the nodes'
    K_p it is the bias torque that turns our law into theirs.

    Args:
        J: (6, 6), Jacobian of the compliance frame at the actual angles.
        C: (6, 6), rows of ``hybrid_rows``.
        dx: (6,), of ``cartesian_error``.
        errors: (6,), joint errors, rad.

    Returns:
        (6,), rad; of second order in the errors.
    """
    missed = dx - J @ errors
    part: Matrix = C @ np.linalg.lstsq(J, missed, rcond=1e-6)[0]
    return part


def pose_error_correction(
    arm: Arm, q: Sequence[float], errors: Sequence[float], frame: Transform, J: Matrix, C: Matrix
) -> Matrix:
    """``cartesian_part`` at measured joint angles and the joint errors there.

    Args:
        arm: the arm.
        q: measured joint angles, rad.
        errors: joint errors, rad.
        frame: pose of the compliance frame in T6.
        J: (6, 6), Jacobian of the compliance frame at ``q``.
        C: (6, 6), rows of ``hybrid_rows``.

    Returns:
        (6,), rad.
    """
    desired = direct(arm, [a + e for a, e in zip(q, errors, strict=True)])
    dx = cartesian_error(desired, direct(arm, q), frame)
    return cartesian_part(J, C, dx, np.asarray(errors))

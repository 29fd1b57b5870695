"""The nearest pose at which the Jacobian can be inverted."""

import math
from collections.abc import Sequence

from rfms_can.kinematics import REGULAR_BOUNDS, singularity_margins
from rfms_can.kinematics.geometry import Geometry, Joints


def regular_pose(arm: Geometry, q: Sequence[float]) -> Joints:
    """``q``, with joints 2, 3 and 5 moved by the least angles that keep all singularity bounds.

    At a singular pose the directions in joint space that C_theta separates are numerically
    undefined, though they have a limit along any path through it. At a distance of a millionth they
    are known to ten digits. A regular ``q`` is returned unchanged.

    Args:
        arm: its lengths.
        q: six joint angles, rad.
    """
    q1, q2, q3, q4, q5, q6 = q
    margins, bounds = singularity_margins(arm, q), REGULAR_BOUNDS
    if abs(margins.elbow) < bounds.elbow:
        slope = (arm.a3 * math.cos(q3) - arm.d4 * math.sin(q3)) / math.hypot(arm.a3, arm.d4)
        q3 += _step(margins.elbow, bounds.elbow, slope)
        margins = singularity_margins(arm, (q1, q2, q3, q4, q5, q6))
    if abs(margins.shoulder) < bounds.shoulder:
        s23, c23 = math.sin(q2 + q3), math.cos(q2 + q3)
        slope = -arm.a2 * math.sin(q2) - arm.a3 * s23 - arm.d4 * c23
        q2 += _step(margins.shoulder, bounds.shoulder, slope)
    if abs(margins.wrist) < bounds.wrist:
        q5 += _step(margins.wrist, bounds.wrist, math.cos(q5))
    return q1, q2, q3, q4, q5, q6


def _step(margin: float, bound: float, slope: float) -> float:
    """Angle that increases a small margin to its bound, with the same sign."""
    return (math.copysign(bound, margin) - margin) / slope

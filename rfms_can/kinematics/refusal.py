"""Why a pose has no solution: reason, number and bound."""

import math

from rfms_can.errors import JointLimitError, KinematicsError, UnreachableError
from rfms_can.kinematics.closed_form import ClosedForm
from rfms_can.kinematics.geometry import Geometry
from rfms_can.transform import Transform


def reach_error(arm: Geometry, t6: Transform, form: ClosedForm) -> KinematicsError | None:
    """Why the wrist centre of ``t6`` cannot be reached, in any configuration; None if it can.

    The message opens with the reason: shoulder_cylinder, shoulder_point, too_near or too_far.
    """
    if not math.isfinite(sum(t6)):
        return KinematicsError(f"{arm.name}: T6 {tuple(t6)} has elements that are not finite")
    v114 = form.v114(t6, True)
    if math.isnan(v114):
        return UnreachableError(
            f"{arm.name}: shoulder_cylinder: hypot(px, py) = {math.hypot(t6.px, t6.py):.9g} m is "
            f"inside the shoulder offset {abs(form.offset):.9g} m: move T6 away from the base axis"
        )
    rho2 = v114 * v114 + t6.pz * t6.pz
    rho = math.sqrt(rho2)
    if rho2 > form.rho_max_squared:
        return UnreachableError(
            f"{arm.name}: too_far: the wrist centre is {rho:.9g} m from the shoulder, "
            f"reach is {math.sqrt(form.farthest_squared):.9g} m: bring T6 nearer"
        )
    if rho2 < form.rho_min_squared:
        nearest = math.sqrt(form.nearest_squared)
        bound = math.sqrt(form.rho_min_squared)
        reason = "too_near" if nearest > bound else "shoulder_point"
        return UnreachableError(
            f"{arm.name}: {reason}: the wrist centre is {rho:.3g} m from the shoulder, "
            f"nearest is {max(nearest, bound):.3g} m: move T6 away from the shoulder"
        )
    return None


def limit_error(arm: Geometry, joint: int, angle: float) -> JointLimitError:
    """No turn of ``angle`` (radians) lies in the range of ``joint`` (1 to 6)."""
    lower, upper = arm.joint_limits[joint - 1]
    angle = math.remainder(angle, math.tau)
    degrees = math.degrees
    return JointLimitError(
        f"{arm.name}: joint {joint} would have to be at {angle:.6g} rad "
        f"({degrees(angle):.4g} deg, or a whole turn from there), outside "
        f"[{lower:.6g}, {upper:.6g}] rad ([{degrees(lower):.4g}, {degrees(upper):.4g}] deg): "
        f"try another configuration"
    )

"""Selection of the whole turn of an angle: the one nearest to the joint, inside its range."""

import math
from collections.abc import Sequence
from typing import Final

from rfms_can.kinematics.geometry import Geometry

PI: Final = math.pi
TURN: Final = math.tau


def nearest_turn(angle: float, previous: float, lower: float, upper: float) -> float:
    """``angle`` plus the whole turns that bring it closest to ``previous`` inside the range.

    A solution is an angle modulo a turn, a joint is not: joints 4 and 6 turn by more than a
    revolution, and the previous set-point says where they are. If the nearest turn is outside the
    range, the nearest inside is taken: a joint motion unwinds to it; in a Cartesian motion it is a
    step that the speed limit refuses. Radians.

    Returns:
        The angle, or NaN if no turn of it lies in the range or an argument is not finite.
    """
    ahead = angle - previous
    if -PI <= ahead <= PI and lower <= angle <= upper:
        return angle
    if not -math.inf < ahead < math.inf:
        return math.nan
    angle -= TURN * round(ahead / TURN)
    if angle > upper:
        angle -= TURN * math.ceil((angle - upper) / TURN)
    elif angle < lower:
        angle += TURN * math.ceil((lower - angle) / TURN)
    return angle if lower <= angle <= upper else math.nan


def within_limits(arm: Geometry, q: Sequence[float]) -> tuple[bool, ...]:
    """For each joint, whether its angle (radians, not reduced) is inside its range."""
    return tuple(
        lower <= angle <= upper for angle, (lower, upper) in zip(q, arm.joint_limits, strict=True)
    )

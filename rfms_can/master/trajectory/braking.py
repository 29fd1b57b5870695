"""A stop in joint angles: where a path cannot be followed, the arm comes to rest beside it.

Every joint slows down at a constant rate within its acceleration limit. All take the time of the
one that needs longest, so that the arm goes on in the direction it had, as far as it goes; a joint
that would leave its range meanwhile brakes harder.
"""

import math
from collections.abc import Sequence
from typing import Final

from rfms_can.kinematics import Geometry, Joints, configuration_of, direct
from rfms_can.setpoint import CartesianSetpoint
from rfms_can.wire.vocabulary import Blend, Mode, TrajectoryState

STOPPING_FRACTION: Final = 0.5
"""Part of its acceleration limit at which a joint's node stops it (ACCELERATION_LIMIT there)."""
STANDS: Final = 1e-12
"""A joint whose step is less, rad, has come to rest."""


class Brake:
    """Brings six joints to rest.

    Args:
        arm: its geometry and ranges.
        theta: set-points of the last cycle, rad (6).
        steps: what they moved in it, rad (6).
        limits: acceleration of each joint, rad a cycle squared.

    Attributes:
        over: whether all joints rest.
    """

    __slots__ = ("_arm", "_slower", "_steps", "_theta", "over")

    def __init__(
        self,
        arm: Geometry,
        theta: Sequence[float],
        steps: Sequence[float],
        limits: Sequence[float],
    ) -> None:
        self._arm = arm
        self._theta = list(theta)
        self._steps = list(steps)
        cycles = max(1.0, *(abs(step) / limit for step, limit in zip(steps, limits, strict=True)))
        self._slower = [
            _deceleration(angle, step, limit, cycles, bounds)
            for angle, step, limit, bounds in zip(
                theta, steps, limits, arm.joint_limits, strict=True
            )
        ]
        self.over = not any(abs(step) > STANDS for step in steps)

    def step(self) -> Joints:
        """The angles of the next cycle, rad."""
        steps, theta = self._steps, self._theta
        for k, slower in enumerate(self._slower):
            step = steps[k]
            steps[k] = math.copysign(max(0.0, abs(step) - slower), step)
            lower, upper = self._arm.joint_limits[k]
            theta[k] = min(max(theta[k] + steps[k], lower), upper)
        self.over = not any(abs(step) > STANDS for step in steps)
        q1, q2, q3, q4, q5, q6 = theta
        return (q1, q2, q3, q4, q5, q6)

    def setpoint(self, theta: Joints, sequence: int, blend: Blend) -> CartesianSetpoint:
        """Angles (rad) as a set-point: to the joints, one of a Cartesian transition."""
        configuration = configuration_of(self._arm, theta)
        return CartesianSetpoint(
            TrajectoryState.LINEAR,
            Mode.CARTESIAN,
            blend,
            1.0,
            1.0,
            1.0,
            direct(self._arm, theta),
            configuration,
            None,
            configuration,
            sequence=sequence,
            near_1=theta,
        )


def _deceleration(
    angle: float, step: float, limit: float, cycles: float, bounds: tuple[float, float]
) -> float:
    """Of one joint, rad a cycle squared: to rest in ``cycles``, or in its range if that is less."""
    room = max(0.0, bounds[1] - angle if step > 0.0 else angle - bounds[0])
    slower = abs(step) / cycles
    if abs(step) * (cycles - 1.0) / 2.0 > room:
        slower = step * step / (2.0 * room + abs(step))
    return min(limit, max(slower, STANDS))

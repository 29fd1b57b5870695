"""The controlled stop of one joint (R2): from its motion to rest, then hold."""

import math
from collections.abc import Mapping
from typing import Final

from rfms_can.joint_nodes.detectors.setpoint_step import STEP_MARGIN
from rfms_can.wire.vocabulary import Parameter

STILL_CYCLES: Final = 12
"""Cycles without an encoder count that mean a joint has come to rest."""
SETTLING_S: Final = 0.5
"""Time after the ramp in which a joint may choose where it rests."""


STEP_FRACTION: Final = 0.25
"""How far from the joint a controlled stop may begin, over the largest step of a set-point."""


class StopRamp:
    """Constant deceleration from a position and speed to rest.

    Args:
        position: commanded position when the stop begins, rad.
        speed: commanded speed then, rad/s.
        deceleration: rad/s2, positive.
        period: control period, s.

    Attributes:
        position, speed, acceleration: commanded now; speed 0 once at rest.
    """

    __slots__ = (
        "_angle",
        "_deceleration",
        "_period",
        "_settling",
        "_still",
        "acceleration",
        "position",
        "speed",
    )

    def __init__(self, position: float, speed: float, deceleration: float, period: float) -> None:
        self.position = position
        self.speed = speed
        self.acceleration = 0.0
        self._deceleration = deceleration
        self._angle = position
        self._still = 0
        self._settling = round(SETTLING_S / period)
        self._period = period

    def watch(self, angle: float) -> None:
        """Take the measured angle, rad; hold where the joint comes to rest after the ramp.

        A stopped joint has no goal but to stand still: driving it to the end of the ramp would
        move it once more. After ``SETTLING_S`` the position is fixed: it does not yield.
        """
        if self.speed or self._settling <= 0:
            return
        self._settling -= 1
        self._still = self._still + 1 if angle == self._angle else 0
        self._angle = angle
        if self._still >= STILL_CYCLES:
            self.position = angle

    def step(self) -> None:
        """Advance one control period."""
        before, change = self.speed, self._deceleration * self._period
        if abs(before) <= change:
            self.speed = 0.0
        else:
            self.speed = before - change if before > 0.0 else before + change
        self.acceleration = (self.speed - before) / self._period
        self.position += 0.5 * (before + self.speed) * self._period


class StopPlan:
    """Plans the controlled stops of one joint: inside its range, never faster than it was.

    Args:
        parameters: the node's configuration.
    """

    __slots__ = ("_acceleration", "_count", "_far", "_fastest", "_lower", "_period", "_upper")

    def __init__(self, parameters: Mapping[Parameter, float]) -> None:
        p = parameters
        self._period: Final = p[Parameter.PERIOD]
        self._fastest: Final = p[Parameter.SPEED_LIMIT]
        self._acceleration: Final = p[Parameter.ACCELERATION_LIMIT]
        self._lower: Final = p[Parameter.POSITION_MIN]
        self._upper: Final = p[Parameter.POSITION_MAX]
        self._count: Final = 1.0 / abs(p[Parameter.COUNTS_PER_UNIT])
        self._far: Final = STEP_FRACTION * STEP_MARGIN * self._fastest * self._period

    def ramp(self, theta: float, measured: float, position: float, rate: float) -> StopRamp:
        """The ramp of a stop that begins now.

        It begins at the joint, not faster than it moves or was told to, and ends inside the range,
        by braking harder if it must.

        Args:
            theta, measured: where the joint is, rad, and how fast, rad/s.
            position, rate: what is commanded, rad and rad/s.
        """
        speed = 0.0
        if rate * measured > 0.0:
            speed = math.copysign(min(abs(rate), abs(measured), self._fastest), rate)
        far = self._far
        position = theta + max(-far, min(far, position - theta))
        end = self._upper if speed > 0.0 else self._lower
        room = max(abs(end - position), self._count)
        deceleration = max(self._acceleration, speed * speed / (2.0 * room))
        return StopRamp(position, speed, deceleration, self._period)

"""Homing of one joint: move slowly towards the middle of the range until the index pulse comes.

Encoder and coarse position must agree on the way. Where they do not (an encoder with its channels
exchanged turns the servo into one that drives away), homing ends before the joint has gone far.
"""

from collections.abc import Mapping
from typing import Final

from rfms_can.joint_nodes.servo import Servo
from rfms_can.node.encoder import EncoderReference
from rfms_can.wire.records import Measure, Reference
from rfms_can.wire.vocabulary import Parameter

DISAGREEMENT: Final = 0.25
"""Index intervals by which the ways of encoder and coarse position may differ."""


class Homing:
    """Drives one joint to its index; afterwards holds it where it stopped.

    Args:
        parameters: the node's configuration.
        encoder: becomes referenced.
        servo: the joint's servo; its integral is used.

    Attributes:
        found: None while looking, True when referenced, False when index, encoder and coarse
            position do not agree.
    """

    __slots__ = (
        "_apart",
        "_disagreement",
        "_encoder",
        "_middle",
        "_period",
        "_servo",
        "_speed",
        "_target",
        "found",
    )

    def __init__(
        self, parameters: Mapping[Parameter, float], encoder: EncoderReference, servo: Servo
    ) -> None:
        self._encoder = encoder
        self._servo = servo
        self._period = parameters[Parameter.PERIOD]
        self._speed = parameters[Parameter.HOMING_SPEED]
        self._middle = 0.5 * (
            parameters[Parameter.POSITION_MIN] + parameters[Parameter.POSITION_MAX]
        )
        interval = parameters[Parameter.INDEX_INTERVAL_COUNTS]
        self._disagreement = DISAGREEMENT * interval / abs(parameters[Parameter.COUNTS_PER_UNIT])
        self.begin()

    def begin(self) -> None:
        """Start looking; a joint that knows its reference has found it already."""
        self._target: float | None = None
        self._apart: float | None = None
        self.found: bool | None = None if self._encoder.zero_counts is None else True

    def step(self, measure: Measure, reference: Reference, speed: float, gravity: float) -> float:
        """One cycle: the torque to move or hold with, Nm."""
        encoder = self._encoder
        angle = encoder.angle(measure.counts)
        if self._target is None:
            self._target = angle
        self._compare(encoder.coarse_angle(reference.coarse_adc) - angle)
        rate = 0.0
        if self.found is None:
            before = encoder.angle(measure.counts)
            self.found = encoder.find(measure, reference)
            angle = encoder.angle(measure.counts)
            self._target += angle - before  # the same place in the frame just found
            if self._apart is not None:
                self._apart -= angle - before
        if self.found is None:
            below = encoder.coarse_angle(reference.coarse_adc) < self._middle
            rate = self._speed if below else -self._speed
            self._target += rate * self._period
        feedforward = gravity + self._servo.friction.rigid(rate)
        return self._servo.alone(self._target - angle, rate - speed, feedforward)

    def _compare(self, apart: float) -> None:
        """Coarse angle less encoder's, rad: it stays what it was, up to the coarse one's errors."""
        if self._apart is None:
            self._apart = apart
        elif abs(apart - self._apart) > self._disagreement:
            self.found = False

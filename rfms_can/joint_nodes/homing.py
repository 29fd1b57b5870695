"""Homing of one joint: move slowly towards the middle of the range until the index pulse comes.

Encoder and coarse position must agree during the motion. Where they do not (an encoder with its
channels exchanged makes the servo drive away from its goal), homing ends before the joint has gone
far.
"""

from collections.abc import Mapping
from typing import Final

from rfms_can.joint_nodes.servo import Servo
from rfms_can.node.encoder_reference import EncoderReference
from rfms_can.wire.records import Measure, Reference
from rfms_can.wire.vocabulary import Parameter

MAX_DISAGREEMENT: Final = 0.25
"""Index intervals by which the displacements of encoder and coarse position may differ."""


class Homing:
    """Drives one joint to its index; afterwards holds it where it stopped.

    Args:
        parameters: the node's configuration.
        encoder: becomes referenced.
        servo: the joint's servo; its integral is used.

    Attributes:
        found: None while searching, True when referenced, False when index, encoder and coarse
            position do not agree.
    """

    __slots__ = (
        "_encoder",
        "_max_disagreement",
        "_middle",
        "_offset",
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
        self._max_disagreement = (
            MAX_DISAGREEMENT * interval / abs(parameters[Parameter.COUNTS_PER_UNIT])
        )
        self.begin()

    def begin(self) -> None:
        """Start the search; a joint that knows its reference has ended it already."""
        self._target: float | None = None
        self._offset: float | None = None
        self.found: bool | None = None if self._encoder.zero_counts is None else True

    def step(self, measure: Measure, reference: Reference, speed: float, gravity: float) -> float:
        """One cycle: the torque to move or hold with, Nm; ``speed`` rad/s, ``gravity`` Nm."""
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
            if self._offset is not None:
                self._offset -= angle - before
        if self.found is None:
            below = encoder.coarse_angle(reference.coarse_adc) < self._middle
            rate = self._speed if below else -self._speed
            self._target += rate * self._period
        friction = self._servo.friction.rigid(rate)
        return self._servo.alone(self._target - angle, rate - speed, gravity, friction)

    def _compare(self, offset: float) -> None:
        """Coarse angle less the encoder's, rad: constant, up to the errors of the coarse one."""
        if self._offset is None:
            self._offset = offset
        elif abs(offset - self._offset) > self._max_disagreement:
            self.found = False

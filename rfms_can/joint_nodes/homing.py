"""Homing of one joint: move slowly towards the middle of the range until the index pulse comes.

Encoder and coarse position must agree during the motion. Where they do not (an encoder with its
channels exchanged makes the servo drive away from its goal), homing ends before the joint has gone
far. It ends as well where the encoder does not count although the whole torque is on, and where no
index has come in ``HOMING_TIME``.
"""

import math
from collections.abc import Mapping
from typing import Final, NamedTuple

from rfms_can.joint_nodes.servo import Servo
from rfms_can.node.encoder_reference import AMBIGUITY, EncoderReference
from rfms_can.wire.records import Measure, Reference
from rfms_can.wire.vocabulary import Parameter

MAX_DISAGREEMENT: Final = 0.25
"""Index intervals by which the displacements of encoder and coarse position may differ."""


class HomingFailure(NamedTuple):
    """Why homing has failed.

    Attributes:
        record: the message that shows it.
        value: what broke the bound.
        bound: the bound, in the same unit.
    """

    record: type[Measure] | type[Reference]
    value: float
    bound: float


class Homing:
    """Drives one joint to its index; afterwards holds it where it stopped.

    Args:
        parameters: the node's configuration.
        encoder: becomes referenced.
        servo: the joint's servo; its integral is used.

    Attributes:
        found: whether the joint is referenced.
        failure: why it will not be, or None.
        error: of the joint against where it is driven to, rad.
    """

    __slots__ = (
        "_counts",
        "_cycles",
        "_encoder",
        "_max_cycles",
        "_max_disagreement",
        "_max_stuck",
        "_middle",
        "_offset",
        "_period",
        "_servo",
        "_speed",
        "_stuck",
        "_target",
        "error",
        "failure",
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
        self._max_cycles = math.ceil(parameters[Parameter.HOMING_TIME] / self._period)
        self._max_stuck = math.ceil(parameters[Parameter.STUCK_TIME] / self._period)
        self.begin()

    def begin(self) -> None:
        """Start the search; a joint that knows its reference has ended it already."""
        self._target: float | None
        self._offset: float | None
        self.let_go()
        self._counts: int | None = None
        self._cycles = self._stuck = 0
        self.error = 0.0
        self.failure: HomingFailure | None = None
        self.found = self._encoder.zero_counts is not None

    @property
    def engaged(self) -> bool:
        """Whether it has driven the joint since ``begin`` or ``let_go``."""
        return self._target is not None

    def let_go(self) -> None:
        """The joint is driven otherwise, or braked: where it is when homing goes on, it is held,
        or the search goes on from there."""
        self._target = self._offset = None

    def step(self, measure: Measure, reference: Reference, speed: float, gravity: float) -> float:
        """One cycle: the torque to move or hold with, Nm; ``speed`` rad/s, ``gravity`` Nm."""
        encoder = self._encoder
        angle = encoder.angle(measure.counts)
        if self._target is None:
            self._target = angle
        self._compare(encoder.coarse_angle(reference.coarse_adc) - angle)
        rate = 0.0
        if not self.found and self.failure is None:
            angle = self._look_for_index(measure, reference, angle)
        if not self.found:
            self._watch_progress(measure.counts)
            below = encoder.coarse_angle(reference.coarse_adc) < self._middle
            rate = self._speed if below else -self._speed
            self._target += rate * self._period
        friction = self._servo.friction.rigid(rate)
        self.error = self._target - angle
        return self._servo.alone(self.error, rate - speed, gravity, friction)

    def _look_for_index(self, measure: Measure, reference: Reference, angle: float) -> float:
        """Reference the encoder if it can be; the joint's angle, rad, in the frame known then."""
        encoder = self._encoder
        found = encoder.find(measure, reference)
        if found is False:
            self.failure = HomingFailure(Reference, encoder.residual, AMBIGUITY)
        self.found = found is True
        after = encoder.angle(measure.counts)
        assert self._target is not None
        self._target += after - angle  # the same place in the frame just found
        if self._offset is not None:
            self._offset -= after - angle
        return after

    def _watch_progress(self, counts: int) -> None:
        """The encoder must count while the whole torque is on, and the index come in time, s."""
        period = self._period
        self._cycles += 1
        if self._cycles > self._max_cycles:
            cycles, bound = self._cycles, self._max_cycles
            self.failure = HomingFailure(Reference, cycles * period, bound * period)
        stands = counts == self._counts and self._servo.state.at_limit
        self._stuck = self._stuck + 1 if stands else 0
        self._counts = counts
        if self._stuck > self._max_stuck:
            stuck, bound = self._stuck, self._max_stuck
            self.failure = HomingFailure(Measure, stuck * period, bound * period)

    def _compare(self, offset: float) -> None:
        """Coarse angle less the encoder's, rad: constant, up to the errors of the coarse one."""
        if self._offset is None:
            self._offset = offset
        elif abs(offset - self._offset) > self._max_disagreement:
            off = abs(offset - self._offset)
            self.failure = HomingFailure(Reference, off, self._max_disagreement)

"""Where a joint is and how fast: its board's samples, each of them checked before it is believed.

The order of the checks is that of docs/node-detectors.md. All of them are asked for each sample,
by the action the joint had when it came; one that stops the joint changes what is done afterwards.
"""

from collections.abc import Callable, Mapping
from typing import Final

from rfms_can.joint_nodes.detectors.drive import AmplifierWatch
from rfms_can.joint_nodes.detectors.sensors import SensorWatch
from rfms_can.joint_nodes.detectors.setpoint_step import STEP_MARGIN
from rfms_can.joint_nodes.field_node import Cause, FieldNode
from rfms_can.joint_nodes.servo import DAC_MAX, DAC_MIN
from rfms_can.joint_nodes.state_actions import StateAction, TorqueSource
from rfms_can.node.encoder_reference import EncoderReference
from rfms_can.wire.nodes import MASTER
from rfms_can.wire.records import Measure, Setpoint
from rfms_can.wire.vocabulary import FaultCode, Parameter

MAX_PREDICTED_CYCLES: Final = 2
"""Cycles in a row in which a prediction replaces an encoder that jumped; then the joint stops."""
HARD_MARGIN_RAD: Final = 0.05
"""Joint angle beyond the range, rad, at which torque goes off: the hard stop comes after it."""
SOFT_MARGIN_RAD: Final = 0.02
"""How far beyond the range, rad, a joint may come to rest by what is left of its following."""
RAIL: Final = float(DAC_MAX)

_MEASURE_MISSING: Final = FaultCode.MEASURE_MISSING
_ENCODER_GLITCH: Final = FaultCode.ENCODER_GLITCH
_ADC_SATURATED: Final = FaultCode.ADC_SATURATED
_AMPLIFIER_FAULT: Final = FaultCode.AMPLIFIER_FAULT
_OVERSPEED: Final = FaultCode.OVERSPEED
_NOTHING: Final = TorqueSource.NOTHING

Motion = tuple[float, float]
"""An angle, rad, and a speed, rad/s."""


class JointSensing:
    """The samples of one joint.

    Args:
        node: the bus life it belongs to.
        parameters: its configuration.
        commanded: tells the motion that is commanded now.
        jumped: told of an encoder that has jumped for good: by how much, rad, and whether the joint
            was on its stop ramp before.

    Attributes:
        theta: joint angle, rad.
        speed: joint speed, rad/s.
        encoder: makes angles of counts.
        amplifier: knows what the DACs asked for.
        max_step: of set-point or encoder in a cycle, rad.
        cycles_unsampled: since the last sample.
    """

    __slots__ = (
        "_acceleration",
        "_commanded",
        "_fresh",
        "_hard",
        "_jumped",
        "_node",
        "_overspeed",
        "_own",
        "_period",
        "_rate_per_code",
        "_sensors",
        "_setpoint",
        "_soft",
        "amplifier",
        "cycles_unsampled",
        "encoder",
        "max_step",
        "speed",
        "theta",
    )

    def __init__(
        self,
        node: FieldNode,
        parameters: Mapping[Parameter, float],
        commanded: Callable[[], Motion],
        jumped: Callable[[float, bool], None],
    ) -> None:
        p = parameters
        self._node = node
        self._commanded = commanded
        self._jumped = jumped
        self._period = p[Parameter.PERIOD]
        self._rate_per_code = p[Parameter.RATE_PER_CODE]
        self._overspeed = p[Parameter.OVERSPEED_LIMIT]
        self._acceleration = p[Parameter.ACCELERATION_LIMIT]
        ends = p[Parameter.POSITION_MIN], p[Parameter.POSITION_MAX]
        self._soft = ends[0] - SOFT_MARGIN_RAD, ends[1] + SOFT_MARGIN_RAD
        self._hard = ends[0] - HARD_MARGIN_RAD, ends[1] + HARD_MARGIN_RAD
        self._own = Cause(node.number, node.wire.id(Measure, node.number))
        self._setpoint = Cause(MASTER, node.wire.id(Setpoint, 1))
        self._sensors = SensorWatch(p)
        self.amplifier = AmplifierWatch(p)
        self.encoder = EncoderReference(p)
        self.max_step = STEP_MARGIN * p[Parameter.SPEED_LIMIT] * self._period
        self.theta = self.speed = 0.0
        self.cycles_unsampled = 1
        self._fresh = True

    def take(self, measure: Measure, action: StateAction) -> None:
        """Take a sample, for a joint that does ``action``."""
        node = self._node
        ladder = node.ladder
        ladder.clear(_MEASURE_MISSING)
        code = measure.velocity_adc
        theta, speed = self.encoder.angle(measure.counts), code * self._rate_per_code
        before, speed_before = self.theta, self.speed
        cycles = max(1, self.cycles_unsampled)  # 0 where two samples come in a cycle
        alone = self.cycles_unsampled == 1
        self.cycles_unsampled = 0
        if action.torque is _NOTHING:
            self.theta, self.speed = theta, speed
            if not self._fresh:
                self._forget()
            return
        self._fresh = False
        railed = code >= DAC_MAX or code <= DAC_MIN
        if railed:
            speed = (theta - before) / (cycles * self._period)
        if measure.braked:
            self.amplifier.reset()
        border = self.amplifier.border(measure.current_adc)
        self.theta, self.speed = theta, speed
        self._watch_rails(code, railed, measure.current_adc, border)
        if action.bridges_encoder:
            if abs(theta - before) > self.max_step * cycles:
                self._bridge_jump(before, speed_before, cycles, action)
                alone = False
            else:
                ladder.clear(_ENCODER_GLITCH)
        if not railed:
            self._watch_tachometer(code, speed, before, speed_before, alone)
        self._watch_speed(speed)
        self._watch_current(measure.current_adc, border)
        if action.watches_range:
            self._watch_range(self.theta, speed)

    def _forget(self) -> None:
        """The joint is not driven: what its sensors say is held against nothing."""
        self._fresh = True
        self._sensors.reset()
        self.amplifier.reset()

    def _watch_rails(self, code: int, railed: bool, current: int, border: float | None) -> None:
        """A converter at its rail tells nothing, unless the DACs explain it."""
        if railed:
            self._node.miss(_ADC_SATURATED, self._own._replace(bound=RAIL), code)
        elif border is not None and (current >= DAC_MAX or current <= DAC_MIN):
            self._node.miss(_ADC_SATURATED, self._own._replace(bound=RAIL), current)
        else:
            self._node.ladder.clear(_ADC_SATURATED)

    def _bridge_jump(self, before: float, speed: float, cycles: int, action: StateAction) -> None:
        """Predict over a step no joint can make (R1); if it lasts, take it and stop there.

        The joint did not move that far, its encoder did: a stop on the old path would move it.
        """
        node, bound = self._node, self.max_step * cycles
        node.miss(_ENCODER_GLITCH, self._own._replace(bound=bound), self.theta - before)
        predicted = before + speed * self._period * cycles
        if node.ladder.misses[_ENCODER_GLITCH] <= MAX_PREDICTED_CYCLES:
            self.theta = predicted
        else:
            self._jumped(self.theta - predicted, action.torque is TorqueSource.STOP_RAMP)

    def _watch_tachometer(
        self, code: int, speed: float, before: float, speed_before: float, alone: bool
    ) -> None:
        """It belongs to the encoder's motion, and shows more than one value of it."""
        sensors, node = self._sensors, self._node
        if not alone:  # cycles without a sample, or with a jump of the encoder, compare with none
            return
        moved = self.theta - before
        if sensors.differ(moved, speed, speed_before):
            off = moved / self._period - 0.5 * (speed + speed_before)
            cause = self._own._replace(bound=sensors.limit)
            node.trip(FaultCode.SENSOR_MISMATCH, cause, off)
        variation = sensors.variation(code, moved)
        if variation > sensors.variation_bound:
            cause = self._own._replace(bound=sensors.variation_bound / self._period)
            node.trip(FaultCode.SENSOR_STUCK, cause, variation / self._period)

    def _watch_speed(self, speed: float) -> None:
        """No joint is as fast as this by itself (R4)."""
        if -self._overspeed <= speed <= self._overspeed:
            self._node.ladder.clear(_OVERSPEED)
        else:
            self._node.miss(_OVERSPEED, self._own._replace(bound=self._overspeed), speed)

    def _watch_current(self, current: int, border: float | None) -> None:
        """The amplifier drives what the DACs ask (R4)."""
        if border is None:
            self._node.ladder.clear(_AMPLIFIER_FAULT)
        else:
            self._node.miss(_AMPLIFIER_FAULT, self._own._replace(bound=border), current)

    def _watch_range(self, theta: float, speed: float) -> None:
        """Joint range: beyond it torque goes off; where only a stop now can keep it, stop."""
        low, high = self._hard
        if not low <= theta <= high:
            bound = low if theta < low else high
            self._node.trip(FaultCode.HARD_LIMIT, Cause(self._node.number, bound=bound), theta)
            return
        rest = self._rest(theta, speed)
        low, high = self._soft
        if not low <= rest <= high:
            bound = low if rest < low else high
            told = self._rest(*self._commanded())
            inside = low + SOFT_MARGIN_RAD <= told <= high - SOFT_MARGIN_RAD
            cause = Cause(self._node.number) if inside else self._setpoint
            self._node.trip(FaultCode.SOFT_LIMIT, cause._replace(bound=bound), rest)

    def _rest(self, theta: float, speed: float) -> float:
        """Where a motion comes to rest by a controlled stop, rad."""
        return theta + 0.5 * speed * abs(speed) / self._acceleration

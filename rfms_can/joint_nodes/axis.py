"""One axis of the arm: its board's samples in, torque out; homing, stopping, limits (R2 to R4).

What the axis does in operation, among the others, is the joint node's (``joint.py``).
"""

from typing import Final

from rfms_can.arm import ARMS, Arm
from rfms_can.joint_nodes.compliance import RowSets
from rfms_can.joint_nodes.field_node import FieldNode
from rfms_can.joint_nodes.homing import Homing
from rfms_can.joint_nodes.ladder import Reaction
from rfms_can.joint_nodes.servo import Servo
from rfms_can.joint_nodes.states import Event
from rfms_can.joint_nodes.stop_ramp import StopRamp
from rfms_can.node.encoder import EncoderReference
from rfms_can.wire.contract import Wire
from rfms_can.wire.records import Dac, Measure, Reference, Rows
from rfms_can.wire.vocabulary import FaultCode, NodeState, Parameter

DAMPING_PART: Final = 0.2
"""Part of the torque limit that damping (R3) may use."""
STEP_MARGIN: Final = 1.5
"""How much faster than the speed limit a set-point or an encoder may step before it is refused."""
PREDICTED: Final = 2
"""Cycles an encoder that stepped is not believed; after that the joint stops where it says."""
BEYOND: Final = 0.05
"""Joint angle beyond the range, rad, at which torque goes off: the hard stop is near."""
_POSITIVE: Final = (
    *(Parameter.PERIOD, Parameter.TORQUE_LIMIT, Parameter.SPEED_LIMIT),
    Parameter.ACCELERATION_LIMIT,
)
_DIVISORS: Final = (
    *(Parameter.TORQUE_PER_CODE, Parameter.TORQUE_PER_FORCE_CODE),
    Parameter.COUNTS_PER_UNIT,
)
"""Negative where the motor turns against the joint."""


class Axis(FieldNode):
    """A joint node's half that needs no other joint.

    Attributes:
        rows: active and arriving rows.
        theta: measured joint angle, rad.
        speed: measured joint speed, rad/s.
        torque: last commanded torque, Nm.
    """

    def __init__(self, joint: int, wire: Wire, boot_id: int, watch_ns: int) -> None:
        super().__init__(joint, wire, boot_id, watch_ns)
        self.rows = RowSets(joint)
        self.theta = self.speed = self.torque = 0.0
        self._index = joint - 1
        self._servo: Servo
        self._encoder: EncoderReference
        self._homing: Homing
        self._ramp: StopRamp | None = None
        self._measure: Measure | None = None
        self._driven = True
        self._age = 1  # cycles since the last measurement
        self._sampled_in = 0  # its cycle: the plant's own, also where SYNC has failed
        self._dac = self._sends(Dac, joint)
        self._hears(Measure, joint, self._on_measure)
        self._hears(Reference, joint, self._on_reference)
        self._hears(Rows, joint, self.rows.hear)

    # --- for the node built on this -----------------------------------------------------------

    def _built(self, arm: Arm) -> None:
        """The axis is configured; build what depends on the arm."""
        raise NotImplementedError

    def _sampled(self) -> None:
        """A sample came, in operation."""
        raise NotImplementedError

    # --- configuration and state --------------------------------------------------------------

    def _configured(self) -> bool:
        if len(self.parameters) != len(Parameter) - 1:
            return False
        arm = next(
            (a for a in ARMS.values() if a.arm_id == self.parameters[Parameter.ARM_ID]), None
        )
        if arm is None:
            return False
        p = self.parameters
        if any(p[scale] <= 0.0 for scale in _POSITIVE) or not all(p[scale] for scale in _DIVISORS):
            return False
        if p[Parameter.INDEX_INTERVAL_COUNTS] < 1.0:
            return False
        self._servo = Servo(p, self.number)
        self._encoder = EncoderReference(p)
        self._homing = Homing(p, self._encoder, self._servo)
        self._theta_step = STEP_MARGIN * p[Parameter.SPEED_LIMIT] * p[Parameter.PERIOD]
        self._rate_per_code = p[Parameter.RATE_PER_CODE]
        self._lowest = p[Parameter.POSITION_MIN] - BEYOND
        self._highest = p[Parameter.POSITION_MAX] + BEYOND
        self._way_per_square = 0.5 / p[Parameter.ACCELERATION_LIMIT]
        self._built(arm)
        return True

    def _entered(self, state: NodeState) -> None:
        if state is NodeState.HOMING:
            self._homing.begin()
            self._servo.reset()
        elif state is NodeState.PREOP:
            self.rows.clear()  # a master that starts anew numbers its sets anew

    def _is_stale(self, cycle: int, what: str) -> bool:
        if cycle == self.cycle & 0xFF:
            return False
        self.ignored[f"stale {what}"] += 1
        return True

    # --- samples and limits -------------------------------------------------------------------

    def _on_measure(self, measure: Measure) -> None:
        if not self.config_hash:
            return
        stopping = self.state in (NodeState.QUICKSTOP, NodeState.FAULT)
        if not stopping and self._is_stale(measure.cycle, "MEASURE"):
            return
        self._take(measure)
        if self.state is NodeState.OPERATIONAL:
            self._sampled()
        elif self.state is NodeState.QUICKSTOP:
            self._stop()
        elif self.reaction is Reaction.DAMP:
            self._damp()

    def _take(self, measure: Measure) -> None:
        """Angle and speed from the board."""
        self._measure = measure
        self._sampled_in = measure.cycle
        self._ladder.clear(FaultCode.MEASURE_MISSING)
        speed = measure.velocity_adc * self._rate_per_code
        theta = self._encoder.angle(measure.counts)
        if self.state in (NodeState.OPERATIONAL, NodeState.QUICKSTOP):
            if abs(theta - self.theta) > self._theta_step * self._age:
                theta = self._doubt(theta, speed)
            else:
                self._ladder.clear(FaultCode.ENCODER_GLITCH)
            self._watch_range(theta, speed)
        elif self.reaction is Reaction.DAMP:
            self._watch_range(theta, speed)
        self.theta, self.speed = theta, speed
        self._age = 0

    def _doubt(self, theta: float, speed: float) -> float:
        """A step no joint can make is predicted over (R1); if it lasts, stop where it leads.

        The joint did not move that far, its encoder did: stopping on the old path would.
        """
        self._miss(FaultCode.ENCODER_GLITCH, theta - self.theta)
        if self._ladder.misses[FaultCode.ENCODER_GLITCH] <= PREDICTED:
            return self.theta + self.speed * self.parameters[Parameter.PERIOD] * self._age
        self._stop_from(theta, speed)
        return theta

    def _watch_range(self, theta: float, speed: float) -> None:
        """Joint range: beyond it torque goes off; if it cannot be kept any more, stop now."""
        if not self._lowest <= theta <= self._highest:
            self._react(Reaction.OFF, FaultCode.HARD_LIMIT, theta)
            return
        way = speed * abs(speed) * self._way_per_square
        if not self._lowest <= theta + way <= self._highest:
            self._react(Reaction.STOP, FaultCode.SOFT_LIMIT, theta + way)

    # --- torque -------------------------------------------------------------------------------

    def _drive(self, torque: float, bias: float = 0.0) -> None:
        """Torques to DAC codes: the servo's is a motor current, the bias a force set-point."""
        servo = self._servo
        self.torque = torque + bias
        self._driven = True
        self._out.append(
            self._dac.frame(servo.code(torque), servo.force_code(bias), self._sampled_in)
        )

    def _on_reference(self, reference: Reference) -> None:
        """Homing, while the bus homes: find the index, then hold there."""
        measure = self._measure
        homes = self.bus_state is NodeState.HOMING and self.state in (
            NodeState.HOMING,
            NodeState.READY,
        )
        if not homes or measure is None or self._is_stale(reference.cycle, "REFERENCE"):
            return
        torque = self._homing.step(measure, reference, self.speed, self.rows.gravity)
        if self._homing.found is False:
            self._react(Reaction.OFF, FaultCode.HOMING_FAILED, self._encoder.residual)
            return
        if self._homing.found and self.state is NodeState.HOMING:
            self._change(Event.HOMED)
            self.theta = self._encoder.angle(measure.counts)
        self._drive(torque)

    def _stop(self) -> None:
        """QUICKSTOP (R2): own joint along its ramp, then hold, with gravity compensation."""
        ramp = self._ramp
        if ramp is None:
            return
        ramp.step()
        ramp.watch(self.theta)
        self._drive(
            self._servo.alone(
                ramp.position - self.theta,
                ramp.speed - self.speed,
                self.rows.gravity
                + self._servo.friction.rigid(ramp.speed)
                + self.rows.inertia * ramp.acceleration,
            )
        )

    def _damp(self) -> None:
        """R3: brake the motion with a capped torque; gravity stays compensated."""
        cap = DAMPING_PART * self._servo.torque_limit
        torque = -self.parameters[Parameter.KD] * self.speed
        self._drive(self.rows.gravity + max(-cap, min(cap, torque)))

    def _stop_from(self, position: float, speed: float) -> None:
        """Begin the controlled stop; it ends inside the range, be it harder than the limit."""
        p = self.parameters
        bound = p[Parameter.POSITION_MAX] if speed > 0.0 else p[Parameter.POSITION_MIN]
        room = max(abs(bound - position), 1.0 / abs(p[Parameter.COUNTS_PER_UNIT]))
        deceleration = max(p[Parameter.ACCELERATION_LIMIT], speed * speed / (2.0 * room))
        self._ramp = StopRamp(position, speed, deceleration, p[Parameter.PERIOD])

    def _react(self, reaction: Reaction, fault: FaultCode, value: float) -> None:
        before = self.reaction
        super()._react(reaction, fault, value)
        if self.reaction is Reaction.OFF and before is not Reaction.OFF and self.config_hash:
            self._drive(0.0)  # and silence from now on: the plant brakes a joint without DAC

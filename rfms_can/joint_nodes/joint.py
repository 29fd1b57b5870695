"""A joint node: solves its own joint from T6, tells its error, hears the others', servos.

One cycle, in the order frames come: SYNC swaps the rows; SETPOINT and MEASURE together give the
set-point and the error, which goes out as ERROR; when all six errors are known the compliance row
makes the real error of them, the servo a torque, and the torque goes out as DAC.
"""

import math
from functools import partial
from typing import Final

from rfms_can.arm import ARMS
from rfms_can.encoder import EncoderReference
from rfms_can.errors import EncodeError
from rfms_can.joint_nodes.compliance import RowSets
from rfms_can.joint_nodes.field_node import FieldNode
from rfms_can.joint_nodes.homing import Homing
from rfms_can.joint_nodes.ladder import Reaction
from rfms_can.joint_nodes.servo import Servo
from rfms_can.joint_nodes.states import Event
from rfms_can.joint_nodes.stop_ramp import StopRamp
from rfms_can.kinematics import JointSolver
from rfms_can.setpoint import JointSetpoint
from rfms_can.setpoint_frames import setpoint_of
from rfms_can.wire import JOINTS, Wire
from rfms_can.wire.records import (
    Bias,
    Dac,
    JointError,
    Measure,
    Reference,
    Rows,
    Setpoint,
    Sync,
)
from rfms_can.wire.vocabulary import FaultCode, NodeState, Parameter

_ALL_ERRORS: Final = (1 << len(JOINTS)) - 1
_DAMPING_PART: Final = 0.2
"""Part of the torque limit that damping (R3) may use."""
_STEP_MARGIN: Final = 1.5
"""How much faster than the speed limit a set-point or an encoder may step before it is refused."""
_PREDICTED: Final = 2
"""Cycles an encoder that stepped is not believed; after that the joint stops where it says."""
_PASSED: Final = 4
"""Cycles that may pass unseen before the ladder stops the joint anyhow, and one."""
_BEYOND: Final = 0.05
"""Joint angle beyond the range, rad, at which torque goes off: the hard stop is near."""
_POSITIVE: Final = (
    *(Parameter.PERIOD, Parameter.TORQUE_LIMIT, Parameter.SPEED_LIMIT),
    *(Parameter.ACCELERATION_LIMIT, Parameter.INDEX_INTERVAL_COUNTS),
)
_DIVISORS: Final = (Parameter.TORQUE_PER_CODE, Parameter.COUNTS_PER_UNIT)
"""Negative where the motor turns against the joint."""


class JointNode(FieldNode):
    """Joint node 1 to 6.

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
        self._servo: Servo
        self._encoder: EncoderReference
        self._homing: Homing
        self._solver: JointSolver
        self._trajectory: JointSetpoint
        self._ramp: StopRamp | None = None
        self._bias = self._next_bias = 0.0
        self._index = joint - 1
        self._errors = [0.0] * len(JOINTS)
        self._rates = [0.0] * len(JOINTS)
        self._accelerations = [0.0] * len(JOINTS)
        self._heard = 0
        self._setpoint_1: Setpoint | None = None
        self._setpoint_2: Setpoint | None = None
        self._measure: Measure | None = None
        self._driven = True
        self._begun = -1  # the cycle of the last SYNC
        self._age = 1  # cycles since the last measurement
        self._held = 0  # cycles since the last set-point taken
        self._error = self._sends(JointError, joint)
        self._dac = self._sends(Dac, joint)
        self._hears(Setpoint, 1, self._on_setpoint_1)
        self._hears(Setpoint, 2, self._on_setpoint_2)
        self._hears(Bias, None, self._on_bias)
        self._hears(Measure, joint, self._on_measure)
        self._hears(Reference, joint, self._on_reference)
        self._hears(Rows, joint, self.rows.hear)
        for other in JOINTS:
            if other != joint:
                self._hears(JointError, other, partial(self._on_error, other - 1))

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
        self._servo = Servo(p)
        self._encoder = EncoderReference(p)
        self._homing = Homing(p, self._encoder, self._servo)
        self._solver = JointSolver(arm, self.number)
        self._trajectory = JointSetpoint(p[Parameter.PERIOD])
        self._theta_step = _STEP_MARGIN * p[Parameter.SPEED_LIMIT] * p[Parameter.PERIOD]
        self._rate_per_code = p[Parameter.RATE_PER_CODE]
        self._lowest = p[Parameter.POSITION_MIN] - _BEYOND
        self._highest = p[Parameter.POSITION_MAX] + _BEYOND
        self._way_per_square = 0.5 / p[Parameter.ACCELERATION_LIMIT]
        return True

    def _entered(self, state: NodeState) -> None:
        if state is NodeState.HOMING:
            self._homing.begin()
            self._servo.reset()
        elif state is NodeState.OPERATIONAL:
            self._servo.reset()
            self._trajectory.reset(self.theta)
            self._errors[:] = self._rates[:] = self._accelerations[:] = [0.0] * len(JOINTS)
            self._driven = True
            self._held = 0
            self._bias = self._next_bias = 0.0
        elif state is NodeState.QUICKSTOP:
            self._stop_from(self._trajectory.theta, self._trajectory.rate)
        elif state is NodeState.PREOP:
            self.rows.clear()  # a master that starts anew numbers its sets anew

    def _stop_from(self, position: float, speed: float) -> None:
        """Begin the controlled stop; it ends inside the range, be it harder than the limit."""
        p = self.parameters
        bound = p[Parameter.POSITION_MAX] if speed > 0.0 else p[Parameter.POSITION_MIN]
        room = max(abs(bound - position), 1.0 / abs(p[Parameter.COUNTS_PER_UNIT]))
        deceleration = max(p[Parameter.ACCELERATION_LIMIT], speed * speed / (2.0 * room))
        self._ramp = StopRamp(position, speed, deceleration, p[Parameter.PERIOD])

    # --- a cycle ------------------------------------------------------------------------------

    def _begin_cycle(self, sync: Sync) -> None:
        if not self._driven:
            self._missed_cycle()
        elif self.state is not NodeState.OPERATIONAL and self.bus_state is NodeState.OPERATIONAL:
            self._watch_setpoints()
        passed, self._begun = sync.cycle - self._begun, sync.cycle
        self._age += 1
        if passed > 1:
            self._skip(min(passed, _PASSED) - 1)
        if self.rows.swap(sync.row_set):
            self._ladder.clear(FaultCode.ROWS_MISSING)
        else:
            self._miss(FaultCode.ROWS_MISSING)
        self._bias = self._next_bias
        self._setpoint_1 = self._setpoint_2 = self._measure = None
        self._heard = 0
        self._driven = self.state not in (NodeState.OPERATIONAL, NodeState.QUICKSTOP)

    def _missed_cycle(self) -> None:
        """The cycle before ended without a DAC frame: R1 holds; the ladder counts what was missing.

        The plant holds the last DAC code by itself; the trajectory must not lose the cycle.
        """
        if self._measure is None:
            self._miss(FaultCode.MEASURE_MISSING)
        elif not self._heard & 1 << self._index:
            self._miss(FaultCode.SETPOINT_MISSING)
        else:
            self._miss(FaultCode.ERROR_MISSING)
            return
        self._hold()

    def _hold(self) -> None:
        """A cycle without a set-point (R1): the last one stays, its history goes on."""
        self._trajectory.miss()
        self._held += 1

    def _skip(self, cycles: int) -> None:
        """Cycles passed whose SYNC never came."""
        self._age += cycles
        if self.state is NodeState.OPERATIONAL:
            for _ in range(cycles):
                self._hold()

    def _watch_setpoints(self) -> None:
        """Stopped, while SYNC says that all is well: without set-points on up the ladder."""
        if self._setpoint_1 is None:
            self._miss(FaultCode.SETPOINT_MISSING)
        else:
            self._ladder.clear(FaultCode.SETPOINT_MISSING)

    def _without_sync(self) -> None:
        """No SYNC: what comes next belongs to no cycle we know."""
        self._age += 1
        self._setpoint_1 = self._setpoint_2 = self._measure = None
        self._heard = 0
        self._driven = True

    def _is_stale(self, cycle: int, what: str) -> bool:
        if cycle == self.cycle & 0xFF:
            return False
        self.ignored[f"stale {what}"] += 1
        return True

    def _on_setpoint_1(self, setpoint: Setpoint) -> None:
        if not self._is_stale(setpoint.cycle & 0xFF, "SETPOINT"):
            self._setpoint_1 = setpoint
            self._solve()

    def _on_setpoint_2(self, setpoint: Setpoint) -> None:
        if not self._is_stale(setpoint.cycle & 0xFF, "SETPOINT"):
            self._setpoint_2 = setpoint
            self._solve()

    def _on_bias(self, bias: Bias) -> None:
        """A bias torque acts from the next SYNC on."""
        self._next_bias = bias[self._index]

    def _on_measure(self, measure: Measure) -> None:
        if not self.config_hash:
            return
        stopping = self.state in (NodeState.QUICKSTOP, NodeState.FAULT)
        if not stopping and self._is_stale(measure.cycle, "MEASURE"):
            return
        self._take(measure)
        if self.state is NodeState.OPERATIONAL:
            self._solve()
        elif self.state is NodeState.QUICKSTOP:
            self._stop()
        elif self.reaction is Reaction.DAMP:
            self._damp()

    def _take(self, measure: Measure) -> None:
        """Angle and speed from the board."""
        self._measure = measure
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
        if self._ladder.misses[FaultCode.ENCODER_GLITCH] <= _PREDICTED:
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

    def _solve(self) -> None:
        """SETPOINT and MEASURE are here: own set-point, own error, and tell it."""
        first, second = self._setpoint_1, self._setpoint_2
        if first is None or self._measure is None or self.state is not NodeState.OPERATIONAL:
            return
        if (first.poses == 2) is not (second is not None) or self._heard & 1 << self._index:
            return
        trajectory = self._trajectory
        before, rate_before = trajectory.theta, trajectory.rate
        theta = trajectory.tick(setpoint_of(first, second), self._solver.solve)
        if math.isnan(theta):
            return  # refused whole: counted as a missing set-point at the next SYNC
        error, rate = theta - self.theta, trajectory.rate - self.speed
        acceleration = trajectory.acceleration
        try:
            told = self._error.frame(error, rate, acceleration, self.cycle & 0xFF)
        except EncodeError:
            told = None  # more than a joint error can say: a step, as below
        if told is None or abs(theta - before) > self._theta_step * (1 + self._held):
            self._miss(FaultCode.SETPOINT_STEP, theta - before)
            self._stop_from(before, rate_before)  # none of the step may act
            return
        self._held = 0
        self._ladder.clear(FaultCode.SETPOINT_MISSING)
        self._out.append(told)
        self._know(self._index, error, rate, acceleration)

    def _on_error(self, index: int, error: JointError) -> None:
        if error.cycle == self.cycle & 0xFF:
            self._know(index, error.error, error.error_rate, error.acceleration)
        else:
            self.ignored["stale ERROR"] += 1

    def _know(self, index: int, error: float, rate: float, acceleration: float) -> None:
        """One of the six errors is known; with all of them, servo."""
        self._errors[index] = error
        self._rates[index] = rate
        self._accelerations[index] = acceleration
        self._heard |= 1 << index
        if self._heard == _ALL_ERRORS and self.state is NodeState.OPERATIONAL:
            self._ladder.clear(FaultCode.ERROR_MISSING)
            self._drive(self._command())

    def _command(self) -> float:
        """Torque of Eq. 5.11 as corrected, Nm."""
        servo, rows = self._servo, self.rows
        return servo.torque(
            self._errors,
            self._rates,
            self._accelerations,
            rows.compliance,
            rows.weighted,
            rows.law,
            rows.gravity + servo.friction(self._trajectory.rate) + self._bias,
        )

    def _drive(self, torque: float) -> None:
        """Torque to current to DAC code."""
        self.torque = torque
        self._driven = True
        cycle = self.cycle if self._measure is None else self._measure.cycle
        self._out.append(self._dac.frame(self._servo.code(torque), 0, cycle & 0xFF))

    # --- homing, stopping ---------------------------------------------------------------------

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
        if self.state is NodeState.HOMING and self._homing.found is not None:
            if self._homing.found:
                self._change(Event.HOMED)
                self.theta = self._encoder.angle(measure.counts)
            else:
                self._react(Reaction.OFF, FaultCode.HOMING_FAILED, self._encoder.residual)
                return
        self._drive(torque)

    def _stop(self) -> None:
        """QUICKSTOP (R2): own joint along its ramp, then hold, with gravity compensation."""
        ramp = self._ramp
        if ramp is None:
            return
        ramp.step()
        self._drive(
            self._servo.alone(
                ramp.position - self.theta,
                ramp.speed - self.speed,
                self.rows.gravity
                + self._servo.friction(ramp.speed)
                + self.rows.weighted[self._index] * ramp.acceleration,
            )
        )

    def _damp(self) -> None:
        """R3: brake the motion with a capped torque; gravity stays compensated."""
        cap = _DAMPING_PART * self._servo.torque_limit
        torque = -self.parameters[Parameter.KD] * self.speed
        self._drive(self.rows.gravity + max(-cap, min(cap, torque)))

    def _react(self, reaction: Reaction, fault: FaultCode, value: float) -> None:
        before = self.reaction
        super()._react(reaction, fault, value)
        if self.reaction is Reaction.OFF and before is not Reaction.OFF and self.config_hash:
            self._drive(0.0)  # and silence from now on: the plant brakes a joint without DAC

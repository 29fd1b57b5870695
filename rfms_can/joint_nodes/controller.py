"""What a configured joint does: its board's samples and the bus' frames in, ERROR and DAC out.

A cycle has three parts, read in this order: ``begin_cycle`` at SYNC counts what the cycle before
lacked and changes over to the named rows; ``step``, called after each frame, does what can be done
with the frames so far; ``lose_cycle`` where a SYNC did not come. What a step does is the action's
(``state_actions.py``).
"""

import math
from collections.abc import Callable
from typing import Final

from rfms_can.errors import EncodeError
from rfms_can.joint_nodes.angle_solver import AngleSolver
from rfms_can.joint_nodes.compliance import RowSets
from rfms_can.joint_nodes.field_node import Cause, FieldNode, Parameters
from rfms_can.joint_nodes.homing import Homing
from rfms_can.joint_nodes.inputs import ALL_ERRORS, CycleInputs
from rfms_can.joint_nodes.ladder import Reaction, rung
from rfms_can.joint_nodes.runaway import RunawayWatch
from rfms_can.joint_nodes.servo import Servo, ServoTerms
from rfms_can.joint_nodes.state_actions import STATE_ACTIONS, StateAction, TorqueSource
from rfms_can.joint_nodes.states import Event
from rfms_can.joint_nodes.stop_ramp import StopRamp
from rfms_can.node.encoder_reference import EncoderReference
from rfms_can.setpoint import JointSetpoint
from rfms_can.setpoint.frames import setpoint_of
from rfms_can.tables import complete
from rfms_can.wire.contract import BIAS_BELONGS, COMPLY_BELONGS, JOINT_SETPOINT_BELONGS
from rfms_can.wire.nodes import JOINTS, MASTER
from rfms_can.wire.protection import Sender
from rfms_can.wire.records import (
    Dac,
    JointError,
    Measure,
    Rows,
    Setpoint,
    Sync,
)
from rfms_can.wire.vocabulary import FaultCode, NodeState, Parameter

STEP_MARGIN: Final = 1.5
"""How much faster than the speed limit a set-point or an encoder may step before it is refused."""
MAX_PREDICTED_CYCLES: Final = 2
"""Cycles in a row in which a prediction replaces an encoder that jumped; then the joint stops."""
RANGE_MARGIN_RAD: Final = 0.05
"""Joint angle beyond the range, rad, at which torque goes off: the hard stop is near."""
MAX_CYCLE_GAP: Final = 4
"""Largest gap of SYNC's cycle that is accounted for; the ladder stops the joint before a longer."""
# members of enumerations that every cycle needs: a name of a module is found ten times as fast
_NOTHING: Final = TorqueSource.NOTHING
_HOMING: Final = TorqueSource.HOMING
_HOLD: Final = TorqueSource.HOLD
_SERVO: Final = TorqueSource.SERVO
_STOP_RAMP: Final = TorqueSource.STOP_RAMP
_DAMPING: Final = TorqueSource.DAMPING
_MEASURE_MISSING: Final = FaultCode.MEASURE_MISSING
_SETPOINT_MISSING: Final = FaultCode.SETPOINT_MISSING
_ERROR_MISSING: Final = FaultCode.ERROR_MISSING
_ROWS_MISSING: Final = FaultCode.ROWS_MISSING
_ENCODER_GLITCH: Final = FaultCode.ENCODER_GLITCH


class JointController:
    """Drives one joint.

    Args:
        node: the bus life it belongs to: state, faults, and the way onto the bus.
        parameters: the node's configuration, whole, each value in its range.
        inputs: what has been received for the cycle under way.
        rows: active and arriving rows.
        dac, error: senders of DAC and ERROR.

    Attributes:
        action: what it does now.
        theta: measured joint angle, rad.
        speed: measured joint speed, rad/s.
        torque: last commanded torque, Nm.
        servo, encoder, homing, trajectory: its parts.
        ramp: of the controlled stop; None before the first.
    """

    __slots__ = (
        "_acceleration_limit",
        "_bias",
        "_board",
        "_count_rad",
        "_cycle",
        "_cycles_held",
        "_cycles_lost",
        "_cycles_unsampled",
        "_dac",
        "_displacement",
        "_error",
        "_index",
        "_inputs",
        "_master",
        "_max_step",
        "_node",
        "_own_bit",
        "_period",
        "_position_max",
        "_position_min",
        "_range_max",
        "_range_min",
        "_rate_per_code",
        "_rows",
        "_runaway",
        "_sink",
        "_solver",
        "_stop_distance_per_speed2",
        "action",
        "encoder",
        "homing",
        "ramp",
        "servo",
        "speed",
        "theta",
        "torque",
        "trajectory",
    )

    def __init__(
        self,
        node: FieldNode,
        parameters: Parameters,
        inputs: CycleInputs,
        rows: RowSets,
        dac: Sender[Dac],
        error: Sender[JointError],
    ) -> None:
        """Build all parts.

        Raises:
            KinematicsError: the arm has no closed form that this node knows.
        """
        p = parameters
        self._node = node
        self._inputs = inputs
        self._rows = rows
        self._dac = dac
        self._error = error
        self._index = node.number - 1
        self._own_bit = 1 << self._index
        self._period = p[Parameter.PERIOD]
        self._rate_per_code = p[Parameter.RATE_PER_CODE]
        self._max_step = STEP_MARGIN * p[Parameter.SPEED_LIMIT] * self._period
        self._count_rad = 1.0 / abs(p[Parameter.COUNTS_PER_UNIT])
        self._acceleration_limit = p[Parameter.ACCELERATION_LIMIT]
        self._stop_distance_per_speed2 = 0.5 / self._acceleration_limit
        self._position_min, self._position_max = (
            p[Parameter.POSITION_MIN],
            p[Parameter.POSITION_MAX],
        )
        self._range_min = self._position_min - RANGE_MARGIN_RAD
        self._range_max = self._position_max + RANGE_MARGIN_RAD
        self.servo = Servo(p, node.number)
        self.encoder = EncoderReference(p)
        self.homing = Homing(p, self.encoder, self.servo)
        self.trajectory = JointSetpoint(self._period)
        self._runaway = RunawayWatch(p, rung(FaultCode.RUNAWAY, Reaction.OFF))
        self.ramp: StopRamp | None = None
        self._solver = AngleSolver(p, node.number)
        self._master = Cause(MASTER, node.wire.id(Setpoint, 1))
        self._board = Cause(int(p[Parameter.SENSOR_SOURCE]), node.wire.id(Measure, node.number))
        self.theta = self.speed = self.torque = 0.0
        self._bias = 0.0  # of the set-point taken last, Nm
        self._displacement = 0.0  # by compliance, rad, in the set-point taken last
        self._cycle = -1  # of the last SYNC
        self._cycles_unsampled = 1  # since the last sample
        self._cycles_lost = 0  # SYNCs that the watchdog has missed since the last one
        self._cycles_held = 0  # since the last set-point taken
        self._sink: Callable[[int, ServoTerms], None] | None = None
        self._decide()

    def record_terms(self, sink: Callable[[int, ServoTerms], None] | None) -> None:
        """Give the cycle and the terms of each torque to ``sink`` from now on; None ends it."""
        self._sink = sink
        self.servo.recording = sink is not None

    # --- a cycle ------------------------------------------------------------------------------

    def begin_cycle(self, sync: Sync) -> None:
        """SYNC: count what the cycle before lacked; change over to the rows it names."""
        node, inputs, rows = self._node, self._inputs, self._rows
        self._decide()
        if self.homing.engaged and not self.homes:
            self.homing.let_go()
        self._judge()
        gap, self._cycle = min(sync.cycle - self._cycle, MAX_CYCLE_GAP), sync.cycle
        # those that the watchdog of SYNC has told of are counted already
        self._cycles_unsampled += max(gap - self._cycles_lost, 1)
        self._cycles_lost = 0
        if gap > 1 and node.state is NodeState.OPERATIONAL:
            for _ in range(gap - 1):  # cycles whose SYNC never came
                self._hold()
        if rows.activate(sync.row_set):
            node.ladder.clear(_ROWS_MISSING)
        else:
            cause = self._master._replace(frame=node.wire.id(Rows, node.number))
            node.miss(FaultCode.ROWS_MISSING, cause)
        inputs.begin(self.action.owes_dac, self.action.expects_setpoint)

    def step(self) -> None:
        """The cycle, as far as the frames received so far allow; called after each of them."""
        inputs = self._inputs
        measure, sampled = inputs.measure, inputs.new_sample
        # 1. the board's sample: angle and speed; a jump or the end of the range may stop the joint
        if measure is not None and sampled:
            inputs.new_sample = False
            self._take_sample(measure)
        source = self.action.torque  # after the sample, which may have changed it
        if source is _SERVO:
            # 2. set-point and sample: own set-point, own error, told to the others
            if not inputs.heard & self._own_bit and measure is not None:
                self._tell_error()
            # 3. six errors: torque
            if inputs.heard == ALL_ERRORS and not inputs.servoed:
                inputs.servoed = True
                self._node.ladder.clear(_ERROR_MISSING)
                self._drive(self._servo_torque(), self._bias)
        elif source is _STOP_RAMP and sampled:
            self._follow_ramp()
        elif source is _DAMPING and sampled:
            self._drive(self.servo.damped(self.speed, self._rows.gravity))
        elif inputs.reference is not None:  # kept only while the action is to home, or to hold
            self._home()

    def lose_cycle(self) -> None:
        """No SYNC: the cycle before is over, what comes next belongs to none the node knows."""
        self._judge()
        self._cycles_unsampled += 1
        self._cycles_lost += 1
        self._inputs.begin(dac_due=False)

    # --- 1. the sample ------------------------------------------------------------------------

    def _take_sample(self, measure: Measure) -> None:
        """Angle and speed from the board, watched as the action says."""
        ladder, action = self._node.ladder, self.action
        ladder.clear(_MEASURE_MISSING)
        speed = measure.velocity_adc * self._rate_per_code
        theta = self.encoder.angle(measure.counts)
        if action.bridges_encoder:
            cycles = max(1, self._cycles_unsampled)  # 0 where two samples come in a cycle
            if abs(theta - self.theta) > self._max_step * cycles:
                theta = self._bridge_encoder_jump(theta, speed, cycles)
            else:
                ladder.clear(_ENCODER_GLITCH)
        if action.watches_range:
            self._watch_range(theta, speed)
        self.theta, self.speed = theta, speed
        self._cycles_unsampled = 0

    def _bridge_encoder_jump(self, theta: float, speed: float, cycles: int) -> float:
        """Predict over a step no joint can make (R1); if it lasts, stop where it leads.

        The joint did not move that far, its encoder did: a stop on the old path would move it.
        """
        node = self._node
        bound = self._max_step * cycles
        node.miss(FaultCode.ENCODER_GLITCH, self._board._replace(bound=bound), theta - self.theta)
        if node.ladder.misses[FaultCode.ENCODER_GLITCH] <= MAX_PREDICTED_CYCLES:
            return self.theta + self.speed * self._period * cycles
        self._begin_stop(theta, speed)
        return theta

    def _watch_range(self, theta: float, speed: float) -> None:
        """Joint range: beyond it torque goes off; where only a stop now can keep it, stop."""
        if not self._range_min <= theta <= self._range_max:
            self._leave_range(FaultCode.HARD_LIMIT, theta)
            return
        rest = theta + speed * abs(speed) * self._stop_distance_per_speed2
        if not self._range_min <= rest <= self._range_max:
            self._leave_range(FaultCode.SOFT_LIMIT, rest)

    def _leave_range(self, fault: FaultCode, angle: float) -> None:
        bound = self._range_min if angle < self._range_min else self._range_max
        self._node.trip(fault, Cause(self._node.number, bound=bound), angle)

    # --- 2. own set-point and error -----------------------------------------------------------

    def _tell_error(self) -> None:
        """Own set-point from the poses, own error to the bus, unless the set-point is refused."""
        node, inputs, trajectory = self._node, self._inputs, self.trajectory
        setpoint = inputs.setpoint
        if setpoint is None or not inputs.setpoint_complete:
            return
        before, rate_before = trajectory.theta + self._displacement, trajectory.rate
        cartesian = setpoint_of(setpoint, inputs.second_setpoint)
        solve, extras = self._solver.solve, setpoint.extras  # a frame without its bit has no part
        if extras & JOINT_SETPOINT_BELONGS and inputs.joint_setpoint is not None:
            given = (inputs.joint_setpoint, inputs.second_joint_setpoint)
            solve = self._solver.given(cartesian, *given)
        theta = trajectory.tick(cartesian, solve)
        if math.isnan(theta):
            return  # refused as a whole: counted as a missing set-point at the next SYNC
        displacement = (inputs.displacement or 0.0) if extras & COMPLY_BELONGS else 0.0
        theta += displacement
        error, rate = theta - self.theta, trajectory.rate - self.speed
        if not self._rows.selection:  # while it complies, only the commanded motion has a rate
            rate += (displacement - self._displacement) / self._period
            if self._runs_away(error, self.theta):
                return
        acceleration = trajectory.acceleration
        try:
            frame = self._error.frame(error, rate, acceleration, node.cycle & 0xFF)
        except EncodeError:
            frame = None  # beyond the range of the signal: treated as a step
        if frame is None or abs(theta - before) > self._max_step * (1 + self._cycles_held):
            bound = self._max_step * (1 + self._cycles_held)
            cause = self._master._replace(bound=bound)
            node.miss(FaultCode.SETPOINT_STEP, cause, theta - before)
            self._begin_stop(before, rate_before)  # nothing of the step may act
            return
        self._cycles_held = 0
        self._displacement = displacement
        bias = inputs.bias if extras & BIAS_BELONGS else None
        self._bias = self.servo.deliverable_bias(bias) if bias else 0.0
        node.ladder.clear(_SETPOINT_MISSING)
        node.send(frame)
        inputs.take_error(self._index, error, rate, acceleration)

    # --- 3. torque ----------------------------------------------------------------------------

    def _servo_torque(self) -> float:
        """Torque of Eq. 5.11 as corrected, without the bias, Nm."""
        inputs, rows, servo = self._inputs, self._rows, self.servo
        desired = self.trajectory.rate
        if rows.selection:
            friction = servo.friction.complying(
                desired, self.speed, servo.state.intended_speed, self._node.cycle
            )
        else:
            friction = servo.friction.rigid(desired)
        return servo.torque(
            inputs.errors,
            inputs.rates,
            inputs.accelerations,
            rows,
            rows.gravity,
            friction,
            self._bias,
        )

    def _follow_ramp(self) -> None:
        """QUICKSTOP (R2): own joint along its ramp, then hold, with gravity compensation."""
        ramp, rows, servo = self.ramp, self._rows, self.servo
        assert ramp is not None, "QUICKSTOP begins with a ramp"
        ramp.step()
        ramp.watch(self.theta)
        error = ramp.position - self.theta
        if self._runs_away(error, self.theta):
            return
        torque = servo.alone(
            error,
            ramp.speed - self.speed,
            rows.gravity,
            servo.friction.rigid(ramp.speed),
            rows.own_inertia * ramp.acceleration,
        )
        self._drive(torque)

    def _runs_away(self, error: float, angle: float) -> bool:
        """Watch a rigid joint's error and angle, rad; whether its torque had to go off (R4)."""
        if not self._runaway.watch(error, angle):
            return False
        node = self._node
        cause = Cause(node.number, node.wire.id(Measure, node.number), self._runaway.bound)
        node.trip(FaultCode.RUNAWAY, cause, error)
        return True

    @property
    def homes(self) -> bool:
        """Whether REFERENCE is used: the bus homes, and the joint searches its index or holds."""
        return self.action.torque is _HOMING or self.action.torque is _HOLD

    @property
    def drives(self) -> bool:
        """Whether DAC goes out."""
        return self.action.torque is not _NOTHING

    def _home(self) -> None:
        """Homing: find the index, then hold there, while the bus homes."""
        node, inputs, homing = self._node, self._inputs, self.homing
        measure, reference = inputs.measure, inputs.reference
        assert measure is not None and reference is not None
        inputs.reference = None
        if not homing.engaged:  # the joint was braked until now, and may be anywhere
            self.servo.reset()
            self._runaway.reset()
        torque = homing.step(measure, reference, self.speed, self._rows.gravity)
        failure = homing.failure
        if failure is not None:
            identifier = node.wire.id(failure.record, node.number)
            cause = self._board._replace(frame=identifier, bound=failure.bound)
            node.trip(FaultCode.HOMING_FAILED, cause, failure.value)
            return
        if self._runs_away(homing.error, self.encoder.angle(measure.counts)):
            return
        if homing.found and node.state is NodeState.HOMING:
            node.change(Event.HOMED)
            self._runaway.reset()  # angles are counted from another zero now
            self.theta = self.encoder.angle(measure.counts)
        self._drive(torque)

    def _drive(self, torque: float, bias: float = 0.0) -> None:
        """Torques to DAC codes: the servo's is a motor current, the bias a force set-point."""
        inputs, servo = self._inputs, self.servo
        self.torque = torque + bias
        inputs.dac_due = False
        self._node.send(
            self._dac.frame(servo.code(torque), servo.force_code(bias), inputs.sampled_in)
        )
        if self._sink is not None:
            self._sink(self._node.cycle, servo.terms)

    def drop_torque(self) -> None:
        """Drop the torque immediately (R4): one DAC frame with zero, and no more after it.

        The plant brakes a joint without DAC.
        """
        self._decide()
        self.servo.terms = ServoTerms()
        self._drive(0.0)

    # --- changes of state ---------------------------------------------------------------------

    def _decide(self) -> None:
        """What to do now, by the table."""
        node = self._node
        self.action: StateAction = STATE_ACTIONS[node.state][node.reaction][node.bus_state]

    def enter(self, state: NodeState) -> None:
        """The node's state has changed."""
        self._decide()
        begin = _ENTRY[state]
        if begin is not None:
            begin(self)

    def _forget_cycle(self) -> None:
        """A master that starts over numbers its sets from the beginning, and owes no cycle."""
        self._rows.clear()
        self._inputs.begin(dac_due=False)

    def _begin_homing(self) -> None:
        self._runaway.reset()
        self.homing.begin()
        self.servo.reset()

    def _begin_servo(self) -> None:
        """Hold where the joint is, without a past."""
        self.servo.reset()
        self._runaway.reset()
        self.trajectory.reset(self.theta)
        self._inputs.begin(dac_due=False)  # what the others told before START counts for nothing
        self._cycle = -1
        self._cycles_held = 0
        self._bias = self._displacement = 0.0

    def _begin_quickstop(self) -> None:
        self._begin_stop(self.trajectory.theta + self._displacement, self.trajectory.rate)
        inputs = self._inputs
        if inputs.measure is not None and not inputs.new_sample:
            inputs.dac_due = False  # the ramp begins with the next sample: nothing is missing

    def _begin_stop(self, position: float, speed: float) -> None:
        """Begin the controlled stop; it ends inside the range, by braking harder if it must."""
        bound = self._position_max if speed > 0.0 else self._position_min
        room = max(abs(bound - position), self._count_rad)
        deceleration = max(self._acceleration_limit, speed * speed / (2.0 * room))
        self.ramp = StopRamp(position, speed, deceleration, self._period)
        self._runaway.reset()

    # --- cycles that lacked something ---------------------------------------------------------

    def _judge(self) -> None:
        """The cycle that is over: count what it lacked."""
        node, inputs = self._node, self._inputs
        if inputs.dac_due:
            self._count_missed_cycle()
        elif inputs.setpoint_due:
            if inputs.setpoint is None:
                node.miss(FaultCode.SETPOINT_MISSING, self._master)
            else:
                node.ladder.clear(_SETPOINT_MISSING)

    def _count_missed_cycle(self) -> None:
        """The cycle before ended without its DAC frame: R1 holds; the ladder counts what lacked.

        The plant holds the last DAC code by itself; the trajectory must not lose the cycle.
        """
        node, inputs = self._node, self._inputs
        if inputs.measure is None:
            node.miss(FaultCode.MEASURE_MISSING, self._board)
        elif not inputs.heard & self._own_bit:
            node.miss(FaultCode.SETPOINT_MISSING, self._master)
        else:
            silent = next((joint for joint in JOINTS if not inputs.heard & 1 << joint - 1), None)
            if silent is not None:  # all six came where a command ended the servo in mid-cycle
                node.miss(FaultCode.ERROR_MISSING, Cause(silent, node.wire.id(JointError, silent)))
            return
        self._hold()

    def _hold(self) -> None:
        """A cycle without a set-point (R1): the last one stays, its history goes on."""
        self.trajectory.miss()
        self._cycles_held += 1


_ENTRY: Final = complete(
    {
        NodeState.INIT: None,
        NodeState.PREOP: JointController._forget_cycle,
        NodeState.HOMING: JointController._begin_homing,
        NodeState.READY: None,
        NodeState.OPERATIONAL: JointController._begin_servo,
        NodeState.QUICKSTOP: JointController._begin_quickstop,
        NodeState.FAULT: None,
    },
    NodeState,
)
"""What begins with a state."""

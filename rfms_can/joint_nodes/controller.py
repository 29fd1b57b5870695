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
from rfms_can.joint_nodes.detectors.following import Excess
from rfms_can.joint_nodes.detectors.plausible_rows import RowsWatch
from rfms_can.joint_nodes.detectors.setpoint_step import StepWatch
from rfms_can.joint_nodes.field_node import Cause, FieldNode, Parameters
from rfms_can.joint_nodes.homing import Homing
from rfms_can.joint_nodes.inputs import ALL_ERRORS, CycleInputs
from rfms_can.joint_nodes.motion_watch import MotionWatch
from rfms_can.joint_nodes.sensing import JointSensing, Motion
from rfms_can.joint_nodes.servo import Servo, ServoTerms
from rfms_can.joint_nodes.state_actions import STATE_ACTIONS, StateAction, TorqueSource
from rfms_can.joint_nodes.states import Event
from rfms_can.joint_nodes.stop_ramp import StopPlan, StopRamp
from rfms_can.setpoint import JointSetpoint
from rfms_can.setpoint.frames import setpoint_of
from rfms_can.tables import complete
from rfms_can.wire.contract import (
    BIAS_BELONGS,
    COMPLY_BELONGS,
    JOINT_SETPOINT_BELONGS,
    LAST_CYCLE,
)
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
_ROWS_IMPLAUSIBLE: Final = FaultCode.ROWS_IMPLAUSIBLE


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
        torque: last commanded torque, Nm.
        sensing, motion, servo, homing, trajectory: its parts.
        ramp: of the controlled stop; None before the first.
    """

    __slots__ = (
        "_bias",
        "_board",
        "_cycle",
        "_cycles_lost",
        "_dac",
        "_displacement",
        "_error",
        "_index",
        "_inputs",
        "_master",
        "_node",
        "_own_bit",
        "_period",
        "_rows",
        "_rows_watch",
        "_sink",
        "_solver",
        "_steps",
        "_stop_plan",
        "action",
        "homing",
        "motion",
        "ramp",
        "sensing",
        "servo",
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
        self.servo = Servo(p, node.number)
        self.sensing = JointSensing(node, p, self._commanded, self._encoder_jumped)
        self.homing = Homing(p, self.sensing.encoder, self.servo)
        self.trajectory = JointSetpoint(self._period)
        self._rows_watch = RowsWatch(p, node.number)
        self.motion = MotionWatch(node, p)
        self._steps = StepWatch(p)
        self._stop_plan = StopPlan(p)
        self.ramp: StopRamp | None = None
        self._solver = AngleSolver(p, node.number)
        self._master = Cause(MASTER, node.wire.id(Setpoint, 1))
        self._board = Cause(int(p[Parameter.SENSOR_SOURCE]), node.wire.id(Measure, node.number))
        self.torque = 0.0
        self._bias = 0.0  # of the set-point taken last, Nm
        self._displacement = 0.0  # by compliance, rad, in the set-point taken last
        self._cycle = -1  # of the last SYNC
        self._cycles_lost = 0  # SYNCs that the watchdog has missed since the last one
        self._sink: Callable[[int, ServoTerms], None] | None = None
        self._decide()

    def record_terms(self, sink: Callable[[int, ServoTerms], None] | None) -> None:
        """Give the cycle and the terms of each torque to ``sink`` from now on; None ends it."""
        self._sink = sink
        self.servo.recording = sink is not None

    # --- a cycle ------------------------------------------------------------------------------

    def begin_cycle(self, sync: Sync) -> None:
        """SYNC: count what the cycle before lacked; change over to the rows it names."""
        node, inputs = self._node, self._inputs
        self.motion.bear(self.torque if self.drives else 0.0)
        self._decide()
        if self.homing.engaged and not self.homes:
            self.homing.let_go()
        self._judge()
        gap, self._cycle = self._gap(sync.cycle), sync.cycle
        # those that the watchdog of SYNC has told of are counted already
        self.sensing.cycles_unsampled += max(gap - self._cycles_lost, 1)
        self._cycles_lost = 0
        if gap > 1 and node.state is NodeState.OPERATIONAL:
            for _ in range(gap - 1):  # cycles whose SYNC never came
                self._hold()
        self._change_rows(sync.row_set)
        inputs.begin(self.action.owes_dac, self.action.expects_setpoint)

    def _gap(self, cycle: int) -> int:
        """Cycles from the last SYNC to this one; its number is a u32."""
        if self._cycle < 0:
            return min(cycle + 1, MAX_CYCLE_GAP)
        ahead = cycle - self._cycle & LAST_CYCLE
        return min(ahead, MAX_CYCLE_GAP) if ahead < LAST_CYCLE // 2 else 0

    def _change_rows(self, number: int) -> None:
        """Change over to the rows of a set, if they are here and can be."""
        node, rows = self._node, self._rows
        named = number == rows.number
        if not named:
            waiting = rows.waiting(number)
            cause = self._master._replace(frame=node.wire.id(Rows, node.number))
            if waiting is None:
                node.miss(_ROWS_MISSING, cause)
                return
            excess = self._rows_watch.excess(waiting, rows)
            if excess is not None:
                node.miss(_ROWS_IMPLAUSIBLE, cause._replace(bound=excess.bound), excess.value)
                return
            rows.activate(waiting)
        node.ladder.clear(_ROWS_MISSING)
        node.ladder.clear(_ROWS_IMPLAUSIBLE)

    def step(self) -> None:
        """The cycle, as far as the frames received so far allow; called after each of them."""
        inputs = self._inputs
        measure, sampled = inputs.measure, inputs.new_sample
        # 1. the board's sample: angle and speed; a jump or the end of the range may stop the joint
        if measure is not None and sampled:
            inputs.new_sample = False
            self.sensing.take(measure, self.action)
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
            self._drive(self.servo.damped(self.sensing.speed, self._rows.gravity))
        elif inputs.reference is not None:  # kept only while the action is to home, or to hold
            self._home()

    def lose_cycle(self) -> None:
        """No SYNC: the cycle before is over, what comes next belongs to none the node knows."""
        self.motion.bear(self.torque if self.drives else 0.0)
        self._judge()
        self.sensing.cycles_unsampled += 1
        self._cycles_lost += 1
        self._inputs.begin(dac_due=False)

    # --- 2. own set-point and error -----------------------------------------------------------

    def _tell_error(self) -> None:
        """Own set-point from the poses, own error to the bus, unless the set-point is refused."""
        node, inputs, trajectory = self._node, self._inputs, self.trajectory
        sensing, setpoint = self.sensing, inputs.setpoint
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
        error, rate = theta - sensing.theta, trajectory.rate - sensing.speed
        if not self._rows.selection:  # while it complies, only the commanded motion has a rate
            rate += (displacement - self._displacement) / self._period
            if self.motion.runs_away(error, sensing.theta):
                return
        acceleration = trajectory.acceleration
        try:
            frame = self._error.frame(error, rate, acceleration, node.cycle & 0xFF)
        except EncodeError:
            frame = None  # beyond the range of the signal: treated as a step
        excess = self._steps.excess(theta - before, trajectory.rate - rate_before)
        if frame is None or excess is not None:
            excess = excess or Excess(theta - before, self._steps.bound)
            cause = self._master._replace(bound=excess.bound)
            node.miss(FaultCode.SETPOINT_STEP, cause, excess.value)
            self._begin_stop(before, rate_before)  # nothing of the step may act
            return
        if self._rows.selection:
            self.motion.comply()
        elif self.motion.strays_servoing(error, rate):
            return
        self._steps.take()
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
                desired, self.sensing.speed, servo.state.intended_speed, self._node.cycle
            )
        else:
            friction = servo.friction.rigid(desired)
        torque = servo.torque(
            inputs.errors,
            inputs.rates,
            inputs.accelerations,
            rows,
            rows.gravity,
            friction,
            self._bias,
        )
        self.motion.push(servo.state.at_limit, self.sensing.speed)
        return torque

    def _follow_ramp(self) -> None:
        """QUICKSTOP (R2): own joint along its ramp, then hold, with gravity compensation."""
        ramp, rows, servo = self.ramp, self._rows, self.servo
        assert ramp is not None, "QUICKSTOP begins with a ramp"
        theta, speed = self.sensing.theta, self.sensing.speed
        ramp.step()
        ramp.watch(theta)
        error = ramp.position - theta
        motion = self.motion
        if motion.runs_away(error, theta) or motion.strays_stopping(error, speed):
            return
        torque = servo.alone(
            error,
            ramp.speed - speed,
            rows.gravity,
            servo.friction.rigid(ramp.speed),
            rows.own_inertia * ramp.acceleration,
        )
        motion.push(servo.state.at_limit, speed)
        self._drive(torque)

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
            self.motion.runaway.reset()
        sensing = self.sensing
        torque = homing.step(measure, reference, sensing.speed, self._rows.gravity)
        failure = homing.failure
        if failure is not None:
            identifier = node.wire.id(failure.record, node.number)
            cause = Cause(node.number, identifier, failure.bound)
            node.trip(FaultCode.HOMING_FAILED, cause, failure.value)
            return
        ended = homing.found and node.state is NodeState.HOMING
        if ended:
            self.motion.runaway.reset()  # angles are counted from another zero now
            sensing.theta = sensing.encoder.angle(measure.counts)
        if self.motion.runs_away(homing.error, sensing.encoder.angle(measure.counts)):
            return
        if ended:
            node.change(Event.HOMED)
        self._drive(torque)

    def _drive(self, torque: float, bias: float = 0.0) -> None:
        """Torques to DAC codes: the servo's is a motor current, the bias a force set-point."""
        inputs, servo = self._inputs, self.servo
        self.torque = torque + bias
        inputs.dac_due = False
        current, force = servo.code(torque), servo.force_code(bias)
        self.sensing.amplifier.drive(current, force)
        self._node.send(self._dac.frame(current, force, inputs.sampled_in))
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
        self.motion.runaway.reset()
        self.homing.begin()
        self.servo.reset()

    def _begin_servo(self) -> None:
        """Hold where the joint is, without a past."""
        self.servo.reset()
        self.motion.runaway.reset()
        self.trajectory.reset(self.sensing.theta)
        self._inputs.begin(dac_due=False)  # what the others told before START counts for nothing
        self._cycle = -1
        self._steps.reset()
        self._bias = self._displacement = 0.0

    def _begin_quickstop(self) -> None:
        self._begin_stop(self.trajectory.theta + self._displacement, self.trajectory.rate)
        inputs = self._inputs
        if inputs.measure is not None and not inputs.new_sample:
            inputs.dac_due = False  # the ramp begins with the next sample: nothing is missing

    def _commanded(self) -> Motion:
        """The motion that is commanded: by the set-point, or by the stop under way."""
        ramp = self.ramp
        if ramp is not None and self.action.torque is _STOP_RAMP:
            return ramp.position, ramp.speed
        return self.trajectory.theta + self._displacement, self.trajectory.rate

    def _encoder_jumped(self, jump: float, stopping: bool) -> None:
        """The encoder shows another place for good: stop where it says the joint is.

        A stop that is under way goes on, at the same speed: begun again and again it would never
        brake.

        Args:
            jump: by how much, rad.
            stopping: whether the joint was on its stop ramp before.
        """
        sensing, ramp = self.sensing, self.ramp
        if stopping and ramp is not None:
            ramp.position += jump
        else:
            self._begin_stop(sensing.theta, sensing.speed)

    def _begin_stop(self, position: float, rate: float) -> None:
        """Begin the controlled stop, from a commanded position, rad, and rate, rad/s."""
        sensing = self.sensing
        self.ramp = self._stop_plan.ramp(sensing.theta, sensing.speed, position, rate)
        self.motion.begin_stop(sensing.speed)

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
        self._steps.hold()


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

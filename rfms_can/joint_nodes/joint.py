"""A joint node: solves its own joint from T6, tells its error, hears the others', servos.

One cycle, in the order frames come: SYNC swaps the rows; SETPOINT and MEASURE together give the
set-point and the error, which goes out as ERROR (COMPLY and BIAS are waited for where they belong
to the set-point); when all six errors are known the compliance row
makes the real error of them, the servo a torque, and the torque goes out as DAC.
"""

import math
from functools import partial
from typing import Final

from rfms_can.arm import Arm
from rfms_can.errors import EncodeError
from rfms_can.joint_nodes.axis import Axis
from rfms_can.joint_nodes.intake import Intake
from rfms_can.kinematics import JointSolver
from rfms_can.setpoint import JointSetpoint
from rfms_can.setpoint.frames import setpoint_of
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import Bias, Comply, JointError, Setpoint, Sync
from rfms_can.wire.vocabulary import FaultCode, NodeState, Parameter

_ALL_ERRORS: Final = (1 << len(JOINTS)) - 1
_PASSED: Final = 4
"""Cycles that may pass unseen before the ladder stops the joint anyhow, and one."""


class JointNode(Axis):
    """Joint node 1 to 6."""

    def __init__(self, joint: int, wire: Wire, boot_id: int, watch_ns: int) -> None:
        super().__init__(joint, wire, boot_id, watch_ns)
        self._solver: JointSolver
        self._trajectory: JointSetpoint
        self._period: float
        self._intake = Intake()
        self._bias = 0.0  # of the set-point taken last, Nm
        self._displaced = 0.0  # by compliance, rad, in the last set-point
        self._errors = [0.0] * len(JOINTS)
        self._rates = [0.0] * len(JOINTS)
        self._accelerations = [0.0] * len(JOINTS)
        self._heard = 0
        self._begun = -1  # the cycle of the last SYNC
        self._held = 0  # cycles since the last set-point taken
        self._error = self._sends(JointError, joint)
        self._hears(Setpoint, 1, self._on_setpoint_1)
        self._hears(Setpoint, 2, self._on_setpoint_2)
        self._hears(Comply, None, self._on_comply)
        self._hears(Bias, None, self._on_bias)
        for other in JOINTS:
            if other != joint:
                self._hears(JointError, other, partial(self._on_error, other - 1))

    def _built(self, arm: Arm) -> None:
        self._solver = JointSolver(arm, self.number)
        self._period = self.parameters[Parameter.PERIOD]
        self._trajectory = JointSetpoint(self._period)

    def _entered(self, state: NodeState) -> None:
        super()._entered(state)
        if state is NodeState.OPERATIONAL:
            self._servo.reset()
            self._trajectory.reset(self.theta)
            self._errors[:] = self._rates[:] = self._accelerations[:] = [0.0] * len(JOINTS)
            self._driven = True
            self._held = 0
            self._bias = self._displaced = 0.0
        elif state is NodeState.QUICKSTOP:
            self._stop_from(self._trajectory.theta + self._displaced, self._trajectory.rate)

    # --- a cycle begins -----------------------------------------------------------------------

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
        self._forget_setpoint()
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
        if self._intake.first is None:
            self._miss(FaultCode.SETPOINT_MISSING)
        else:
            self._ladder.clear(FaultCode.SETPOINT_MISSING)

    def _without_sync(self) -> None:
        """No SYNC: what comes next belongs to no cycle we know."""
        self._age += 1
        self._forget_setpoint()
        self._heard = 0
        self._driven = True

    def _forget_setpoint(self) -> None:
        """What came for the cycle before is of no use any more."""
        self._intake.clear()
        self._measure = None

    # --- set-point, errors, torque ------------------------------------------------------------

    def _on_setpoint_1(self, setpoint: Setpoint) -> None:
        if not self._is_stale(setpoint.cycle & 0xFF, "SETPOINT"):
            self._intake.first = setpoint
            self._solve()

    def _on_setpoint_2(self, setpoint: Setpoint) -> None:
        if not self._is_stale(setpoint.cycle & 0xFF, "SETPOINT"):
            self._intake.second = setpoint
            self._solve()

    def _on_comply(self, comply: Comply) -> None:
        if not self._is_stale(comply.cycle, "COMPLY"):
            self._intake.displacement = comply[self._index]
            self._solve()

    def _on_bias(self, bias: Bias) -> None:
        if not self._is_stale(bias.cycle, "BIAS"):
            self._intake.bias = bias[self._index]
            self._solve()

    def _sampled(self) -> None:
        self._solve()

    def _solve(self) -> None:
        """SETPOINT and MEASURE are here: own set-point, own error, and tell it."""
        intake = self._intake
        first = intake.first
        if first is None or self._measure is None or self.state is not NodeState.OPERATIONAL:
            return
        if self._heard & 1 << self._index or not intake.complete:
            return
        trajectory = self._trajectory
        before, rate_before = trajectory.theta + self._displaced, trajectory.rate
        theta = trajectory.tick(setpoint_of(first, intake.second), self._solver.solve)
        if math.isnan(theta):
            return  # refused whole: counted as a missing set-point at the next SYNC
        displacement = intake.displacement or 0.0
        theta += displacement
        error, rate = theta - self.theta, trajectory.rate - self.speed
        if not self.rows.selection:  # while it complies, only the commanded motion has a rate
            rate += (displacement - self._displaced) / self._period
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
        self._displaced, self._bias = displacement, intake.bias or 0.0
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
        before, self._heard = self._heard, self._heard | 1 << index
        if self._heard == _ALL_ERRORS != before and self.state is NodeState.OPERATIONAL:
            self._ladder.clear(FaultCode.ERROR_MISSING)
            self._drive(self._command(), self._bias)

    def _command(self) -> float:
        """Torque of Eq. 5.11 as corrected, Nm."""
        servo, rows = self._servo, self.rows
        friction, desired = servo.friction, self._trajectory.rate
        if rows.selection:
            overcome = friction.complying(desired, self.speed, servo.push, self.cycle)
        else:
            overcome = friction.rigid(desired)
        return servo.torque(
            self._errors,
            self._rates,
            self._accelerations,
            rows,
            rows.gravity,
            overcome,
            self._bias,
        )

"""Force control at the end of a cycle: what complies, COMPLY, the bias force, guarded moves.

Cycle k is over: its errors are known, and the wrench. From them come the specification of the
next rows, the displacement and the bias torques that go out with the set-point of cycle k+1. Rows
act one SYNC after they have gone out, so what the nodes complied in is that of the set in force,
not that of the rows requested.
"""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from rfms_can.arm import Arm, friction_set
from rfms_can.arm.load import NOTHING
from rfms_can.compliance import LAWS, ControlLaw, LawRows, compliance_jacobian
from rfms_can.kinematics import Joints, direct, jacobian
from rfms_can.master.force.bias import BiasForce
from rfms_can.master.force.comply import Comply, Displacement
from rfms_can.master.force.guards import Guards
from rfms_can.master.force.refusal import bias_refusal, guard_refusal, load_refusal, tare_refusal
from rfms_can.master.force.specification import NO_FORCE, ForceRequest, Specification
from rfms_can.master.force.wrench import in_frame
from rfms_can.master.force.wrench_estimate import WrenchEstimate
from rfms_can.master.rows.compliance import RIGID, Compliance
from rfms_can.master.rows.math_processor import RowSet
from rfms_can.master.trajectory.commanded import CommandedTrajectory
from rfms_can.messages import Vector6
from rfms_can.transform import Transform

Matrix = npt.NDArray[np.float64]

FADE_FRACTION: Final = 0.2
"""Fraction of a joint's speed and acceleration limits that the return from compliance may take."""


class ForceSettings(NamedTuple):
    """How the arm complies.

    Attributes:
        law: the control law.
        closed: whether the force loop is closed over the wrist sensor.
        friction: name of the friction set the servos compensate.
        Kp: gains of the six nodes, N m/rad.
    """

    law: ControlLaw
    closed: bool
    friction: str
    Kp: tuple[float, ...]


class ForceControl:
    """Compliance, bias force and guarded moves, beside the set-points.

    Attributes:
        comply: COMPLY.
        wrench_estimate: the wrench of the hand on the world.
        guards: stop on force and on distance.
        compliance: what the next rows are for.
        load: in the hand.
        force: the wrench in the compliance frame of the move under way, N and N m.
        complied: displacement of its compliance frame, m and rad.
    """

    def __init__(self, arm: Arm, settings: ForceSettings, period_s: float) -> None:
        self._arm = arm
        self._law, self._closed = LAWS[settings.law], settings.closed
        self._Kp = np.array(settings.Kp)
        self._period = period_s
        self._fades = tuple(
            (FADE_FRACTION * speed * period_s, FADE_FRACTION * acceleration * period_s * period_s)
            for speed, acceleration in zip(arm.speed_limits, arm.acceleration_limits, strict=True)
        )
        limits = [drive.torque_limit for drive in arm.drives]
        self.comply = Comply(arm, period_s)
        self.wrench_estimate = WrenchEstimate(friction_set(arm, settings.friction), period_s)
        self.guards = Guards()
        self._bias = BiasForce(limits, period_s, settings.closed)
        self._request: ForceRequest | None = None
        self._correction = np.zeros(6)
        self._displacement = Displacement(period_s)
        self.force: Vector6 = NO_FORCE
        self.complied: Vector6 = NO_FORCE
        self.compliance = Compliance()
        self.load = NOTHING

    def reset(self) -> None:
        """The arm is enabled: it is rigid, without displacement."""
        self.comply.reset()
        self._bias.reset()
        self.guards.reset()
        self._request = None
        self._correction[:] = 0.0
        self.compliance = Compliance()

    def sense(
        self,
        reading: Sequence[float] | None,
        torques: Sequence[float],
        commanded: CommandedTrajectory,
        q: Sequence[float],
        rows: RowSet,
        guarded: bool,
    ) -> None:
        """Update the wrench: from the sensor, or, for a guarded move, from the joint torques.

        Args:
            reading: of the wrist sensor, N and N m (6), or None; one that was lost is not
                estimated in its place.
            torques: of the motors, Nm (6).
            commanded: the trajectory they follow.
            q: measured joint angles, rad.
            rows: the newest set: the model at the measured joint angles.
            guarded: whether the move under way is guarded, so that an estimate is needed.
        """
        estimate = self.wrench_estimate
        if reading is not None:
            estimate.read(reading, self.load, direct(self._arm, q))
        elif guarded and not estimate.sensed:
            rate, acceleration = commanded.rate, commanded.acceleration
            estimate.estimate(torques, rate, acceleration, rows.J, rows.M, rows.gravity)

    def close(
        self,
        request: ForceRequest | None,
        q: Sequence[float],
        errors: Sequence[float],
        rows: RowSet,
        in_force: Compliance,
    ) -> str | None:
        """Take what cycle k has brought.

        Args:
            request: the move under way, or None before the first; after a stop the one before.
            q: measured joint angles, rad.
            errors: joint errors, rad.
            rows: the newest set: the model at the measured joint angles.
            in_force: what the nodes complied in.

        Returns:
            Why the move is to be stopped, or None.
        """
        if request is None:
            return None
        began = self._request is None or request.sequence != self._request.sequence
        self._request = request
        if began and not request.specification.guard.active:
            self.wrench_estimate.discard()
        if not began and self._is_idle(request.specification, in_force):
            return None
        T6 = direct(self._arm, q)
        frame = request.frame(T6)
        self._specify(request.specification, frame)
        self.force = in_frame(self.wrench_estimate.wrench, frame)
        J = compliance_jacobian(rows.J, frame)
        if in_force.selection.size:
            J_in_force = compliance_jacobian(rows.J, in_force.frame)
            self.comply.accumulate(errors, J_in_force, in_force.selection, in_force.frame)
        elif request.specification.selection == RIGID:
            least = round(2.0 * request.acceleration_time / self._period)
            self.comply.fade(self._fades, least)
        self.complied = self.comply.amount(frame)
        self._displacement.update(self.complied)
        self._exert(request.specification, J, q, errors, frame, rows.law)
        if began:
            self.guards.begin(request.specification.guard, T6, frame)
        return self.guards.watch(request.sequence, self.force, T6)

    def refusal(self, request: ForceRequest, theta: Joints, rests: bool) -> str | None:
        """Why the request of a move is refused, or None.

        Args:
            request: the move.
            theta: joint angles it is judged at, rad.
            rests: whether the arm rests there now, so that the wrench is the one it would start in.
        """
        specification = request.specification
        load, guarded = specification.load, specification.guard.active
        if self._closed and self._law.complies:
            refusal = tare_refusal(specification.selection, self.wrench_estimate)
            if refusal:
                return refusal
        if not guarded and specification.bias == NO_FORCE and load is None:
            return None
        T6 = direct(self._arm, theta)
        frame = request.frame(T6)
        at_T6 = np.array(jacobian(self._arm, theta))
        limits = [drive.torque_limit for drive in self._arm.drives]
        return (
            load_refusal(at_T6, load, T6, limits)
            or bias_refusal(compliance_jacobian(at_T6, frame), specification.bias, limits)
            or guard_refusal(
                specification.guard, self.wrench_estimate, at_T6, frame, self._arm, rests
            )
        )

    def follow(self, theta: Joints) -> tuple[float, ...] | None:
        """Joint displacements beside the commanded ``theta``, rad (6); None if there is none."""
        if not self.comply.active:
            return None
        return self.comply.follow(theta)

    @property
    def bias(self) -> list[float] | None:
        """Bias torques, Nm (6); None if all are zero."""
        if not self._bias.active and not self._correction.any():
            return None
        torque: list[float] = (self._bias.torque + self._correction).tolist()
        return torque

    def _is_idle(self, specification: Specification, in_force: Compliance) -> bool:
        """Whether there is nothing to do: the arm is rigid, and its wrench is not needed."""
        return (
            specification.selection == RIGID == in_force.selection
            and not specification.guard.active
            and not self.wrench_estimate.sensed
            and not self.comply.active
            and not self._bias.active
        )

    def _specify(self, specification: Specification, frame: Transform) -> None:
        """What the next rows are for; a frame that moves with the arm is followed."""
        selection, now = specification.selection, self.compliance
        if specification.load is not None and specification.load != self.load:
            self.load = specification.load
            self.compliance = now = now.changed(now.selection, now.frame)
        if selection != now.selection or (selection.size and _has_moved(frame, now.frame)):
            self.compliance = now.changed(selection, frame)
            self._bias.begin()
        elif selection.size:
            self.compliance = now._replace(frame=frame)

    def _exert(
        self,
        specification: Specification,
        J: Matrix,
        q: Sequence[float],
        errors: Sequence[float],
        frame: Transform,
        law_rows: LawRows | None,
    ) -> None:
        """The torques of the bias force, and the law's correction of the error, if it has one."""
        selection = specification.selection
        self._correction[:] = 0.0
        if not selection.size or not self._law.complies:
            self._bias.relax()
            return
        self._bias.update(J, selection, specification.bias, self.force, self._displacement.mean)
        correction = self._law.correction
        if correction is not None and law_rows is not None:
            self._correction = self._Kp * correction(
                self._arm, q, errors, frame, J, law_rows.errors
            )


def _has_moved(a: Transform, b: Transform) -> bool:
    """Whether a compliance frame is a different one, and not the same a cycle later."""
    return any(abs(x - y) > 0.02 for x, y in zip(a, b, strict=True))

"""Force control at the end of a cycle: what complies, COMPLY, the bias force, guarded moves.

Cycle k is over: its errors are known, and the wrench. From them come the specification of the
next rows, the displacement and the bias torques that go out with the set-point of cycle k+1. Rows
act one SYNC after they have gone out, so what the nodes complied in is that of the set in force,
not that of the rows asked for.
"""

from collections.abc import Callable, Sequence
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from rfms_can.arm import Arm, friction_set
from rfms_can.compliance import LAWS, ControlLaw, compliance_jacobian
from rfms_can.kinematics import Joints, direct, jacobian
from rfms_can.master.force.bias import BiasForce
from rfms_can.master.force.comply import Comply, Displacement
from rfms_can.master.force.guards import Guards
from rfms_can.master.force.refusal import bias_refusal, guard_refusal, load_refusal, tare_refusal
from rfms_can.master.force.specification import (
    NO_FORCE,
    RIGID,
    Compliance,
    Specification,
)
from rfms_can.master.force.wrench import in_frame
from rfms_can.master.force.wrench_estimate import WrenchEstimate
from rfms_can.master.math_processor import MathProcessor
from rfms_can.master.trajectory.commanded import CommandedTrajectory
from rfms_can.messages import Vector6
from rfms_can.transform import Transform

Matrix = npt.NDArray[np.float64]

FADE_FRACTION: Final = 0.2
"""Fraction of a joint's speed and acceleration limits that the return from compliance may take."""


class Asked(NamedTuple):
    """The move under way, as force control sees it.

    Attributes:
        sequence: its number.
        specification: what it asks for.
        frame: its compliance frame in T6, for a pose of T6.
        acceleration_time: t_acc, s.
    """

    sequence: int
    specification: Specification
    frame: Callable[[Transform], Transform]
    acceleration_time: float


class Settings(NamedTuple):
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
    """What the master does beside the set-points.

    Attributes:
        comply: COMPLY.
        wrench_estimate: the wrench of the hand on the world.
        guards: stop on force and on distance.
        force: the wrench in the compliance frame of the move under way, N and N m.
        complied: displacement of its compliance frame, m and rad.
    """

    def __init__(self, arm: Arm, math: MathProcessor, settings: Settings, period_s: float) -> None:
        self._arm = arm
        self._math = math
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
        self._asked: Asked | None = None
        self._extra = np.zeros(6)
        self._displacement = Displacement(period_s)
        self.force: Vector6 = NO_FORCE
        self.complied: Vector6 = NO_FORCE

    def reset(self) -> None:
        """The arm is enabled: it is rigid, without displacement."""
        self.comply.reset()
        self._bias.reset()
        self.guards.reset()
        self._asked = None
        self._extra[:] = 0.0
        self._math.compliance = Compliance()

    def sense(
        self,
        reading: Sequence[float] | None,
        torques: Sequence[float],
        commanded: CommandedTrajectory,
        q: Sequence[float],
        guarded: bool,
    ) -> None:
        """Update the wrench: from the sensor, or, for a guarded move, from the joint torques.

        Args:
            reading: of the wrist sensor, N and N m (6), or None; one that was lost is not
                estimated in its place.
            torques: of the motors, Nm (6).
            commanded: the trajectory they follow.
            q: measured joint angles, rad.
            guarded: whether the move under way is guarded; else nothing met stops it.
        """
        dynamics, estimate = self._math.dynamics, self.wrench_estimate
        if reading is not None:
            estimate.read(reading, dynamics.load, direct(self._arm, q))
        elif guarded and not estimate.sensed:
            estimate.estimate(
                torques,
                commanded.rate,
                commanded.acceleration,
                dynamics.J,
                dynamics.M,
                dynamics.g,
            )
        if not guarded:
            self.guards.end()

    def close(
        self, asked: Asked | None, q: Sequence[float], errors: Sequence[float], in_force: Compliance
    ) -> str | None:
        """Take what cycle k has brought.

        Args:
            asked: the move under way, or None before the first; after a stop the one before.
            q: measured joint angles, rad.
            errors: joint errors, rad.
            in_force: what the rows complied in.

        Returns:
            Why the move is to be stopped, or None.
        """
        if asked is None:
            return None
        began = self._asked is None or asked.sequence != self._asked.sequence
        self._asked = asked
        if began and not asked.specification.guard.active:
            self.wrench_estimate.discard()
        if not began and self._is_idle(asked.specification, in_force):
            return None
        T6 = direct(self._arm, q)
        frame = asked.frame(T6)
        self._specify(asked.specification, frame)
        self.force = in_frame(self.wrench_estimate.wrench, frame)
        J = compliance_jacobian(self._math.dynamics.J, frame)
        if in_force.selection.size:
            there = compliance_jacobian(self._math.dynamics.J, in_force.frame)
            self.comply.accumulate(errors, there, in_force.selection, in_force.frame)
        elif asked.specification.selection == RIGID:
            least = round(2.0 * asked.acceleration_time / self._period)
            self.comply.fade(self._fades, least)
        self.complied = self.comply.amount(frame)
        self._displacement.update(self.complied)
        self._push(asked.specification, J, q, errors, frame)
        if began:
            self.guards.begin(asked.specification.guard, T6, frame)
        return self.guards.watch(asked.sequence, self.force, T6)

    def refusal(self, asked: Asked, theta: Joints, rests: bool) -> str | None:
        """Why what a move asks for cannot be done, or None.

        Args:
            asked: the move.
            theta: joint angles it is judged at, rad.
            rests: whether the arm rests there now, so that the wrench is the one it would start in.
        """
        specification = asked.specification
        load, guarded = specification.load, specification.guard.active
        if self._closed and self._law.complies:
            refusal = tare_refusal(specification.selection, self.wrench_estimate)
            if refusal:
                return refusal
        if not guarded and specification.bias == NO_FORCE and load is None:
            return None
        T6 = direct(self._arm, theta)
        frame = asked.frame(T6)
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
        """Joint displacements beside the commanded ``theta`` (6, rad); None if there are none.

        Raises:
            KinematicsError: the displaced pose cannot be reached.
        """
        if not self.comply.active:
            return None
        return self.comply.follow(theta)

    @property
    def bias(self) -> list[float] | None:
        """Bias torques, Nm (6); None if there are none."""
        if not self._bias.active and not self._extra.any():
            return None
        torque: list[float] = (self._bias.torque + self._extra).tolist()
        return torque

    def _is_idle(self, specification: Specification, in_force: Compliance) -> bool:
        """Whether there is nothing to do: the arm is rigid, and nobody asks what it meets."""
        return (
            specification.selection == RIGID == in_force.selection
            and not specification.guard.active
            and not self.wrench_estimate.sensed
            and not self.comply.active
            and not self._bias.active
        )

    def _specify(self, specification: Specification, frame: Transform) -> None:
        """What the next rows are for; a frame that moves with the arm is followed."""
        math, selection = self._math, specification.selection
        now = math.compliance
        if specification.load is not None and specification.load != math.dynamics.load:
            math.dynamics.carry(specification.load)
            math.compliance = now = now.changed(now.selection, now.frame)
        if selection != now.selection or (selection.size and _is_elsewhere(frame, now.frame)):
            math.compliance = now.changed(selection, frame)
            self._bias.begin()
        elif selection.size:
            math.compliance = now._replace(frame=frame)

    def _push(
        self,
        specification: Specification,
        J: Matrix,
        q: Sequence[float],
        errors: Sequence[float],
        frame: Transform,
    ) -> None:
        selection = specification.selection
        self._extra[:] = 0.0
        if not selection.size or not self._law.complies:
            self._bias.relax()
            return
        self._bias.update(J, selection, specification.bias, self.force, self._displacement.mean)
        correction, rows = self._law.correction, self._math.complying.last
        if correction is not None and rows is not None:
            self._extra = self._Kp * correction(self._arm, q, errors, frame, J, rows.errors)


def _is_elsewhere(a: Transform, b: Transform) -> bool:
    """Whether a compliance frame is another one, and not the same a cycle later."""
    return any(abs(x - y) > 0.02 for x, y in zip(a, b, strict=True))

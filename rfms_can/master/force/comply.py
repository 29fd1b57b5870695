"""COMPLY: the displacement that compliance allows, as a transform of the position equation (V.5).

T6 = L D(r) COMPLY R: what the nodes ignore of their errors, -S J dtheta in the compliance frame, is
added to COMPLY each cycle, so that the set-point follows the compliant displacement. The commanded
trajectory itself, its rate and acceleration, stays free of it: encoder counts differenced twice
would be accelerations of thousands of codes. What travels is the difference it makes in each joint.

Near a singular pose, and where there is no pose, the displacement goes as far as it can (damped
least squares): what the arm has not followed goes on being ignored, as an error in a direction that
complies. Limits of the joints' speed and acceleration are kept by ``master/trajectory/lag.py``,
for displacement and commanded trajectory together.
"""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
import numpy.typing as npt

from rfms_can.arm import Arm
from rfms_can.compliance.selection import Selection
from rfms_can.errors import KinematicsError
from rfms_can.kinematics import (
    InverseKinematics,
    Joints,
    configuration_of,
    direct,
    jacobian,
    nearest_singularity,
)
from rfms_can.master.force.fade import Fade
from rfms_can.messages import Vector6
from rfms_can.transform import Transform, motion_of

Matrix = npt.NDArray[np.float64]

MAX_DISPLACEMENT: Final = 0.2
"""Largest displacement, m: beyond it compliance has failed."""
MAX_ROTATION: Final = 0.6
"""The same, rad."""
FILTER_TIME_S: Final = 0.012
"""Time constant of the displacement per cycle, s."""
MAX_SPEED: Final = 0.25
"""Largest speed, m/s, at which set-points follow the compliant displacement."""
MAX_ANGULAR_SPEED: Final = 1.25
"""The same, rad/s."""
SINGULAR: Final = 0.05
"""Margin (sine, part of a2) under which the arm counts as singular."""
DAMPING: Final = 0.05
"""Of the least squares there, in the units of the Jacobian (m and 1)."""
_UNITS: Final = np.eye(6)
_IDENTITY: Final = Transform.identity()


class Comply:
    """COMPLY of one arm, and the joint displacements that it means.

    Args:
        arm: the arm.
        period_s: control period, s.

    Attributes:
        transform: COMPLY, seen from T6: the displaced T6 is the commanded one times this.
        displacement: what it makes of the joint angles, rad (6), at the last set-point.
    """

    __slots__ = (
        "_arm",
        "_fade",
        "_max_rotation_step",
        "_max_step",
        "_solve",
        "displacement",
        "transform",
    )

    def __init__(self, arm: Arm, period_s: float) -> None:
        self._arm = arm
        self._max_step = MAX_SPEED * period_s
        self._max_rotation_step = MAX_ANGULAR_SPEED * period_s
        self._solve = InverseKinematics(arm).solve
        self.reset()

    def reset(self) -> None:
        """No displacement."""
        self.transform = _IDENTITY
        self.displacement: tuple[float, ...] = (0.0,) * 6
        self._fade: Fade | None = None

    @property
    def active(self) -> bool:
        """Whether set-points are displaced."""
        return self.transform is not _IDENTITY

    @property
    def fading(self) -> bool:
        """Whether the set-point is returning to the commanded trajectory."""
        return self._fade is not None

    def accumulate(
        self, errors: Sequence[float], J: Matrix, selection: Selection, E: Transform
    ) -> None:
        """Add what the nodes ignore of their errors to COMPLY.

        Where compliance begins under load all of an error is ignored at once. A set-point must not
        jump there; what is left of it goes on being ignored, and is taken in the next cycles.

        Args:
            errors: the six joint errors, rad: set-point less encoder. The set-point is the one that
                was asked for, also where the joints lag behind it.
            J: (6, 6), Jacobian of the compliance frame.
            selection: what complies in the cycle of these errors.
            E: the compliance frame in T6.
        """
        if self._fade is not None:
            self._fade = None  # complies again before it was back: go on from here
        dx, dy, dz, rx, ry, rz = np.where(selection.mask, -(J @ errors), 0.0).tolist()
        distance, angle = math.hypot(dx, dy, dz), math.hypot(rx, ry, rz)
        fraction = 1.0 / max(1.0, distance / self._max_step, angle / self._max_rotation_step)
        step = Transform.translation(fraction * dx, fraction * dy, fraction * dz)
        if angle > 0.0:
            axis = (rx / angle, ry / angle, rz / angle)
            step = step @ Transform.rotation(axis, fraction * angle)
        self.transform = _rigid(self.transform @ E @ step @ E.inverse())

    def fade(self, limits: Sequence[tuple[float, float]], least: int) -> None:
        """Let the set-point go back to the commanded trajectory, once the arm is rigid.

        Args:
            limits: speed and acceleration of each joint that it may add, per cycle and cycle^2.
            least: cycles it takes at least.
        """
        if self.active and self._fade is None:
            self._fade = Fade(self.displacement, limits, least)

    def follow(self, theta: Joints) -> tuple[float, ...]:
        """The joint displacements beside the commanded joint angles ``theta``, rad."""
        if not self.active:
            return self.displacement
        if self._fade is not None:
            self.displacement = self._fade.step()
            if self._fade.over:
                self.reset()
            else:
                self.transform = self._remaining(theta)
            return self.displacement
        self.displacement = self._goal(theta)
        return self.displacement

    def _goal(self, theta: Joints) -> tuple[float, ...]:
        """The displacement that is COMPLY, or as much of it as a singular arm can follow, rad."""
        near = [t + d for t, d in zip(theta, self.displacement, strict=True)]
        arm = self._arm
        if abs(nearest_singularity(arm, near).margin) > SINGULAR:
            pose = direct(arm, theta) @ self.transform
            try:
                q = self._solve(pose, configuration_of(arm, near), near)
            except KinematicsError:
                return self.displacement  # where it cannot be held it goes no further
            return tuple(a - b for a, b in zip(q, theta, strict=True))
        q1, q2, q3, q4, q5, q6 = near
        here = direct(arm, (q1, q2, q3, q4, q5, q6))
        left = motion_of(here.inverse() @ direct(arm, theta) @ self.transform)
        J = np.array(jacobian(arm, near))
        step = J.T @ np.linalg.solve(J @ J.T + DAMPING**2 * _UNITS, left)
        return tuple((np.array(self.displacement) + step).tolist())

    def _remaining(self, theta: Joints) -> Transform:
        """What remains of COMPLY while it fades: complying again goes on from there."""
        q1, q2, q3, q4, q5, q6 = (t + d for t, d in zip(theta, self.displacement, strict=True))
        displaced = direct(self._arm, (q1, q2, q3, q4, q5, q6))
        return _rigid(direct(self._arm, theta).inverse() @ displaced)

    def amount(self, E: Transform) -> Vector6:
        """Displacement of the compliance frame, along its own axes: m and rad (6)."""
        return motion_of(E.inverse() @ self.transform @ E)

    def limit_violation(self) -> str | None:
        """Why the displacement is too large, or None."""
        x, y, z, rx, ry, rz = motion_of(self.transform)
        distance, turn = math.hypot(x, y, z), math.hypot(rx, ry, rz)
        if distance <= MAX_DISPLACEMENT and turn <= MAX_ROTATION:
            return None
        return (
            f"{self._displacement_text}, {MAX_DISPLACEMENT:g} m and {MAX_ROTATION:g} rad at most: "
            f"comply only where the task holds the arm, or stop it by a distance; is the mass in "
            f"its mode what it holds?"
        )

    @property
    def _displacement_text(self) -> str:
        """How far it has gone, in words."""
        x, y, z, rx, ry, rz = motion_of(self.transform)
        distance, turn = math.hypot(x, y, z), math.hypot(rx, ry, rz)
        return f"compliance has displaced the arm by {distance:.3f} m and {turn:.2f} rad"


class Displacement:
    """Displacement of the compliance frame per cycle, low-pass filtered: encoder counts are steps.

    Args:
        period_s: control period, s.

    Attributes:
        mean: m and rad a cycle, along its axes (6).
    """

    def __init__(self, period_s: float) -> None:
        self._gain = period_s / (FILTER_TIME_S + period_s)
        self._last = np.zeros(6)
        self.mean: Matrix = np.zeros(6)

    def update(self, complied: Vector6) -> None:
        """Where it is now, as :meth:`Comply.amount` has it."""
        now = np.array(complied)
        self.mean += self._gain * (now - self._last - self.mean)
        self._last = now


def _rigid(pose: Transform) -> Transform:
    """The pose with o and a unit and upright on one another: products wear them off."""
    return Transform.from_o_a_p(
        (pose.ox, pose.oy, pose.oz), (pose.ax, pose.ay, pose.az), (pose.px, pose.py, pose.pz)
    )

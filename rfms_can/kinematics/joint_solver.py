"""The inverse solution of one joint, computed by a joint node each cycle from T6 alone."""

import math
from typing import Final

from rfms_can.errors import KinematicsError
from rfms_can.kinematics.closed_form import WIRE, ClosedForm, CosSin, Tolerance
from rfms_can.kinematics.configuration import Configuration
from rfms_can.kinematics.geometry import Geometry
from rfms_can.kinematics.limits import nearest_turn
from rfms_can.kinematics.refusal import limit_error, reach_error
from rfms_can.transform import Transform


class JointSolver:
    """One joint's angle from T6, exact: every sine it needs is of this T6, none of the last.

    The formulas, and so every digit of the result, are those of the full solution. Joints 4, 5
    and 6 need theta4 where the wrist is singular. Each keeps its own copy, updated by every regular
    T6 it solves: nodes receive the same set-points and so hold the same theta4. Before the first
    solution it is the angle given to ``hold`` (theta4 is on the bus, in MEASURE 4), else zero.
    """

    __slots__ = ("_angle", "_form", "_held", "_lower", "_upper", "arm", "joint")

    def __init__(self, arm: Geometry, joint: int, tolerance: Tolerance = WIRE) -> None:
        """The solver of ``joint`` (1 to 6)."""
        self.arm: Final = arm
        self.joint: Final = joint
        self._form: Final = ClosedForm(arm, tolerance.reach)
        lower, upper = arm.joint_limits[joint - 1]
        self._lower: Final = lower - tolerance.angle
        self._upper: Final = upper + tolerance.angle
        self._held: CosSin = (1.0, 0.0)
        self._angle: Final = (
            *(self._theta1, self._theta2, self._theta3),
            *(self._theta4, self._theta5, self._theta6),
        )[joint - 1]

    def solve(self, t6: Transform, configuration: Configuration, previous: float) -> float:
        """The joint's angle, radians: the turn nearest to ``previous`` inside the range.

        Returns:
            The angle; NaN without a solution (out of reach, out of range, or a T6 refused by
            ``Transform.from_o_a_p``). Never raises: a node calls this with received data.
            ``refusal`` gives the reason.
        """
        angle = self._angle(t6, configuration)
        return nearest_turn(angle, previous, self._lower, self._upper)

    def hold(self, theta4: float) -> None:
        """Set the held theta4 (radians), from its encoder, before the first set-point."""
        self._held = (math.cos(theta4), math.sin(theta4))

    def refusal(self, t6: Transform, configuration: Configuration) -> KinematicsError | None:
        """Why ``solve`` returns NaN, by name, number and bound; None if T6 has a solution."""
        refusal = reach_error(self.arm, t6, self._form)
        if refusal is not None:
            return refusal
        held = self._held
        angle = self._angle(t6, configuration)
        self._held = held
        if math.isnan(nearest_turn(angle, 0.0, self._lower, self._upper)):
            return limit_error(self.arm, self.joint, angle)
        return None

    def _theta1(self, t6: Transform, configuration: Configuration) -> float:
        form = self._form
        c1, s1 = form.waist(t6, form.v114(t6, configuration[0]))
        return math.atan2(s1, c1)

    def _theta2(self, t6: Transform, configuration: Configuration) -> float:
        form, pz = self._form, t6[11]
        v114 = form.v114(t6, configuration[0])
        _, k, m = form.triangle(v114, pz, configuration[1])
        return form.theta2(v114, pz, k, m)

    def _theta3(self, t6: Transform, configuration: Configuration) -> float:
        form = self._form
        rho2, _, m = form.triangle(form.v114(t6, configuration[0]), t6[11], configuration[1])
        return form.theta3(rho2, m)

    def _theta4(self, t6: Transform, configuration: Configuration) -> float:
        (c4, s4), *_ = self._wrist(t6, configuration)
        return math.atan2(s4, c4)

    def _theta5(self, t6: Transform, configuration: Configuration) -> float:
        _, (c5, s5), *_ = self._wrist(t6, configuration)
        return math.atan2(s5, c5)

    def _theta6(self, t6: Transform, configuration: Configuration) -> float:
        roll, bend, waist, forearm = self._wrist(t6, configuration)
        return self._form.theta6(t6, waist, forearm, roll, bend)

    def _wrist(
        self, t6: Transform, configuration: Configuration
    ) -> tuple[CosSin, CosSin, CosSin, CosSin]:
        """Cosines and sines of theta4, theta5, theta1 and theta23; refreshes the held theta4."""
        left, up, noflip = configuration
        form, pz = self._form, t6[11]
        v114 = form.v114(t6, left)
        rho2, k, m = form.triangle(v114, pz, up)
        waist = form.waist(t6, v114)
        forearm = form.forearm(v114, pz, rho2, k, m)
        v313, v323, c5 = form.approach(t6, waist, forearm)
        roll = c4, s4 = form.roll(v313, v323, noflip, self._held)
        if not math.isnan(c4):  # a set-point without a solution does not determine theta4
            self._held = roll
        return roll, (c5, -c4 * v313 - s4 * v323), waist, forearm

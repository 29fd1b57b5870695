"""The full inverse solution: six joints of one branch, or all eight branches."""

import math
from collections.abc import Sequence
from typing import Final

from rfms_can.errors import KinematicsError, SingularityError
from rfms_can.kinematics.closed_form import (
    EXACT,
    EXACT_WRIST_BOUND,
    WRIST_BOUND,
    ClosedForm,
    CosSin,
    Tolerance,
)
from rfms_can.kinematics.configuration import CONFIGURATIONS, Configuration
from rfms_can.kinematics.geometry import Geometry, Joints
from rfms_can.kinematics.limits import nearest_turn
from rfms_can.kinematics.refusal import limit_error, reach_error
from rfms_can.transform import Transform

_AT_ZERO: Final[Joints] = (0.0,) * 6
_NO_ROLL: Final[CosSin] = (1.0, 0.0)


class InverseKinematics:
    """The inverse solution of one arm, its constants computed once.

    Where the wrist is singular theta4 is open and theta6 follows: T6 determines their sum
    (theta5 = 0) or difference (theta5 = pi). theta4 is then as it is given, or else held at its
    previous value. ``wrist_singularity`` reports it.
    """

    def __init__(self, arm: Geometry, tolerance: Tolerance = EXACT) -> None:
        self.arm: Final = arm
        self._form: Final = ClosedForm(arm, tolerance.reach)
        self._ranges: Final = tuple(
            (lower - tolerance.angle, upper + tolerance.angle) for lower, upper in arm.joint_limits
        )

    def branch(
        self,
        t6: Transform,
        configuration: Configuration,
        held: CosSin = _NO_ROLL,
        bound: float = WRIST_BOUND,
    ) -> Joints:
        """The solution of one branch by the formulas, without joint limits.

        Each angle is correct modulo a turn; ``held`` is the cosine and sine of theta4 where |S5| is
        below ``bound``. Never raises: undefined angles are NaN.
        """
        left, up, noflip = configuration
        form, pz, atan2 = self._form, t6[11], math.atan2
        v114 = form.v114(t6, left)
        rho2, k, m = form.triangle(v114, pz, up)
        waist = c1, s1 = form.waist(t6, v114)
        forearm = form.forearm(v114, pz, rho2, k, m)
        v313, v323, c5 = form.approach(t6, waist, forearm)
        roll = c4, s4 = form.roll(v313, v323, noflip, held, bound)
        s5 = -c4 * v313 - s4 * v323  # (A.59)
        return (
            atan2(s1, c1),
            form.theta2(v114, pz, k, m),
            form.theta3(rho2, m),
            atan2(s4, c4),
            atan2(s5, c5),
            form.theta6(t6, waist, forearm, roll, (c5, s5)),
        )

    def solve(
        self,
        t6: Transform,
        configuration: Configuration,
        previous: Sequence[float] | None = None,
        theta4: float | None = None,
    ) -> Joints:
        """The joint angles of ``t6`` (rigid, metres) in ``configuration``, radians.

        Each angle is the turn nearest to ``previous`` that lies in the joint's range; without
        ``previous``, nearest to zero. ``theta4`` is taken where it is open, |S5| under
        ``WRIST_BOUND``. Without it that of ``previous`` is held, under ``EXACT_WRIST_BOUND``: so
        far the angles along a path are told by the path.

        Raises:
            UnreachableError: inside the shoulder cylinder, at the shoulder, too near or too far.
            JointLimitError: no whole turn of a joint's angle is in its range.
            KinematicsError: an element of ``t6`` or ``previous`` is not finite.
        """
        if previous is None:
            previous = _AT_ZERO
        p1, p2, p3, p4, p5, p6 = previous
        held, bound = (p4, EXACT_WRIST_BOUND) if theta4 is None else (theta4, WRIST_BOUND)
        roll = (math.cos(held), math.sin(held))
        q1, q2, q3, q4, q5, q6 = self.branch(t6, configuration, roll, bound)
        r1, r2, r3, r4, r5, r6 = self._ranges
        q = (
            nearest_turn(q1, p1, *r1),
            nearest_turn(q2, p2, *r2),
            nearest_turn(q3, p3, *r3),
            nearest_turn(q4, p4, *r4),
            nearest_turn(q5, p5, *r5),
            nearest_turn(q6, p6, *r6),
        )
        if not math.isfinite(sum(q) + sum(t6)):
            raise self._refusal(t6, previous, (q1, q2, q3, q4, q5, q6), q)
        return q

    def all_branches(self, t6: Transform) -> dict[Configuration, Joints]:
        """Every branch, angles in [-pi, pi], without joint limits; theta4 = 0 if singular.

        Raises:
            UnreachableError: ``t6`` is out of reach in all branches.
            KinematicsError: an element of ``t6`` is not finite.
        """
        refusal = reach_error(self.arm, t6, self._form)
        if refusal is not None:
            raise refusal
        branches = {}
        for configuration in CONFIGURATIONS:
            q1, q2, q3, q4, q5, q6 = self.branch(t6, configuration)
            branches[configuration] = (q1, q2, math.remainder(q3, math.tau), q4, q5, q6)
        return branches

    def wrist_sine(self, t6: Transform, configuration: Configuration) -> float:
        """|S5| at ``t6``; NaN if it is out of reach."""
        left, up, _ = configuration
        form = self._form
        v114 = form.v114(t6, left)
        forearm = form.forearm(v114, t6[11], *form.triangle(v114, t6[11], up))
        v313, v323, _ = form.approach(t6, form.waist(t6, v114), forearm)
        return math.hypot(v313, v323)

    def wrist_singularity(
        self, t6: Transform, configuration: Configuration
    ) -> SingularityError | None:
        """The wrist singularity at ``t6`` by name, number and bound; None if it is regular."""
        s5 = self.wrist_sine(t6, configuration)
        if not s5 < WRIST_BOUND:
            return None
        return SingularityError(
            f"{self.arm.name}: wrist singularity: |sin theta5| = {s5:.3g} is below "
            f"{WRIST_BOUND:g}: theta4 is held, theta6 follows from T6"
        )

    def _refusal(
        self, t6: Transform, previous: Sequence[float], branch: Joints, q: Joints
    ) -> KinematicsError:
        """The error for a solution ``q`` that contains a NaN."""
        if not all(map(math.isfinite, previous)):
            return KinematicsError(f"{self.arm.name}: previous {tuple(previous)} is not finite")
        refusal = reach_error(self.arm, t6, self._form)
        if refusal is not None:
            return refusal
        joint = next(index for index, angle in enumerate(q) if math.isnan(angle))
        return limit_error(self.arm, joint + 1, branch[joint])


def inverse(
    arm: Geometry,
    t6: Transform,
    configuration: Configuration,
    previous: Sequence[float] | None = None,
) -> Joints:
    """``InverseKinematics.solve`` once; keep an object for repeated calls."""
    return InverseKinematics(arm).solve(t6, configuration, previous)


def inverse_all(arm: Geometry, t6: Transform) -> dict[Configuration, Joints]:
    """``InverseKinematics.all_branches`` once."""
    return InverseKinematics(arm).all_branches(t6)

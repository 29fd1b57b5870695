"""Where a joint-mode segment is in space: what a Cartesian transition from or into one starts from.

The joints compute r theta_BC + solve(goal) each on its own (3.12). For a Cartesian transition the
master does the same for all six, in double precision, and takes T6 by direct kinematics.
"""

from typing import NamedTuple

from rfms_can.kinematics import Configuration, InverseKinematics, Joints, configuration_of, direct
from rfms_can.transform import Transform


class PlannedJoints(NamedTuple):
    """What the plan of a joint-mode move knows of its joints, so that turns are not ambiguous.

    Attributes:
        kinematics: of the arm.
        start, goal: angles at B and at the goal, rad.
    """

    kinematics: InverseKinematics
    start: Joints
    goal: Joints

    def line(
        self,
        start: Transform,
        start_configuration: Configuration,
        goal: Transform,
        to: Configuration,
    ) -> "JointLine":
        """The line from B = ``start`` to ``goal``, as both are at the hand-over (3.11).

        Raises:
            KinematicsError: one of the two has no solution.
        """
        solve = self.kinematics.solve
        theta_B = solve(start, start_configuration, self.start)
        theta_C = solve(goal, to, self.goal)
        return JointLine(self.kinematics, difference(theta_B, theta_C), theta_C, to)


class JointLine(NamedTuple):
    """The base of a joint-mode segment's set-points (3.12).

    Attributes:
        kinematics: of the arm.
        theta_BC: (3.11), rad.
        goal: angles at the goal where the segment begins, rad.
        configuration: the goal is solved in.
    """

    kinematics: InverseKinematics
    theta_BC: Joints
    goal: Joints
    configuration: Configuration

    def angles(self, goal: Transform | None, r: float) -> Joints:
        """Angles at r, rad; ``goal`` is where it is now, or None if it rests.

        Raises:
            KinematicsError: the goal has no solution.
        """
        theta = self.goal
        if goal is not None:
            theta = self.kinematics.solve(goal, self.configuration, theta)
        b1, b2, b3, b4, b5, b6 = self.theta_BC
        q1, q2, q3, q4, q5, q6 = theta
        return (
            *(q1 + r * b1, q2 + r * b2, q3 + r * b3),
            *(q4 + r * b4, q5 + r * b5, q6 + r * b6),
        )

    def pose(self, goal: Transform | None, r: float) -> Transform:
        """T6 at r; arguments and errors as of ``angles``."""
        return direct(self.kinematics.arm, self.angles(goal, r))

    def start(self, goal: Transform | None) -> tuple[Transform, Configuration]:
        """B, and its configuration, so that B less ``goal`` is theta_BC: what START tells."""
        angles = self.angles(goal, 1.0)
        arm = self.kinematics.arm
        return direct(arm, angles), configuration_of(arm, angles)


def difference(a: Joints, b: Joints) -> Joints:
    """a - b, rad."""
    a1, a2, a3, a4, a5, a6 = a
    b1, b2, b3, b4, b5, b6 = b
    return (a1 - b1, a2 - b2, a3 - b3, a4 - b4, a5 - b5, a6 - b6)

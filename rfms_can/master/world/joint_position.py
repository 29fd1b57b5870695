"""Positions in joint coordinates (thesis III.1): six angles, and T6 as they have it."""

import math
from collections.abc import Mapping
from typing import Final

from rfms_can.errors import JointPositionError
from rfms_can.kinematics import Geometry, Joints, configuration_of, direct
from rfms_can.master.trajectory.goal import FixedGoal, Moment
from rfms_can.master.world.transform_kinds import Live
from rfms_can.messages import JointPositionMessage
from rfms_can.transform import Transform

ROUNDING: Final = 1e-9
"""Rad an angle may be past the end of a range, which it then stands for: degrees that were
converted by other means than ours."""


class JointPosition:
    """A position by six joint angles; it never changes, and no transform is in it.

    Both as it is defined and as moves are bound to it: there is nothing to solve.

    Attributes:
        message: as defined.
        name: as defined.
        configuration: the branch the angles are of.
        goal: T6 and angles.
        transforms, references: none.
    """

    __slots__ = ("configuration", "goal", "message", "name")

    transforms: tuple[str, ...] = ()
    references: tuple[str, ...] = ()

    def __init__(self, message: JointPositionMessage, arm: Geometry) -> None:
        """The position of a message, for an arm.

        Raises:
            JointPositionError: an angle is outside the range of its joint, or not a number.
        """
        self.message: Final = message
        self.name: Final = message.name
        angles = _in_ranges(message, arm)
        self.configuration: Final = configuration_of(arm, angles)
        self.goal: Final = FixedGoal(direct(arm, angles), angles=angles)

    def bind(self, table: Mapping[str, Transform | Live]) -> "JointPosition":
        """Itself: it has no names to bind."""
        return self

    def uses(self, transform: str) -> bool:
        """Whether a transform stands in it: none does."""
        return False

    def is_same(self, other: object) -> bool:
        """Whether both are of the same angles."""
        return isinstance(other, JointPosition) and other.goal.angles == self.goal.angles

    def compliance_frame(self, moment: Moment, T6: Transform) -> Transform:
        """The frame the arm complies in, seen from T6: T6."""
        return Transform.identity()

    def tool(self, moment: Moment) -> Transform:
        """The frame right of T6 that runs along straight lines: T6."""
        return Transform.identity()

    def levers(self, moment: Moment) -> dict[str, float]:
        """How far from its references is what they move: it has none."""
        return {}


def _in_ranges(message: JointPositionMessage, arm: Geometry) -> Joints:
    """The angles, each in the range of its joint.

    Raises:
        JointPositionError: one is not.
    """
    within = []
    for joint, (angle, (lower, upper)) in enumerate(
        zip(message.angles, arm.joint_limits, strict=True), 1
    ):
        if not lower - ROUNDING <= angle <= upper + ROUNDING:  # also NaN
            degrees = math.degrees
            raise JointPositionError(
                f"position {message.name!r}: joint {joint} of {arm.name} at {angle:.6g} rad "
                f"({degrees(angle):.6g} deg) is outside its range [{lower:.6g}, {upper:.6g}] rad "
                f"([{degrees(lower):.6g}, {degrees(upper):.6g}] deg): give an angle inside it"
            )
        within.append(min(max(angle, lower), upper))
    q1, q2, q3, q4, q5, q6 = within
    return (q1, q2, q3, q4, q5, q6)

"""Poses with a straight wrist, made exactly straight.

A pose a millionth of a radian off is straight for all that a user meant and a board can do. But a
line that passes the singularity at that distance turns theta4 by half a turn within it. So a fixed
goal within ``WRIST_BOUND`` is taken as straight: it then stands at the singularity, and a line
from or to it has an angle theta4 that it tends to.
"""

import math

from rfms_can.errors import KinematicsError
from rfms_can.kinematics import WRIST_BOUND, Configuration, InverseKinematics, Joints, direct
from rfms_can.master.trajectory.goal import FixedGoal, Goal, Moment, joint_coordinates


def straightened(
    kinematics: InverseKinematics, goal: Goal, configuration: Configuration, previous: Joints
) -> Goal:
    """``goal`` itself; with a wrist that is nearly straight, the goal next to it with one that is.

    Args:
        kinematics: of the arm.
        goal: of a move.
        configuration: it is solved in.
        previous: angles before the move, rad.
    """
    if not goal.constant:
        return goal
    given = joint_coordinates(goal)
    if given is not None:
        angles = with_straight_wrist(given)
        return goal if angles == given else FixedGoal(direct(kinematics.arm, angles), angles=angles)
    nowhere = Moment(0)
    pose = goal.pose(nowhere)
    if not kinematics.wrist_sine(pose, configuration) < WRIST_BOUND:
        return goal
    try:
        q = kinematics.solve(pose, configuration, previous, previous[3])
    except KinematicsError:
        return goal  # refused where it is planned
    tool = goal.right(nowhere).inverse()
    return FixedGoal(direct(kinematics.arm, with_straight_wrist(q)) @ tool, tool)


def with_straight_wrist(q: Joints) -> Joints:
    """``q``, rad, with theta5 at a multiple of pi if it is within ``WRIST_BOUND`` of one."""
    q1, q2, q3, q4, q5, q6 = q
    if abs(math.sin(q5)) < WRIST_BOUND:
        q5 = math.pi * round(q5 / math.pi)
    return (q1, q2, q3, q4, q5, q6)

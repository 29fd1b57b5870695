"""Poses with a straight wrist, made exactly straight.

A pose a millionth of a radian off is straight for all that a user meant and a board can do. But a
line that passes the singularity at that distance turns theta4 by half a turn within it. So a fixed
goal within ``WRIST_BOUND`` is taken as straight: it then stands at the singularity, and a line
from or to it has an angle theta4 that it tends to.
"""

import math
from typing import Final

import numpy as np

from rfms_can.errors import KinematicsError
from rfms_can.kinematics import WRIST_BOUND, Configuration, InverseKinematics, Joints, direct
from rfms_can.master.trajectory.goal import FixedGoal, Goal, Moment, joint_coordinates
from rfms_can.master.trajectory.planning.base_path import Base, Frame
from rfms_can.setpoint.history import window_for

HELD: Final = 1e-4
"""Rad by which theta4 may be beside what the path tends to, where joints rest in a straight wrist
of a goal that moves by itself."""


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


def check_held(frame: Frame, base: Base, hand_over: float) -> None:
    """A path to a goal that moves by itself does not turn theta4 before a straight wrist.

    Joints are told the angles of a fixed goal. Of another they hold, in a straight wrist, the
    theta4 that they have as they begin to watch it: a path that turns it meanwhile leaves them
    beside it.

    Args:
        frame, base: of the plan.
        hand_over: local time at which the transition to rest begins, periods.

    Raises:
        KinematicsError: it does.
    """
    move, tau = base.segment.move, frame.period_s
    end = frame.at_goal(base.segment)
    if not frame.kinematics.wrist_sine(move.target.pose(end), move.configuration) < WRIST_BOUND:
        return
    watched = (hand_over - window_for(move.rest_ticks)) * tau
    h = float(base.parameter(np.array([watched]))[0, 0])
    held, needed = base.solve(h, watched, base.goal)[3], base.goal[3]
    if abs(held - needed) > HELD:
        raise KinematicsError(
            f"move {move.sequence}: its goal, which moves by itself, ends in a straight wrist with "
            f"theta4 = {needed:.6g} rad, and the joints hold the {held:.6g} rad they have as they "
            f"begin to watch it: place the goal elsewhere, or make it of type value"
        )

"""Cartesian transitions from and into joint mode, as planned: where both lines are in space.

T6 tells the angles only with a configuration, on the nearest turns, and away from singularities. So
what is solved of a transition must be the joints' own angles at both of its ends; and what the
joints are then told of the line they have joined must be that line.
"""

from typing import Final

import numpy as np

from rfms_can.errors import KinematicsError
from rfms_can.kinematics import Joints
from rfms_can.master.trajectory.joint_line import JointLine
from rfms_can.master.trajectory.planning.base_path import Base, Frame
from rfms_can.master.trajectory.planning.curve import Floats
from rfms_can.master.trajectory.planning.departure import DepartedSegment, departure_at
from rfms_can.master.trajectory.segment import Segment
from rfms_can.wire.vocabulary import Mode

SAME: Final = 1e-6
"""Rad by which angles that are solved of T6 may differ from the joints' own."""
JOINED: Final = 1e-4
"""Rad by which they may differ from those of the straight line they lead to: both are solved, but
in a wrist that is straight each holds the theta4 it has come with."""


def lined(frame: Frame, base: Base) -> Segment:
    """The segment of ``base``; in joint mode with the line its joints run along."""
    segment = base.segment
    if segment.move.mode is Mode.CARTESIAN:
        return segment
    return segment._replace(line=_line(frame, base, base.goal))


def departing_angles(frame: Frame, departed: DepartedSegment, hand_over: int) -> Joints:
    """Angles near which the transition begins, rad."""
    before = departed.segment
    if before.rests or before.move.mode is Mode.CARTESIAN:
        return departed.goal
    return _joints(departure_at(frame, departed, hand_over)[0])


def check_ends(frame: Frame, departed: DepartedSegment, base: Base, angles: Floats) -> None:
    """The solved ``angles`` (n, 6) of a Cartesian transition are the joints' own at both ends.

    Raises:
        KinematicsError: they are not, or the joints would take the line they join for another.
    """
    before, move = departed.segment, base.segment.move
    if move.mode is Mode.CARTESIAN:
        line = base.derivatives(np.array([base.acceleration_time]))[0, 0]
        _check(frame, departed, base, angles[-1], line, JOINED)
    if before.rests:
        return
    pairs: list[tuple[Floats, Floats]] = []
    if before.move.mode is Mode.JOINT:
        hand_over = before.move.segment_ticks - move.acceleration_ticks
        pairs.append((angles[0], departure_at(frame, departed, hand_over)[0]))
    if move.mode is Mode.JOINT:
        last, theta_BC = angles[-1], np.array(base.theta_BC)
        end = np.array([base.acceleration_time])
        h = float(base.parameter(end)[0, 0])
        goal = base.solve(h, base.acceleration_time, _joints(last))
        start, configuration = _line(frame, base, goal).start(None)
        told = frame.kinematics.solve(start, configuration, _joints(last))
        pairs.append((last, base.derivatives(end)[0, 0]))
        pairs.append((last, np.array(goal) + (1.0 - h) * theta_BC))
        pairs.append((np.array(told), np.array(goal) + theta_BC))
    for solved, own in pairs:
        _check(frame, departed, base, solved, own, SAME)


def _check(
    frame: Frame, departed: DepartedSegment, base: Base, solved: Floats, own: Floats, within: float
) -> None:
    apart = np.abs(solved - own)
    joint = int(apart.argmax())
    if not apart[joint] <= within:
        raise KinematicsError(
            f"move {base.segment.move.sequence}: joint {joint + 1} of {frame.kinematics.arm.name} "
            f"would be {apart[joint]:.3g} rad off at an end of the Cartesian transition from move "
            f"{departed.segment.move.sequence}, more than {within:g} rad: there the wrist is "
            f"singular, or the configuration changes; use a joint transition, or accelerate in "
            f"less time"
        )


def _line(frame: Frame, base: Base, goal: Joints) -> JointLine:
    configuration = base.segment.move.configuration
    return JointLine(frame.kinematics, base.theta_BC, goal, configuration)


def _joints(values: Floats) -> Joints:
    j1, j2, j3, j4, j5, j6 = values.tolist()
    return (j1, j2, j3, j4, j5, j6)

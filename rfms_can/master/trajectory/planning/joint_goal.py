"""Goals in joint coordinates: the angles say the configuration and the turn of every joint.

A move in joint mode takes them as they are. A straight line keeps the configuration and the turns
it begins with, and reaches a straight wrist with the theta4 its path tends to: it is refused unless
these are the angles asked for.
"""

import math
from typing import Final

from rfms_can.errors import MoveError
from rfms_can.kinematics import WRIST_BOUND, Configuration, Joints
from rfms_can.master.trajectory.goal import joint_coordinates
from rfms_can.master.trajectory.planning.base_path import Base

REACHED: Final = 1e-6
"""Rad an angle may be off the one asked for: what T6 says of it next to a singularity."""


def configuration_for(
    angles: Joints,
    own: Configuration,
    asked: Configuration | None,
    before: Configuration,
    sequence: int,
) -> Configuration:
    """The configuration of a move to joint angles.

    A straight wrist is of both flips: it takes that of the mode, or keeps that of the move before.

    Args:
        angles: of the goal, rad.
        own: their configuration.
        asked: of the mode, or None.
        before: of the segment before.
        sequence: number of the move.

    Raises:
        MoveError: the mode asks for another one.
    """
    if abs(math.sin(angles[4])) < WRIST_BOUND:
        own = own._replace(noflip=(asked or before).noflip)
    if asked not in (None, own):
        raise MoveError(
            f"move {sequence}: its mode asks for the configuration '{asked}', and the joint angles "
            f"of the position are '{own}'"
        )
    return own


def check_reached(base: Base) -> None:
    """A straight line ends at the joint angles its goal is given by, if it is.

    Raises:
        MoveError: it ends at other ones.
    """
    asked = joint_coordinates(base.segment.move.target)
    if asked is None or base.segment.drive is None:
        return
    off = [abs(a - b) for a, b in zip(asked, base.goal, strict=True)]
    joint = next((k for k, each in enumerate(off) if not each <= REACHED), None)
    if joint is None:
        return
    ends, wanted, degrees = base.goal[joint], asked[joint], math.degrees
    why = "a line stays on the turns it begins on"
    if abs(math.remainder(wanted - ends, math.tau)) > REACHED:
        why = "the path tells theta4 where it ends in a straight wrist"
    raise MoveError(
        f"move {base.segment.move.sequence}: the straight line would end with joint {joint + 1} at "
        f"{ends:.6g} rad ({degrees(ends):.6g} deg), and {wanted:.6g} rad "
        f"({degrees(wanted):.6g} deg) is asked for: {why}"
    )

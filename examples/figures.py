"""One motion three times, as in thesis Figures 3.3, 3.4 and 3.5.

In joint mode, in joint mode with a longer acceleration time, and along straight lines::

    rfms run examples/figures.py --record figures
    rfms plot figures --figures thesis

The places lie on a circle around the arm's own column, as far out as the hand is when the arm is
enabled, so the program fits an arm of any size.
"""

import math

from rfms_can.coordinator import Arm, Transform

COLUMN = (0.0, 0.0, 1.0)
"""Axis of joint 1 in the base frame."""

SHORT, LONG = 0.2, 0.4
"""Acceleration times, s."""


def program(arm: Arm) -> None:
    """Go from right over the middle to left three times, each time in another mode."""
    hand = arm.transform("hand", arm.pose)
    park = arm.position("park", arm.t6 == hand)
    right, middle, left = (
        arm.position(name, arm.t6 == arm.transform(f"to the {name}", _turn(degrees)) @ hand)
        for name, degrees in (("right", -40.0), ("middle", 5.0), ("left", 32.0))
    )
    back = arm.mode("back", segment_time=2.0, acceleration_time=0.3)
    modes = (
        arm.mode("joint", segment_time=1.0, acceleration_time=SHORT),
        arm.mode("joint, longer", segment_time=1.0, acceleration_time=LONG),
        arm.mode("straight", segment_time=1.0, acceleration_time=SHORT, interpolation="cartesian"),
    )
    for mode in modes:
        arm.move(right, back)
        arm.wait()
        arm.sleep(0.3)
        arm.move(middle, mode)
        arm.move(left, mode)
        arm.wait()
        arm.sleep(0.3)
    arm.move(park, back)
    arm.wait()


def _turn(degrees: float) -> Transform:
    """A turn about the arm's column."""
    return Transform.rotation(COLUMN, math.radians(degrees))

"""A short program to record: one way in the three modes of thesis Figures 3.3 to 3.5."""

import math

from rfms_can.coordinator import Arm, Transform

SHORT, LONG = 0.04, 0.08
FAR = math.radians(4.0)


def program(arm: Arm) -> None:
    """One way in three modes, in 1.5 s of motion."""
    hand = arm.transform("hand", arm.pose)
    turn = arm.transform("turn", Transform.rotation((0.0, 0.0, 1.0), FAR))
    here, there = arm.position("here", arm.t6 == hand), arm.position("there", arm.t6 == turn @ hand)
    back = arm.mode("back", segment_time=0.2, acceleration_time=SHORT)
    longer = arm.mode("longer", segment_time=0.2, acceleration_time=LONG)
    straight = arm.mode(
        "straight", segment_time=0.2, acceleration_time=SHORT, interpolation="cartesian"
    )
    for mode in (back, longer, straight):
        arm.move(there, mode)
        arm.wait()
        arm.move(here, back)
        arm.wait()

"""The thesis' program of section V.5, as printed: a peg over a hole, into it, let go, go home.

    rfms run examples/thesis_peg.py --arm puma560

Numbers and names are the thesis' own, millimetres and degrees in metres and radians. Its frames
are ours: ``z`` leads from the floor to the shoulder, where the base frame of T6 stands, and ``e``
from the wrist centre to the tip of the peg. So the printed places need no change: a PUMA 560
reaches both in the configuration it is enabled in, with the hand pointing straight down. A PUMA
260 is too small for them, and is told so before anything moves.

What the listing leaves out is here too: ``park`` is where the arm was enabled, and the modes of
the two ways; its ``lock`` names ``fz``, which was never made compliant, and is ``fy`` here.
"""

import math

from rfms_can.coordinator import Arm, Transform

Y_UNIT = (0.0, 1.0, 0.0)


def program(arm: Arm) -> None:
    """Get to the hole, comply, push the peg to the bottom, let go of it, go back home."""
    z = arm.transform("z", Transform.translation(0.0, 0.0, 0.864))
    e = arm.transform("e", Transform.translation(0.0, 0.0, 0.200))
    b1 = arm.transform("b1", rot(0.600, 0.250, 0.700, Y_UNIT, 180.0))
    b2 = arm.transform("b2", rot(0.600, 0.250, 0.500, Y_UNIT, 180.0))
    home = arm.transform("home", arm.pose)

    hole = arm.position("hole", z @ arm.t6 @ e == b1, tool=e)
    bottom = arm.position("bottom", z @ arm.t6 @ e == b2, tool=e)
    park = arm.position("park", arm.t6 == home)

    far = arm.mode("far", segment_time=1.6, acceleration_time=0.3)
    insert = arm.mode("insert", segment_time=1.6, acceleration_time=0.2, interpolation="cartesian")

    arm.gripper.close()  # it holds the peg
    arm.wait(arm.move(hole, far))  # get to hole
    arm.comply("fx fy rx ry", 0.0, 0.0, 0.0, 0.0)
    arm.wait(arm.move(bottom, insert))  # with the compliance above
    arm.lock("fx fy rx ry")  # terminate the compliance
    arm.release()  # open the gripper
    arm.wait(arm.move(park, far))  # go back home


def rot(
    x: float, y: float, z: float, axis: tuple[float, float, float], degrees: float
) -> Transform:
    """RCCL's gentr_rot: a place, turned about one of its axes."""
    return Transform.translation(x, y, z) @ Transform.rotation(axis, math.radians(degrees))

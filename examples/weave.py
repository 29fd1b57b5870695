"""Weave along a welding seam with corners, and report the deviation at the corners.

    rfms run examples/weave.py

The seam is three straight segments; the weave is a functional transform right of each of its
points, computed by the server from the segment parameter: a sine across the seam, with
whole periods in each segment, so that it is zero at the points themselves. Transitions are
Cartesian: from one segment to the next the torch follows the seam as closely as the acceleration
time allows, and ``arm.plan`` gives the deviation.
"""

import math
from itertools import pairwise

from rfms_can.coordinator import Arm, Transform, Weave

DOWN = Transform.rotation((0.0, 1.0, 0.0), math.pi)
"""The torch looks down."""

SEAM = ((-0.02, -0.02, 0.0), (-0.02, 0.08, 0.0), (0.04, 0.08, 0.0), (0.04, 0.16, 0.0))
"""Points of the seam on the bench, m: two corners of 90 degrees."""

SPEED = 0.025
"""Along the seam, m/s."""

AMPLITUDE, PITCH = 0.002, 0.010
"""Of the weave: to either side, and the length of a period along the seam; m."""

ABOVE = 0.04
"""Height above the seam from which the torch approaches, m."""


def program(arm: Arm) -> None:
    """Go to the seam, weld it, come away."""
    hand = arm.pose
    home = arm.transform("home", hand)
    torch = arm.transform("torch", Transform.translation(0.0, 0.0, 0.1354))
    bench = arm.transform("bench", bench_under(hand))
    down = arm.transform("down", DOWN)
    above = arm.transform("above", Transform.translation(0.0, 0.0, ABOVE))
    points = [
        arm.transform(f"point {number}", Transform.translation(*point))
        for number, point in enumerate(SEAM)
    ]
    park = arm.position("park", arm.t6 == home)
    over_begin = arm.position("over begin", arm.t6 @ torch == bench @ above @ points[0] @ down)
    begin = arm.position("begin", arm.t6 @ torch == bench @ points[0] @ down)
    over_end = arm.position("over end", arm.t6 @ torch == bench @ above @ points[-1] @ down)

    far = arm.mode("far", joint_speed=0.4, acceleration_time=0.25, lengthen=True)
    near = arm.mode("near", speed=0.08, acceleration_time=0.15, interpolation="cartesian")
    weld = arm.mode(
        "weld",
        speed=SPEED,
        acceleration_time=0.1,
        interpolation="cartesian",
        transition="cartesian",
    )
    arm.move(over_begin, far)
    arm.wait(arm.move(begin, near))
    for number, (one, other) in enumerate(pairwise(SEAM), 1):
        weave = arm.functional(f"weave {number}", across(one, other))
        seam = arm.position(
            f"seam {number}", arm.t6 @ torch == bench @ points[number] @ weave @ down
        )
        plan = arm.plan(arm.move(seam, weld))
        if plan.via_deviation is not None:
            print(f"corner {number - 1}: kept within {1e3 * plan.via_deviation:.2f} mm")
    arm.wait()
    arm.move(over_end, near)
    arm.move(park, far)
    arm.wait()


def across(one: tuple[float, float, float], other: tuple[float, float, float]) -> Weave:
    """The weave of the segment between two points: across it, in the plane of the bench."""
    x, y = other[0] - one[0], other[1] - one[1]
    length = math.hypot(x, y)
    side = (-y / length * AMPLITUDE, x / length * AMPLITUDE, 0.0)
    return Weave(amplitude=side, cycles=round(length / PITCH), parameter="h")


def bench_under(hand: Transform) -> Transform:
    """A bench 0.22 m below the wrist as it is now, square to the base."""
    return Transform.translation(hand.px, hand.py, hand.pz - 0.22)

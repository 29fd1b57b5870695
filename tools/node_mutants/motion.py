"""Three seconds of motion for a mutant: a long joint move, a straight one, and a joint move back.

As in ``examples/transfer.py``: places are fractions of the hand's distance when the arm is enabled.
"""

import math

from rfms_can.coordinator import Arm, Transform

DOWN = Transform.rotation((0.0, 1.0, 0.0), math.pi)


def program(arm: Arm) -> None:
    """To above a part, down to it, and halfway back."""
    reach = math.hypot(arm.pose.px, arm.pose.py)
    part = arm.transform(
        "part", Transform.translation(0.95 * reach, 0.60 * reach, -0.45 * reach) @ DOWN
    )
    above = arm.transform("above", Transform.translation(0.0, 0.0, -0.30 * reach))
    tool = arm.transform("tool", Transform.translation(0.0, 0.0, 0.1354))
    home = arm.transform("home", arm.pose)

    over = arm.position("over part", arm.t6 @ tool == part @ above)
    at = arm.position("at part", arm.t6 @ tool == part)
    park = arm.position("park", arm.t6 == home)
    far = arm.mode("far", segment_time=1.2, acceleration_time=0.25)
    near = arm.mode("near", segment_time=0.6, acceleration_time=0.15, interpolation="cartesian")

    arm.move(over, far)
    arm.move(at, near)
    arm.move(park, far)
    arm.wait()

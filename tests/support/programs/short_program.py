"""Two seconds of motion with everything in it: a joint and a straight segment, and the gripper."""

from rfms_can.coordinator import Arm, Transform


def program(arm: Arm) -> None:
    """Swing a little, go straight down, grip, and stop."""
    hand = arm.transform("hand", arm.pose)
    aside = arm.transform("aside", Transform.rotation((0.0, 0.0, 1.0), 0.2))
    down = arm.transform("down", Transform.translation(0.0, 0.0, 0.03))
    above = arm.position("above", arm.t6 == aside @ hand)
    at = arm.position("at", arm.t6 == aside @ hand @ down)
    swing = arm.mode("swing", segment_time=0.6, acceleration_time=0.15)
    approach = arm.mode(
        "approach", segment_time=0.4, acceleration_time=0.1, interpolation="cartesian"
    )
    arm.move(above, swing)
    arm.move(at, approach)
    arm.wait()
    arm.gripper.close()

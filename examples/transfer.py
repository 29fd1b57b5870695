"""Park, above the part, at the part, grip, above it again, above the goal, at the goal, release.

In the manner of the thesis' programs: a tool on the flange, places in the world, and position
equations that relate them. Long motions are joint motions, approaches are straight lines. Places
are given as fractions of the hand's distance when the arm is enabled: they suit an arm of any size.
"""

import math

from rfms_can.coordinator import Arm, Transform

DOWN = Transform.rotation((0.0, 1.0, 0.0), math.pi)
"""The hand looks down: its approach axis along -z of the world."""


def program(arm: Arm) -> None:
    """Carry a part from one place to another, and go back to where the arm was."""
    reach = math.hypot(arm.pose.px, arm.pose.py)

    def place(x: float, y: float, z: float) -> Transform:
        return Transform.translation(x * reach, y * reach, z * reach)

    tool = arm.transform("tool", Transform.translation(0.0, 0.0, 0.1354))
    home = arm.transform("home", arm.pose)
    part = arm.transform("part", place(0.95, 0.60, -0.45) @ DOWN)
    goal = arm.transform("goal", place(0.85, -0.45, -0.40) @ DOWN)
    above = arm.transform("above", place(0.0, 0.0, -0.30))

    park = arm.position("park", arm.t6 == home)
    above_part = arm.position("above part", arm.t6 @ tool == part @ above)
    at_part = arm.position("at part", arm.t6 @ tool == part)
    above_goal = arm.position("above goal", arm.t6 @ tool == goal @ above)
    at_goal = arm.position("at goal", arm.t6 @ tool == goal)

    far = arm.mode("far", segment_time=1.6, acceleration_time=0.3)
    near = arm.mode("near", segment_time=0.9, acceleration_time=0.2, interpolation="cartesian")

    arm.gripper.open()
    arm.move(above_part, far)
    arm.move(at_part, near)
    arm.wait()
    arm.sleep(1.3)
    arm.gripper.close()
    arm.move(above_part, near)
    arm.move(above_goal, far)
    arm.move(at_goal, near)
    arm.wait()
    arm.sleep(1.3)
    arm.gripper.open()
    arm.move(above_goal, near)
    arm.move(park, far)
    arm.wait()
    arm.sleep(1.3)

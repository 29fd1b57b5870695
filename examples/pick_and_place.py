"""Pick and place: approach, grip, look whether there is a part, carry it over, let go, withdraw.

    rfms run examples/pick_and_place.py

The jaw tells whether the grip has found something: closed on a part it stays as far open as the
part is wide. On an empty simulation it closes fully; the program says so, opens again and goes
home without a part. Free motions are joint motions, approaches and departures straight lines along
the tool. The bench lies in front of the arm, where its hand is when enabled,
and the configuration is named once for all places: the arm does not reach over its shoulder.
"""

import math

from rfms_can.coordinator import Arm, Transform

DOWN = Transform.rotation((0.0, 1.0, 0.0), math.pi)
"""The hand looks down: its approach axis along -z of the bench."""

CONFIG = "left down flip"
"""Configuration of the arm at all places."""

PART_WIDTH = 0.03
"""Width of the part between the fingers, m."""

TOLERANCE = 0.005
"""How far the jaw may stand from it, m."""


def program(arm: Arm) -> None:
    """Carry a part from one place to another if there is one, and go home."""
    home = arm.transform("home", arm.pose)
    tool = arm.transform("tool", Transform.translation(0.0, 0.0, 0.1354))
    bench = arm.transform("bench", bench_under(arm.pose))
    down = arm.transform("down", DOWN)
    part = arm.transform("part", Transform.translation(0.02, 0.16, 0.02))
    goal = arm.transform("goal", Transform.translation(0.05, -0.06, 0.02))
    back = arm.transform("back", Transform.translation(0.0, 0.0, -0.06))

    park = arm.position("park", arm.t6 == home, config=CONFIG)
    at_part, over_part = (
        arm.position("at part", arm.t6 @ tool == bench @ part @ down, config=CONFIG),
        arm.position("over part", arm.t6 @ tool == bench @ part @ down @ back, config=CONFIG),
    )
    at_goal, over_goal = (
        arm.position("at goal", arm.t6 @ tool == bench @ goal @ down, config=CONFIG),
        arm.position("over goal", arm.t6 @ tool == bench @ goal @ down @ back, config=CONFIG),
    )
    far = arm.mode("far", joint_speed=0.5, acceleration_time=0.25, lengthen=True)
    near = arm.mode("near", speed=0.1, acceleration_time=0.15, interpolation="cartesian")

    arm.gripper.open()
    arm.move(over_part, far)
    arm.wait(arm.move(at_part, near))
    arm.gripper.close(0.5)
    if abs(arm.status.jaw - PART_WIDTH) < TOLERANCE:
        arm.move(over_part, near)
        arm.move(over_goal, far)
        arm.wait(arm.move(at_goal, near))
        arm.gripper.open()
        arm.move(over_goal, near)
    else:
        print(f"no part: the jaw stands at {1e3 * arm.status.jaw:.1f} mm")
        arm.gripper.open()
        arm.move(over_part, near)
    arm.move(park, far)
    arm.wait()


def bench_under(hand: Transform) -> Transform:
    """A bench 0.24 m below the wrist as it is now, square to the base."""
    return Transform.translation(hand.px, hand.py, hand.pz - 0.24)

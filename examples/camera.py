"""A camera corrects the goal on the way: the part lies a centimetre from where it should.

    rfms run examples/camera.py

The part is a reference transform with its nominal value. In the middle of the straight approach the
camera on the wrist measures its true pose; the observation changes the goal of the current motion,
and the server blends the correction in: the tool's acceleration changes by no more than the mode
allows, and the tool arrives at the part.
"""

import math

from rfms_can.coordinator import Arm, Transform

DOWN = Transform.rotation((0.0, 1.0, 0.0), math.pi)
"""The hand looks down: its approach axis along -z of the bench."""

DRAWN = (0.02, 0.12, 0.02)
"""Nominal position of the part on the bench, m."""

OFF = (0.008, -0.006, 0.0)
"""Its true displacement from there, m: 10 mm."""

SEEN_AFTER = 0.6
"""Time of the camera's picture after the start of the approach, s."""

ACCELERATION = 1.0
"""Largest acceleration of the correction, m/s2."""


def program(arm: Arm) -> None:
    """Approach the nominal place, arrive at the true one, grip the part, retreat."""
    hand = arm.pose
    home = arm.transform("home", hand)
    tool = arm.transform("tool", Transform.translation(0.0, 0.0, 0.1354))
    down = arm.transform("down", DOWN)
    back = arm.transform("back", Transform.translation(0.0, 0.0, -0.08))
    part = arm.reference("part", place(hand, DRAWN), predict="hold")

    park = arm.position("park", arm.t6 == home)
    over_part = arm.position("over part", arm.t6 @ tool == part @ down @ back)
    at_part = arm.position("at part", arm.t6 @ tool == part @ down)
    far = arm.mode("far", segment_time=1.4, acceleration_time=0.3)
    approach = arm.mode(
        "approach",
        segment_time=1.2,
        acceleration_time=0.2,
        interpolation="cartesian",
        acceleration=ACCELERATION,
    )
    arm.gripper.open()
    arm.wait(arm.move(over_part, far))
    there = arm.move(at_part, approach)
    arm.sleep(SEEN_AFTER)
    arm.observe(part, seen(hand))
    arm.wait(there)
    arm.gripper.close()
    arm.move(over_part, approach)
    arm.move(park, far)
    arm.wait()


def seen(hand: Transform) -> Transform:
    """True pose of the part, in the base frame."""
    x, y, z = (drawn + off for drawn, off in zip(DRAWN, OFF, strict=True))
    return place(hand, (x, y, z))


def place(hand: Transform, point: tuple[float, float, float]) -> Transform:
    """A point of the bench, which lies 0.24 m below the wrist as it was when enabled."""
    bench = Transform.translation(hand.px, hand.py, hand.pz - 0.24)
    return bench @ Transform.translation(*point)

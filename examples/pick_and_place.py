"""Pick and place: approach, grip, look whether there is a part, carry it over, let go, withdraw.

    rfms run examples/pick_and_place.py

The jaw tells whether the grip has found something: closed on a part it stays as far open as the
part is wide. On an empty simulation it closes fully; the program says so, opens again and goes
home without a part. It is written at the task level: an approach is a free motion to a point off
a place and a straight line along the tool to it, a departure a straight line; they blend where they
do not wait. The bench lies in front of the arm, where its hand is when enabled, and the
configuration is named once for all places: the arm does not reach over its shoulder.
"""

import math

from rfms_can.coordinator import Arm, Transform
from rfms_can.task import Frame, Task, approach, depart, grip, release

DOWN = Transform.rotation((0.0, 1.0, 0.0), math.pi)
"""The hand looks down: its approach axis along -z of the bench."""

CONFIG = "left down flip"
"""Configuration of the arm at all places."""

PART_WIDTH = 0.03
"""Width of the part between the fingers, m."""

TOLERANCE = 0.005
"""How far the jaw may stand from it, m."""

BACK = (0.0, 0.0, -0.06)
"""Where approaches begin and departures end, m off a place."""


def program(arm: Arm) -> None:
    """Carry a part from one place to another if there is one, and go home."""
    tool = Frame("tool", Transform.translation(0.0, 0.0, 0.1354))
    bench, down = Frame("bench", bench_under(arm.pose)), Frame("down", DOWN)
    part = bench @ Frame("part", Transform.translation(0.02, 0.16, 0.02)) @ down
    goal = bench @ Frame("goal", Transform.translation(0.05, -0.06, 0.02)) @ down
    home = arm.transform("home", arm.pose)
    park = arm.position("park", arm.t6 == home, config=CONFIG)
    far = arm.mode("far", joint_speed=0.5, acceleration_time=0.25, lengthen=True)

    def to(place: Frame, name: str) -> Task:
        return approach(tool, place, by=BACK, config=CONFIG, name=name)

    def off(place: Frame, name: str, wait: bool = True) -> Task:
        return depart(tool, place, by=BACK, config=CONFIG, name=name, wait=wait)

    take = release() + to(part, "to the part") + grip(0.5)
    carry = off(part, "off the part", wait=False) + to(goal, "to the goal") + release()
    take.run(arm)
    if abs(arm.status.jaw - PART_WIDTH) < TOLERANCE:
        (carry + off(goal, "off the goal")).run(arm)
    else:
        print(f"no part: the jaw stands at {1e3 * arm.status.jaw:.1f} mm")
        (release() + off(part, "off the part")).run(arm)
    arm.wait(arm.move(park, far))


def bench_under(hand: Transform) -> Transform:
    """A bench 0.24 m below the wrist as it is now, square to the base."""
    return Transform.translation(hand.px, hand.py, hand.pz - 0.24)

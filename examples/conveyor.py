"""Take a part off a moving belt: see it, approach it, ride along with it, grip it, lift it.

    rfms run examples/conveyor.py

The part is a reference transform that the arm reads in every cycle. A camera observes it: 50
pictures a second, each 20 ms old when it arrives, with its time stamp. The server extrapolates with
the observed velocity (``predict="velocity"``), so the tool follows the part and not the pictures;
the move to it is a straight line in the part's own frame. One class here replaces the factory: the
belt, which knows the true position of the part.
"""

import math

from rfms_can.coordinator import Arm, Expression, Transform

SPEED = 0.1
"""Of the belt, m/s."""

LATE = 0.02
"""Age of a picture when it arrives, s."""

FRAME = 0.02
"""From one picture to the next, s."""

RIDE = 0.4
"""How long the tool rides along before it grips, s."""

DOWN = Transform.rotation((0.0, 1.0, 0.0), math.pi)
"""The hand looks down: its approach axis along -z of the bench."""

REACH = -0.18
"""Where on the belt the part comes within reach, m along it from the middle."""

AHEAD = 0.35
"""How far ahead of there the arm waits, s of the belt's motion, to join the part smoothly."""


class Belt:
    """A belt along y of the base, past the hand, that carries one part.

    Attributes:
        speed: m/s.
        enters: when the part comes within reach of the arm, s of the arm's clock.
    """

    def __init__(self, hand: Transform, speed: float, enters: float) -> None:
        self.speed = speed
        self.enters = enters
        self._middle = Transform.translation(hand.px, hand.py, hand.pz - 0.22)

    def at(self, along: float) -> Transform:
        """A place on the belt at a distance from its middle, m."""
        return self._middle @ Transform.translation(0.0, along, 0.0)

    def part(self, time: float) -> Transform:
        """True pose of the part, in the base frame, at a time of the arm's clock."""
        return self.at(REACH + self.speed * (time - self.enters))

    def picture(self, time: float) -> Transform:
        """Pose measured by the camera at that time."""
        return self.part(time)


def program(arm: Arm) -> None:
    """Wait where the part enters, take it, carry it up, go home."""
    hand = arm.pose
    belt = Belt(hand, SPEED, arm.time + 2.2)
    home = arm.transform("home", hand)
    tool = arm.transform("tool", Transform.translation(0.0, 0.0, 0.1354))
    down = arm.transform("down", DOWN)
    back = arm.transform("back", Transform.translation(0.0, 0.0, -0.05))
    entry = arm.transform("entry", belt.at(REACH + AHEAD * SPEED))
    part = arm.reference("part", belt.picture(arm.time), predict="velocity")

    park = arm.position("park", arm.t6 == home)
    over_entry = arm.position("over entry", arm.t6 @ tool == entry @ down @ back)
    at_part = arm.position("at part", arm.t6 @ tool == part @ down, tool=tool)
    over_part = arm.position("over part", arm.t6 @ tool == part @ down @ back, tool=tool)
    join = arm.mode("join", segment_time=0.7, acceleration_time=0.3, interpolation="cartesian")
    approach = arm.mode(
        "approach", segment_time=0.5, acceleration_time=0.12, interpolation="cartesian"
    )
    far = arm.mode("far", segment_time=1.2, acceleration_time=0.3)

    arm.move(over_entry, far)
    while arm.time < belt.enters:
        look(arm, belt, part)
    arm.move(over_part, join)
    there = arm.move(at_part, approach)
    while arm.status.completed < there:
        look(arm, belt, part)
    rides = arm.time + RIDE
    while arm.time < rides:
        look(arm, belt, part)
    arm.gripper.close()
    here = arm.transform("here", arm.pose)
    up = arm.transform("up", Transform.translation(0.0, 0.0, 0.05))
    arm.move(arm.position("lifted", arm.t6 == up @ here), approach)
    arm.move(park, far)
    arm.wait()


def look(arm: Arm, belt: Belt, part: Expression) -> None:
    """Wait for the next picture and send its observation with the time stamp."""
    arm.sleep(FRAME)
    taken = arm.time - LATE
    arm.observe(part, belt.picture(taken), at=taken)

"""Take a part off a moving belt: see it, approach it, ride along with it, grip it, lift it.

    rfms run examples/conveyor.py

or with the camera in a process of its own, beside the program that moves the arm:

    rfms serve --grant camera=part &
    python examples/conveyor.py &
    rfms coordinate examples/conveyor.py

The part is a reference transform that the arm reads in every cycle. A camera observes it: 50
pictures a second, each 20 ms old when it arrives, with its time stamp. The server extrapolates with
the observed velocity (``predict="velocity"``), so the tool follows the part and not the pictures;
the move to it is a straight line in the part's own frame. One class here replaces the factory: the
belt, which knows the true position of the part. Parts come at fixed times of the server's clock: so
two processes have the same belt.
"""

import math
import sys

from rfms_can.coordinator import Arm, Expression, LeaseError, Transform, connect_sensor

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

FIRST = 2.2
"""When the first part comes within reach, s of the arm's clock."""

EVERY = 12.0
"""From one part to the next, s."""

LEAD = 1.5
"""The arm takes the next part that does not come within reach sooner than this, s."""

CAMERA = "camera"
"""Name of the sensor, if the camera is one of its own."""


def coming(time: float) -> float:
    """When the part comes within reach that is to be taken next, s of the arm's clock."""
    return FIRST + EVERY * max(0, math.ceil((time + LEAD - FIRST) / EVERY))


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
    if CAMERA in arm.status.sensors:
        arm.grant(CAMERA, ["part"], within=20.0)
    belt = Belt(hand, SPEED, coming(arm.time))
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
    """Wait for the next picture and send its observation, unless the camera does it itself."""
    arm.sleep(FRAME)
    if CAMERA not in arm.status.sensors:
        taken = arm.time - LATE
        arm.observe(part, belt.picture(taken), at=taken)


def camera(server: str = "rfms") -> None:
    """The camera as a sensor of its own, until the program that moves the arm has ended."""
    with connect_sensor(server, name=CAMERA, patience_s=60.0) as sensor:
        sensor.wait_for_coordinator(within=60.0)
        belt = Belt(Transform(*sensor.status.t6), SPEED, coming(sensor.time))
        try:
            while True:
                sensor.sleep(FRAME)
                taken = sensor.time - LATE
                sensor.observe("part", belt.picture(taken), at=taken, predict="velocity")
        except LeaseError as over:
            print(over)


if __name__ == "__main__":
    camera(*sys.argv[1:])

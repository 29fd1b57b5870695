"""A peg into a hole (thesis Fig. 1.1): approach, chamfer, insertion, release, retreat.

    rfms run examples/peg_in_hole.py --arm puma560 --scene peg:x_mm=1,tilt_x_deg=0.5 \\
        --friction thesis --dither 0.9 --sensor good

The program knows where the hole should be; the scene has put it elsewhere, and it leans. So the arm
is rigid on its way there, and complies along x and y of the peg's end while it goes slowly down the
chamfer, and about x and y too once the hole leads the peg; along z alone it pushes. With
``--sensor good`` forces are capped, and the force loop is closed over the wrist sensor.

It gives up, and says how deep the peg is, where a force reaches its cap or the time is over. The
gripper lets go of the peg before the arm leaves; in the simulator, which holds the peg rigidly, it
comes out again, so the arm goes on complying until it is out.
"""

import math

from rfms_can.coordinator import Arm, ProgramError, Transform

DOWN = Transform.rotation((0.0, 1.0, 0.0), math.pi)
"""The hand looks down: the peg's z into the hole."""
HOLE = Transform.translation(0.6, 0.15, 0.0)
"""Where the middle of the hole's mouth should be, z out of it."""
PEG_END = Transform.translation(0.0, 0.0, 0.16)
"""The end of the peg in T6: what goes into the hole, and the frame in which the arm complies."""
PEG_MASS = 0.148
"""kg."""
PEG_CENTRE = (0.0, 0.0, 0.13)
"""Its centre of mass in T6, m."""

DEPTH = 0.040
"""How deep the peg shall get, m."""
SHORT = 0.001
"""How much short of that it may end, m."""
CAPS = {"fx": 150.0, "fy": 150.0, "fz": 150.0}
"""Forces at which the program gives up, N."""
TIME_LIMIT = 14.0
"""Time from the start of the program at which it gives up, s."""

ABOVE = 0.005
"""Height over the mouth at which the peg arrives, m."""
NEAR = 0.001
"""Height from which it complies and is slow, m."""
ENTERED = 0.006
"""Depth at which it has passed the chamfer, m."""
GUIDED = 0.028
"""Depth from which the hole turns the peg, m: here its clearance leaves it 0.8 degrees."""
APPROACH_TIME = 1.5
"""s."""
NEAR_SPEED, ENTRY_SPEED, SPEED, LAST_SPEED = 0.03, 0.003, 0.02, 0.01
"""Towards the mouth, through the chamfer, down the hole, and to its bottom, m/s."""
WATCH = 0.02
"""Time between two looks at how it goes, s."""


def program(arm: Arm) -> None:
    """Put the peg into the hole, let go of it, and withdraw."""
    deadline, loop = arm.time + TIME_LIMIT, arm.status.force_loop
    end = arm.transform("end of the peg", PEG_END)
    hole = arm.transform("hole", HOLE @ DOWN)

    def at(name: str, depth: float) -> str:
        place = arm.transform(name, Transform.translation(0.0, 0.0, depth))
        return arm.position(f"peg {name}", arm.t6 @ end == hole @ place, tool=end)

    def straight(name: str, speed: float) -> str:
        return arm.mode(
            name,
            speed=speed,
            acceleration_time=0.1,
            interpolation="cartesian",
            stop_on_force=CAPS if loop != "none" else None,
        )

    above, near = at("above", -ABOVE), at("near", -NEAR)
    entered, guided, bottom = at("entered", ENTERED), at("guided", GUIDED), at("bottom", DEPTH)
    go = arm.mode(
        "go",
        segment_time=APPROACH_TIME,
        acceleration_time=0.3,
        mass=PEG_MASS,
        mass_centre=PEG_CENTRE,
    )
    enter, insert = straight("enter", ENTRY_SPEED), straight("insert", SPEED)
    finish, leave = straight("finish", LAST_SPEED), straight("leave", 2.0 * SPEED)
    slow = arm.mode("slow", speed=NEAR_SPEED, acceleration_time=0.1, interpolation="cartesian")

    arm.gripper.close()  # it holds the peg
    arm.wait(arm.move(above, go))
    if loop != "none":
        arm.tare()
    arm.wait(arm.move(near, slow))

    arm.comply("fx fy", 0.0, 0.0)
    push(arm, entered, enter, deadline)
    push(arm, guided, insert, deadline)
    arm.comply("rx ry", 0.0, 0.0)
    push(arm, bottom, finish, deadline)
    if depth(arm) < DEPTH - SHORT:
        give_up(arm, "it goes no further")

    arm.release()
    push(arm, near, leave, deadline)
    arm.lock("fx fy rx ry")
    arm.wait(arm.move(above, slow))


def push(arm: Arm, to: str, mode: str, deadline: float) -> None:
    """A guarded move; give up where a force reaches its cap, or time is over."""
    move = arm.move(to, mode)
    while arm.status.completed < move and arm.guard is None:
        if arm.time > deadline:
            give_up(arm, f"{TIME_LIMIT:g} s are over")
        arm.sleep(WATCH)
    if arm.guard is not None:
        give_up(arm, arm.guard)


def give_up(arm: Arm, why: str) -> None:
    """Stop, and say how deep the peg is."""
    arm.stop()
    raise ProgramError(f"the peg is {1e3 * depth(arm):.1f} of {1e3 * DEPTH:g} mm deep: {why}")


def depth(arm: Arm) -> float:
    """How deep the peg is, m, by the encoders."""
    return -(HOLE.inverse() @ arm.pose @ PEG_END).pz

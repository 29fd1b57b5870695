"""A peg into a hole (thesis Fig. 1.1): approach, chamfer, insertion, release, retreat.

    rfms run examples/peg_in_hole.py --arm puma560 --scene peg:x_mm=1,tilt_x_deg=0.5 \\
        --friction thesis --dither 0.9

The program knows where the hole should be; the scene has put it elsewhere, and it leans. So the arm
is rigid on its way there, complies along x and y of the peg's end as it goes slowly down the
chamfer, about x and y too once the hole has the peg, and pushes along z alone. It needs no sensor;
with ``--sensor good`` the force loop is closed over it.

It gives up, and says how deep the peg is, where a force reaches a cap or the time is over. The
gripper lets go of the peg at the end; in the simulator, which holds it rigidly, it comes out again.
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
SHORT = 0.002
"""How much short of that it may end, m."""
CAPS = {"fx": 80.0, "fy": 80.0, "fz": 80.0}
"""Forces at which the program gives up, N."""
TIME_LIMIT = 8.0
"""Time from the start of the program at which it gives up, s."""

ABOVE = 0.005
"""Height over the mouth at which the peg arrives, m."""
NEAR = 0.001
"""Height from which it complies and is slow, m."""
ENTERED = 0.006
"""Depth at which it has passed the chamfer, m."""
GUIDED = 0.020
"""Depth from which the hole turns the peg, m."""
APPROACH_TIME = 1.5
"""s."""
NEAR_SPEED, ENTRY_SPEED, SPEED = 0.02, 0.004, 0.025
"""Towards the mouth, through the chamfer, and down the hole, m/s."""
WATCH = 0.02
"""Time between two looks at how it goes, s."""


def program(arm: Arm) -> None:
    """Put the peg into the hole, let go of it, and withdraw."""
    deadline = arm.time + TIME_LIMIT
    end = arm.transform("end of the peg", PEG_END)
    hole = arm.transform("hole", HOLE @ DOWN)

    def at(name: str, depth: float) -> str:
        place = arm.transform(name, Transform.translation(0.0, 0.0, depth))
        return arm.position(f"peg {name}", arm.t6 @ end == hole @ place, tool=end)

    above, near = at("above", -ABOVE), at("near", -NEAR)
    entered, guided, bottom = at("entered", ENTERED), at("guided", GUIDED), at("bottom", DEPTH)

    go = arm.mode(
        "go",
        segment_time=APPROACH_TIME,
        acceleration_time=0.3,
        mass=PEG_MASS,
        mass_centre=PEG_CENTRE,
    )
    slow = arm.mode("slow", speed=NEAR_SPEED, acceleration_time=0.1, interpolation="cartesian")
    enter = arm.mode(
        "enter",
        speed=ENTRY_SPEED,
        acceleration_time=0.1,
        interpolation="cartesian",
        stop_on_force=CAPS,
    )
    insert = arm.mode(
        "insert",
        speed=SPEED,
        acceleration_time=0.1,
        interpolation="cartesian",
        stop_on_force=CAPS,
    )

    arm.gripper.close()  # it holds the peg
    arm.move(above, go)
    arm.wait(arm.move(near, slow))

    arm.comply("fx fy", 0.0, 0.0)
    push(arm, entered, enter, deadline)
    push(arm, guided, insert, deadline)
    arm.comply("rx ry", 0.0, 0.0)
    push(arm, bottom, insert, deadline)
    if depth(arm) < DEPTH - SHORT:
        give_up(arm, "it goes no further")

    arm.lock("fx fy rx ry")
    arm.release()
    arm.wait(arm.move(above, go))


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

"""Tracing a corner (thesis Fig. 5.1): a block slides along a wall, into the corner, along the next.

    rfms run examples/trace_corner.py --arm puma560 --scene corner:turn_deg=2 --sensor good

As the thesis has it: along AB the block complies in y and about z and x, at B it is switched to
comply along x and about z and y, and goes on to C; the other directions are position controlled. A
bias force presses it against the wall, which aligns it. It detects B by the contact force there.
"""

import math

from rfms_can.coordinator import Arm, ProgramError, Transform

DOWN = Transform.rotation((0.0, 1.0, 0.0), math.pi)
"""The hand looks down: its x is -x of the corner, its y is y."""
CORNER = Transform.translation(0.6, 0.2, 0.0)
"""Nominal frame at B: AB is the plane y = 0, BC the plane x = 0, the block comes from -x."""
TIP = Transform.translation(0.0, 0.0, 0.12)
"""The middle of the block in T6, in which it complies."""
HALF = 0.02
"""Half its width, m."""
TOOL_MASS = 0.822
"""kg."""
TOOL_CENTRE = (0.0, 0.0, 0.1044)
"""Its centre of mass in T6, m."""

LENGTH = 0.08
"""Distance along each wall, m."""
SPEED = 0.025
"""Along the walls, m/s."""
GAP = 0.005
"""Distance from the wall at which a guarded move starts, m; and tolerance along a wall, m."""
FEEL_SPEED = 0.005
"""Towards a wall, m/s."""
TOUCH = 15.0
"""Contact force that detects a wall, N."""
FORCE = 20.0
"""Against the wall, N."""
SETTLE = 0.25
"""Waiting time after contact, s: the wall aligns the block."""


def program(arm: Arm) -> None:
    """From free motion to A, along AB, switch, along BC, and away."""
    tip = arm.transform("tip", TIP)
    corner = arm.transform("corner", CORNER @ DOWN)

    def at(name: str, x: float, y: float) -> str:
        off = arm.transform(name, Transform.translation(-x, y, 0.0))
        return arm.position(f"block {name}", arm.t6 @ tip == corner @ off, tool=tip)

    def straight(name: str, speed: float, **guard: float) -> str:
        return arm.mode(
            name,
            speed=speed,
            acceleration_time=0.1,
            interpolation="cartesian",
            stop_on_force=guard or None,
        )

    start = -HALF - LENGTH
    free, at_a = at("before A", start, -HALF - GAP), at("at A", start, -HALF)
    into_a = at("into the wall at A", start, -HALF + GAP)
    before_b, beyond_b = at("before B", -HALF - GAP, -HALF), at("beyond B", -HALF + GAP, -HALF)
    at_b, at_c = at("at B", -HALF, -HALF), at("at C", -HALF, start)
    away = at("away", -2.0 * HALF, start)
    go = arm.mode(
        "go",
        segment_time=1.5,
        acceleration_time=0.3,
        mass=TOOL_MASS,
        mass_centre=TOOL_CENTRE,
    )
    settle = arm.mode(
        "settle", segment_time=SETTLE, acceleration_time=0.1, interpolation="cartesian"
    )
    trace, leave = straight("trace", SPEED), straight("leave", 2.0 * SPEED)
    feel_ab = straight("feel AB", FEEL_SPEED, fy=TOUCH)
    feel_bc = straight("feel BC", FEEL_SPEED, fx=TOUCH)

    arm.wait(arm.move(free, go))
    arm.tare()
    feel(arm, into_a, feel_ab)

    arm.comply("fy rx rz", FORCE, 0.0, 0.0)  # AB
    arm.move(at_a, settle)
    arm.move(before_b, trace)
    feel(arm, beyond_b, feel_bc)

    arm.lock("fy rx")
    arm.comply("fx ry rz", -FORCE, 0.0, 0.0)  # BC: its wall lies along -x of the hand
    arm.move(at_b, settle)
    arm.move(at_c, trace)

    arm.lock("fx ry rz")
    arm.wait(arm.move(away, leave))


def feel(arm: Arm, to: str, mode: str) -> None:
    """Guarded move until contact with a wall."""
    arm.wait(arm.move(to, mode))
    if arm.guard is None:
        raise ProgramError(f"no wall on the way to {to}")

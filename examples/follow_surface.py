"""Following a surface of uncertain position with a contact force.

    rfms run examples/follow_surface.py --arm puma560 --scene surface:tilt_y_deg=10 --sensor good
    rfms run examples/follow_surface.py --arm puma560 --scene curved --sensor good

The program assumes a flat plate: it moves along x at one height. The plate is tilted, or is a
cylinder. It approaches with a guarded move, complies along the tool's z with a bias force, and
moves; ``arm.complied`` is the displacement of the arm from its path by the surface.
"""

import math

from rfms_can.coordinator import Arm, ProgramError, Transform

DOWN = Transform.rotation((0.0, 1.0, 0.0), math.pi)
PLACE = Transform.translation(0.6, 0.15, 0.0)
"""Nominal frame at the middle of the surface, z out of it."""
TIP = Transform.translation(0.0, 0.0, 0.16)
"""The ball's foremost point in T6."""
TOOL_MASS = 0.388
"""kg."""
TOOL_CENTRE = (0.0, 0.0, 0.0896)
"""Its centre of mass in T6, m."""

LENGTH = 0.1
"""Distance along x, from before the middle to behind it, m."""
SPEED = 0.05
"""m/s."""
FORCE = 20.0
"""Along the tool's z, N."""
REST = 0.5
"""Pressing at rest, before the path and after it, s."""

ABOVE, BELOW = 0.025, 0.025
"""Heights of the guarded move, m."""
FEEL_SPEED = 0.01
"""m/s."""
TOUCH, TOUCH_BLIND = 10.0, 70.0
"""Force that stops it, with a sensor and without, N."""


def program(arm: Arm) -> None:
    """Touch down, follow the surface, and leave."""
    tip = arm.transform("tip", TIP)
    place = arm.transform("place", PLACE @ DOWN)

    def at(name: str, x: float, height: float) -> str:
        off = arm.transform(name, Transform.translation(-x, 0.0, -height))  # down: x is turned over
        return arm.position(f"tip {name}", arm.t6 @ tip == place @ off, tool=tip)

    half = 0.5 * LENGTH
    above, below = at("above", -half, ABOVE), at("below", -half, -BELOW)
    begin, end = at("at the beginning", -half, 0.0), at("at the end", half, 0.0)
    away = at("away", half, 2.0 * ABOVE)
    go = arm.mode(
        "go",
        segment_time=1.5,
        acceleration_time=0.3,
        mass=TOOL_MASS,
        mass_centre=TOOL_CENTRE,
    )
    sensed = arm.status.force_loop != "none"
    feel = arm.mode(
        "feel",
        speed=FEEL_SPEED,
        acceleration_time=0.1,
        interpolation="cartesian",
        stop_on_force={"fz": TOUCH if sensed else TOUCH_BLIND},
    )
    settle = arm.mode("settle", segment_time=0.4, acceleration_time=0.1, interpolation="cartesian")
    follow = arm.mode("follow", speed=SPEED, acceleration_time=0.1, interpolation="cartesian")
    leave = arm.mode("leave", speed=0.1, acceleration_time=0.1, interpolation="cartesian")

    arm.wait(arm.move(above, go))
    if sensed:
        arm.tare()
    arm.wait(arm.move(below, feel))
    if arm.guard is None:
        raise ProgramError(f"no surface within {1e3 * BELOW:g} mm of the nominal place")

    arm.comply("fz", FORCE)
    arm.wait(arm.move(begin, settle))  # its height is compliant
    arm.sleep(REST)
    arm.wait(arm.move(end, follow))
    print(f"led {1e3 * arm.complied[2]:.1f} mm along the tool, away from the path")
    arm.sleep(REST)
    arm.lock("fz")
    arm.wait(arm.move(away, leave))

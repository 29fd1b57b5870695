"""Contact from free motion: a guarded move down, then a constant contact force.

    rfms run examples/touch.py --arm puma560 --scene surface:z_mm=-7 --sensor good --dither 0.9

The plate is within 20 mm of its nominal place. A guarded move goes down to it and is stopped by the
contact force, or by the distance moved if there is no contact. Then the arm complies along the
tool's z and presses with a force, and moves up again relative to its position.

Without a sensor the force is estimated from the motors, and friction hides most of it: the guard
must be wide, and the force held is as uncertain.
"""

import math

from rfms_can.coordinator import Arm, ProgramError, Transform

DOWN = Transform.rotation((0.0, 1.0, 0.0), math.pi)
PLACE = Transform.translation(0.6, 0.15, 0.0)
"""Nominal frame at the middle of the plate, z out of it."""
TIP = Transform.translation(0.0, 0.0, 0.16)
"""The ball's foremost point in T6."""
TOOL_MASS = 0.388
"""kg."""
TOOL_CENTRE = (0.0, 0.0, 0.0896)
"""Its centre of mass in T6, m."""

ABOVE = 0.025
"""Height at which the guarded move starts, m."""
BELOW = 0.025
"""Depth at which it ends, m."""
SPEED = 0.01
"""Its speed, m/s."""
TOUCH = 10.0
"""Force that stops it, N."""
TOUCH_BLIND = 70.0
"""The same without a sensor, N."""
FORCE = 20.0
"""Held then, N."""
HOLD = 1.0
"""For so long, s."""


def program(arm: Arm) -> None:
    """Touch the plate, press on it, and leave."""
    tip = arm.transform("tip", TIP)
    place = arm.transform("place", PLACE @ DOWN)

    def at(name: str, height: float) -> str:
        off = arm.transform(name, Transform.translation(0.0, 0.0, -height))
        return arm.position(f"tip {name}", arm.t6 @ tip == place @ off, tool=tip)

    above, below = at("above", ABOVE), at("below", -BELOW)
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
        speed=SPEED,
        acceleration_time=0.1,
        interpolation="cartesian",
        stop_on_force={"fz": TOUCH if sensed else TOUCH_BLIND},
    )
    press = arm.mode(
        "press",
        segment_time=HOLD,
        acceleration_time=0.1,
        interpolation="cartesian",
        comply={"fz": FORCE},
    )
    leave = arm.mode("leave", speed=0.05, acceleration_time=0.1, interpolation="cartesian")

    arm.wait(arm.move(above, go))
    if sensed:
        arm.tare()
    arm.wait(arm.move(below, feel))
    if arm.guard is None:
        raise ProgramError(f"there is nothing within {1e3 * BELOW:g} mm of the place")
    touched = height(arm)
    print(f"touched at {1e3 * touched:.2f} mm: {arm.guard}")

    here = arm.transform("here", arm.pose @ TIP)
    arm.wait(arm.move(arm.position("tip here", arm.t6 @ tip == here, tool=tip), press))
    force = f"{arm.force[2]:.1f} N" if sensed else f"{FORCE:g} N or so (no sensor)"
    print(f"pushes with {force}, {1e3 * (touched - height(arm)):.2f} mm deeper")
    arm.wait(arm.move(above, leave))


def height(arm: Arm) -> float:
    """Height of the tip over the nominal plate by the encoders, m."""
    return (PLACE.inverse() @ arm.pose @ TIP).pz

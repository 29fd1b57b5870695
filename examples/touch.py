"""Contact from free motion: down until it touches, then a force held on what was met.

    rfms run examples/touch.py --arm puma560 --scene surface:z_mm=-7 --sensor good --dither 0.9

The plate lies anywhere within 20 mm of where it should. A guarded move goes down to it and is
stopped by the force it meets, or by the way it has gone if there is nothing. Then the arm complies
along the tool's z and pushes with a force, and goes up again by a way relative to where it was.

Without a sensor a force is guessed from the motors, and friction hides most of it: the guard must
be wide, and what is held is as uncertain.
"""

import math

from rfms_can.coordinator import Arm, ProgramError, Transform

DOWN = Transform.rotation((0.0, 1.0, 0.0), math.pi)
PLACE = Transform.translation(0.6, 0.15, 0.0)
"""Where the middle of the plate should be, z out of it."""
TIP = Transform.translation(0.0, 0.0, 0.16)
"""The ball's foremost point in T6."""
TOOL_MASS = 0.388
"""kg."""
TOOL_CENTRE = (0.0, 0.0, 0.0896)
"""Its centre of mass in T6, m."""

ABOVE = 0.025
"""Height from which it feels its way down, m."""
BELOW = 0.025
"""Depth to which it does, m."""
SPEED = 0.01
"""At which it does, m/s."""
TOUCH = 10.0
"""Force that stops it, N."""
TOUCH_BLIND = 70.0
"""The same without a sensor, N."""
FORCE = 20.0
"""Held then, N."""
HOLD = 1.0
"""For so long, s."""


def program(arm: Arm) -> None:
    """Touch the plate, push on it, and leave."""
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
    """Of the tip over where the plate should be, m, by the encoders."""
    return (PLACE.inverse() @ arm.pose @ TIP).pz

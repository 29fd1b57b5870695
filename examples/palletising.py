"""Palletising: parts from a feeder onto a pallet, row by row.

    rfms run examples/palletising.py

Every place of the pallet is the corner of the pallet times a translation, ``pallet @ place(i, j)``,
so a pallet that stands askew is one transform. Modes give speeds instead of times: each segment
takes the time of its distance, and is lengthened where a joint would exceed its speed limit.
"""

import math

from rfms_can.coordinator import Arm, Transform

DOWN = Transform.rotation((0.0, 1.0, 0.0), math.pi)
"""The hand looks down: its approach axis along -z of the bench."""

COLUMNS, ROWS = 3, 2
"""Places on the pallet."""

PITCH = 0.04
"""From one place to the next, m."""

ASKEW = math.radians(10.0)
"""How the pallet is turned on the bench."""


def program(arm: Arm) -> None:
    """Fill the pallet and go home, joint by joint: on the turns the arm was parked on."""
    hand = arm.pose
    tool = arm.transform("tool", Transform.translation(0.0, 0.0, 0.1354))
    bench = Transform.translation(hand.px, hand.py, hand.pz - 0.24)
    pallet = arm.transform("pallet", bench @ pallet_on_bench())
    feeder = arm.transform("feeder", bench @ Transform.translation(0.03, 0.20, 0.02) @ DOWN)
    down = arm.transform("down", DOWN)
    back = arm.transform("back", Transform.translation(0.0, 0.0, -0.05))

    far = arm.mode("far", speed=0.4, joint_speed=0.6, acceleration_time=0.2, lengthen=True)
    near = arm.mode(
        "near", speed=0.12, acceleration_time=0.15, interpolation="cartesian", lengthen=True
    )
    park = arm.joint_position("park", arm.joints)
    at_feeder = arm.position("at feeder", arm.t6 @ tool == feeder)
    over_feeder = arm.position("over feeder", arm.t6 @ tool == feeder @ back)

    for i in range(COLUMNS):
        for j in range(ROWS):
            name = f"place {i} {j}"
            place = arm.transform(name, place_on_pallet(i, j))
            at_place = arm.position(f"at {name}", arm.t6 @ tool == pallet @ place @ down)
            over_place = arm.position(f"over {name}", arm.t6 @ tool == pallet @ place @ down @ back)
            arm.move(over_feeder, far)
            arm.wait(arm.move(at_feeder, near))
            arm.gripper.close()
            arm.move(over_feeder, near)
            arm.move(over_place, far)
            arm.wait(arm.move(at_place, near))
            arm.gripper.open()
            arm.move(over_place, near)
    arm.move(park, far)
    arm.wait()


def pallet_on_bench() -> Transform:
    """The corner of the pallet where place 0 0 is."""
    return Transform.translation(-0.02, -0.10, 0.02) @ Transform.rotation((0.0, 0.0, 1.0), ASKEW)


def place_on_pallet(i: int, j: int) -> Transform:
    """Place in column ``i``, row ``j``."""
    return Transform.translation(i * PITCH, j * PITCH, 0.0)

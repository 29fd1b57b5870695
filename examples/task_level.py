"""A peg into a hole at the task level: motions said by what they relate.

    rfms run examples/task_level.py --arm puma560 --scene peg:x_mm=1,tilt_x_deg=0.5 \\
        --friction thesis --dither 0.9 --sensor good

What ``peg_in_hole.py`` does by positions, modes and moves is said here by two frames, the end of
the peg and the mouth of the hole: approach, insert, let go, depart. The task prints itself as a
program before it runs; what it defines is removed at its end, so it may run again.
"""

import math

from rfms_can.coordinator import Arm, Transform
from rfms_can.task import GUIDED, Frame, Tare, Task, approach, depart, insert, release

DOWN = Transform.rotation((0.0, 1.0, 0.0), math.pi)
PEG = Frame("peg", Transform.translation(0.0, 0.0, 0.16))
"""The end of the peg in T6."""
HOLE = Frame("hole", Transform.translation(0.6, 0.15, 0.0) @ DOWN)
"""Where the mouth of the hole should be, z into it."""
MOUTH = HOLE @ Frame("1 mm before", Transform.translation(0.0, 0.0, -0.001))
"""Where the peg is brought to."""
PEG_LOAD = {"segment_time": 1.5, "mass": 0.148, "mass_centre": (0.0, 0.0, 0.13)}
"""A free motion with the peg in the hand: s, kg, m."""

DEPTH, CHAMFER, GUIDES = 0.040, 0.006, 0.028
"""How deep the peg shall get; where it has passed the chamfer; from where the hole turns it, m."""
BOUNDS = {"fx": 150.0, "fy": 150.0, "fz": 150.0}
"""Forces at which it gives up, N, if they are measured."""


def assembly(sensed: bool) -> Task:
    """Approach, tare, insert, let go, and withdraw."""
    return (
        approach(PEG, MOUTH, by=(0.0, 0.0, -0.02), speed=0.03, far=PEG_LOAD)
        + Task("tare", (Tare(),) if sensed else ())
        + insert(PEG, HOLE, DEPTH, chamfer=CHAMFER, guided=GUIDES, force=BOUNDS if sensed else None)
        + release()
        + depart(PEG, HOLE, by=(0.0, 0.0, -0.005), speed=0.04, comply=GUIDED)
    ).named("assembly")


def program(arm: Arm) -> None:
    """Say the task, and do it."""
    task = assembly(arm.status.force_loop != "none")
    print(task)
    arm.gripper.close()  # it holds the peg
    report = task.run(arm)
    if report.depth is not None:
        print(f"{1e3 * report.depth:.1f} mm deep, in {len(report.outcomes)} moves")

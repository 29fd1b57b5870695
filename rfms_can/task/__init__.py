"""A task level above the program API (thesis Ch. VII): motions said by what they relate.

::

    peg = Frame("peg", Transform.translation(0.0, 0.0, 0.16))
    hole = Frame("hole", Transform.translation(0.6, 0.15, 0.0) @ DOWN)
    task = approach(peg, hole) + insert(peg, hole, 0.04, chamfer=0.006, guided=0.028)
    print(task)  # as a program
    report = task.change("near", speed=0.05).run(arm)

A task is data, and an ordinary program: everything it does is a call of ``Arm``.
"""

from rfms_can.task.actions import Comply, Grip, Lock, Move, Sleep, Tare
from rfms_can.task.contact import Follow, Insertion, Touch
from rfms_can.task.definitions import DefineMode, DefinePosition, DefineTransform
from rfms_can.task.frames import Frame
from rfms_can.task.primitives import (
    GUIDED,
    MOUTH,
    approach,
    depart,
    follow,
    grip,
    guarded_approach,
    insert,
    release,
)
from rfms_can.task.steps import Step
from rfms_can.task.task import Report, Task

__all__ = [
    "GUIDED",
    "MOUTH",
    "Comply",
    "DefineMode",
    "DefinePosition",
    "DefineTransform",
    "Follow",
    "Frame",
    "Grip",
    "Insertion",
    "Lock",
    "Move",
    "Report",
    "Sleep",
    "Step",
    "Tare",
    "Task",
    "Touch",
    "approach",
    "depart",
    "follow",
    "grip",
    "guarded_approach",
    "insert",
    "release",
]

"""The program of a system of processes: to and fro without a rest, as on the simulated bus."""

from typing import Final

from rfms_can.arm import arm_by_name
from rfms_can.coordinator import Arm as Program
from rfms_can.faults.table import State
from rfms_can.faults.warm import approach, go_to_and_fro
from rfms_can.rig.session import Program as Runs

LONG: Final = 40
"""Strokes of a run that a fault ends: a busy machine may put it in late."""


def program_of(arm: str, strokes: int) -> Runs:
    """The program of an arm, by its name, with so many strokes."""
    model = arm_by_name(arm)

    def program(hand: Program) -> None:
        approach(hand, model, State.MOVING)
        go_to_and_fro(hand, strokes)

    return program

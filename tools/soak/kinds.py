"""The kinds of programs, in one table; a program of a kind is drawn by arm and seed."""

from random import Random
from typing import Any, Final, NamedTuple

from rfms_can.arm import ARMS, arm_by_name
from rfms_can.plant.variant import WITH_LOAD
from rfms_can.rig.settings import RunSettings
from soak import contacts, motions
from soak.motions import Drawn, Make

BOTH: Final = tuple(ARMS)
PLANTS: Final = 1_000_000
"""Worn plants that are drawn from."""
IN_SCENES: Final = ("puma560",)
"""Scenes stand in front of this arm only."""


class Kind(NamedTuple):
    """A kind of program.

    Attributes:
        make: draws one.
        arms: that can run it.
        every: seeds from one to the next: programs that are long are few.
    """

    make: Make
    arms: tuple[str, ...] = BOTH
    every: int = 1


KINDS: Final[dict[str, Kind]] = {
    "random": Kind(motions.random_programs),
    "strokes": Kind(motions.strokes),
    "endurance": Kind(motions.endurance, every=4),
    "corners": Kind(motions.corners),
    "payload": Kind(motions.payload),
    "excitation": Kind(motions.excitation),
    "restarts": Kind(motions.restarts),
    "conveyor": Kind(contacts.conveyor),
    "tracking": Kind(contacts.tracking),
    "floating": Kind(contacts.floating),
    "examples": Kind(contacts.examples),
    "guarded": Kind(contacts.guarded, IN_SCENES),
    "surface": Kind(contacts.surface, IN_SCENES),
    "peg": Kind(contacts.peg, IN_SCENES),
    "edges": Kind(contacts.edges, IN_SCENES),
}


class Job(NamedTuple):
    """A program of the soak.

    Attributes:
        kind: of ``KINDS``.
        arm: name of the arm.
        seed: draws the program, the friction, the boards and their noise.
        worn: whether the plant is worn; otherwise it is that of the data sheet.
    """

    kind: str
    arm: str
    seed: int
    worn: bool = True

    @property
    def name(self) -> str:
        """As the tool takes it again."""
        return f"--kind {self.kind} --arm {self.arm} --first {self.seed} --seeds 1" + (
            "" if self.worn else " --new"
        )

    @property
    def draw(self) -> Random:
        """Random numbers of the program."""
        return Random(f"{self.kind}:{self.arm}:{self.seed}")

    def drawn(self, draw: Random) -> Drawn:
        """The program."""
        return KINDS[self.kind].make(draw, arm_by_name(self.arm))

    def settings(self, drawn: Drawn, start: int) -> RunSettings:
        """Of the run; ``start`` counts how often the arm was switched on before."""
        number = Random(f"{self.name}:{start}").randrange(PLANTS)
        plant = (f"worn:{number}" if self.worn else "nominal") + WITH_LOAD * drawn.load
        settings: dict[str, Any] = {"arm": self.arm, "plant": plant, "seed": number}
        return RunSettings(**(settings | drawn.settings))


def jobs_of(kinds: list[str], arms: list[str], seeds: range, *, worn: bool = True) -> list[Job]:
    """Programs of some kinds on some arms, seed by seed."""
    return [
        Job(kind, arm, seed, worn)
        for seed in seeds
        for kind in kinds
        for arm in arms
        if arm in KINDS[kind].arms and not seed % KINDS[kind].every
    ]

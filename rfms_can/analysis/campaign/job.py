"""One run of a campaign: its parameters and its result."""

import math
import random
from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple

import msgspec

from rfms_can.compliance import LAWS, ControlLaw
from rfms_can.rig.settings import RunSettings

ARM: Final = "puma560"
SENSOR: Final = "good"
"""In every run: the force cap of the program is felt with it, whether or not the loop is closed."""
FRICTIONS: Final = ("thesis", "none")


class Task(NamedTuple):
    """Force loop and largest misalignment of the hole.

    Attributes:
        loop: ``open`` or ``closed``.
        offset_mm, tilt_deg: largest offset and tilt of the hole.
    """

    loop: str
    offset_mm: float
    tilt_deg: float


TASKS: Final = (
    Task("open", 1.0, 0.5),
    Task("closed", 2.0, 1.0),
)


class Misalignment(NamedTuple):
    """Of the hole.

    Attributes:
        x_mm, y_mm: across its axis.
        tilt_x_deg, tilt_y_deg: of its axis.
    """

    x_mm: float
    y_mm: float
    tilt_x_deg: float
    tilt_y_deg: float

    @classmethod
    def drawn(cls, seed: int, offset_mm: float, tilt_deg: float) -> "Misalignment":
        """The misalignment of a seed: uniform in a disk each, the same for all laws."""
        numbers = random.Random(seed)

        def in_disk(radius: float) -> tuple[float, float]:
            size, angle = radius * math.sqrt(numbers.random()), numbers.uniform(-math.pi, math.pi)
            return round(size * math.cos(angle), 4), round(size * math.sin(angle), 4)

        return cls(*in_disk(offset_mm), *in_disk(tilt_deg))

    @property
    def scene(self) -> str:
        """The scene with it."""
        return "peg:" + ",".join(
            f"{name}={value:g}" for name, value in zip(self._fields, self, strict=True)
        )


class Group(NamedTuple):
    """Runs that differ in their misalignment alone.

    Attributes:
        law: how the arm complies.
        loop: ``open`` or ``closed``.
        friction: friction set of the arm; its servos compensate the same.
        offset_mm, tilt_deg: largest offset and tilt of the hole.
    """

    law: str
    loop: str
    friction: str
    offset_mm: float
    tilt_deg: float


def groups_of(
    tasks: Iterable[Task], frictions: Sequence[str], laws: Iterable[ControlLaw] = tuple(ControlLaw)
) -> list[Group]:
    """Laws at every task, friction by friction.

    A law that does not comply has no force loop to close.
    """
    made = (
        Group(law.value, loop if LAWS[law].complies else "open", friction, offset, tilt)
        for loop, offset, tilt in tasks
        for friction in frictions
        for law in laws
    )
    return list(dict.fromkeys(made))


class Job(NamedTuple):
    """One run.

    Attributes:
        group: what it belongs to.
        seed: draws its misalignment.
        dither: fraction of the friction, 0 to 1.
    """

    group: Group
    seed: int
    dither: float

    @property
    def settings(self) -> RunSettings:
        """Of the run."""
        group = self.group
        misaligned = Misalignment.drawn(self.seed, group.offset_mm, group.tilt_deg)
        return RunSettings(
            arm=ARM,
            friction=group.friction,
            law=ControlLaw(group.law).value,
            force_loop=group.loop,
            sensor=SENSOR,
            dither=self.dither,
            scene=misaligned.scene,
            seed=self.seed + 1,
        )


class Insertion(msgspec.Struct, frozen=True):
    """Result of a run.

    Attributes:
        law, loop, friction, offset_mm, tilt_deg, seed: the job.
        inserted: whether the peg was fully inserted, and the program ended without an error.
        why: why not, in words.
        depth: of the insertion, m.
        lateral_peak: largest force across the peg of any cycle's mean, N, until it was in.
        lateral_mean: mean of that force over the cycles in contact, N.
        axial_peak: largest force along the peg, likewise, N.
        seconds: from the first contact until it was in, or the end of the run.
    """

    law: str
    loop: str
    friction: str
    offset_mm: float
    tilt_deg: float
    seed: int
    inserted: bool
    why: str
    depth: float
    lateral_peak: float
    lateral_mean: float
    axial_peak: float
    seconds: float

    @property
    def group(self) -> Group:
        """Its group."""
        return Group(self.law, self.loop, self.friction, self.offset_mm, self.tilt_deg)

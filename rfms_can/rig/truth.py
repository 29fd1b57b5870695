"""Ground truth of contact with a scene, read from the plant and not from the bus.

Available only if the plant is in this process: on the simulated bus.
"""

import math
from typing import Final, NamedTuple

import msgspec

from rfms_can.plant.contact_wrench import Contacts
from rfms_can.plant.physics import PlantPhysics
from rfms_can.transform import Transform

COLUMNS: Final = (
    *("cycle", "points", "depth"),
    *("fx", "fy", "fz", "mx", "my", "mz"),
    *("x", "y", "z", "nx", "ny", "nz", "ax", "ay", "az"),
    *("wrist_fx", "wrist_fy", "wrist_fz", "wrist_mx", "wrist_my", "wrist_mz"),
    *("q1", "q2", "q3", "q4", "q5", "q6"),
)
"""Of ``truth.csv``; SI and radians. Forces and torques are means of the control period that ends at
the cycle's SYNC, ``points`` the maximum in it; the other columns are values at its end."""


class Truth(NamedTuple):
    """One cycle, at its SYNC.

    Attributes:
        cycle: its number.
        contact: of tool and fixtures in the period before, along the axes of the tip.
        tip: pose of the tip, in the frame of the place (``Scene.place``).
        wrist: wrench of the hand on the tool at T6, mean of that period, (6,), N and Nm.
        q: joint angles, rad.
    """

    cycle: int
    contact: Contacts
    tip: Transform
    wrist: tuple[float, ...]
    q: tuple[float, ...]

    def row(self) -> list[float]:
        """Values of :data:`COLUMNS`."""
        contact, tip = self.contact, self.tip
        return [
            *(self.cycle, contact.points, contact.depth, *contact.force, *contact.torque),
            *(tip.px, tip.py, tip.pz, tip.nx, tip.ny, tip.nz, tip.ax, tip.ay, tip.az),
            *(*self.wrist, *self.q),
        ]


class SceneResult(msgspec.Struct, frozen=True):
    """Contact with the scene in a run: N and m, forces on the tool along the axes of its tip.

    Attributes:
        scene: as given in the settings.
        contact_cycles: cycles in which the tool touched a fixture.
        largest_force, largest_lateral, largest_axial: force, its component perpendicular to z of
            the tip, and its component along it: the largest mean of a control period; an impact
            within a period is higher.
        largest_depth: penetration of tool and fixture.
        lowest: minimum of the tip's z in the frame of the place; a peg's depth is -lowest.
        tip: position of the tip in the place at the end.
        touching: whether the tool touched a fixture at the end.
    """

    scene: str
    contact_cycles: int
    largest_force: float
    largest_lateral: float
    largest_axial: float
    largest_depth: float
    lowest: float
    tip: tuple[float, float, float]
    touching: bool


class SceneWatch:
    """Watches a plant, cycle by cycle.

    Args:
        physics: the plant's.
        scene: as given in the settings.

    Attributes:
        rows: the truth, if kept.
    """

    def __init__(self, physics: PlantPhysics, scene: str) -> None:
        self._keep = False
        self._physics = physics
        self._scene = scene
        self.begin()

    def begin(self) -> None:
        """Start counting and recording."""
        self.rows: list[Truth] = []
        self._cycles = 0
        self._force = self._lateral = self._axial = self._depth = 0.0
        self._lowest = math.inf

    def keep_every_cycle(self) -> None:
        """Keep the truth of every cycle from now on, not the largest values alone."""
        self._keep = True

    def look(self, cycle: int) -> None:
        """A period has been integrated, and this cycle begins."""
        physics = self._physics
        tip = physics.tip_in_place()
        self._lowest = min(self._lowest, tip.pz)
        contact = physics.contact_force()
        if contact.points:
            self._meet(contact)
        if self._keep:
            wrist, q = tuple(physics.true_force), tuple(physics.true_q)
            self.rows.append(Truth(cycle, contact, tip, wrist, q))

    def _meet(self, contact: Contacts) -> None:
        x, y, z = contact.force
        lateral = math.hypot(x, y)
        self._cycles += 1
        self._force = max(self._force, math.hypot(lateral, z))
        self._lateral = max(self._lateral, lateral)
        self._axial = max(self._axial, abs(z))
        self._depth = max(self._depth, contact.depth)

    def result(self) -> SceneResult:
        """The numbers so far."""
        physics = self._physics
        tip = physics.tip_in_place()
        return SceneResult(
            self._scene,
            self._cycles,
            self._force,
            self._lateral,
            self._axial,
            self._depth,
            min(self._lowest, tip.pz),
            (tip.px, tip.py, tip.pz),
            physics.contacts > 0,
        )

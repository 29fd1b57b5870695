"""What stands around the arm and what it holds: shapes, their contact, a scene. SI units.

Data only, so that a scene can be looked at without a physics engine; ``model_builder.py`` hands it
to MuJoCo.
"""

from dataclasses import dataclass
from enum import Enum, auto
from typing import Final

from rfms_can.transform import Transform, Vector3


class Kind(Enum):
    """Shapes the plant knows, and what their ``size`` means."""

    BOX = auto()
    """Half lengths along x, y and z."""
    CYLINDER = auto()
    """Radius, half length along z, 0."""
    PLANE = auto()
    """Half lengths of what is drawn along x and y, 0; it is infinite, its normal is z."""


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """A rigid body that others touch.

    Attributes:
        kind: of shape.
        size: by ``kind``, m.
        pose: of its own frame, in the frame of the scene or of the hand.
    """

    kind: Kind
    size: Vector3
    pose: Transform


@dataclass(frozen=True, slots=True, eq=False)
class Tool:
    """What the hand holds, rigidly.

    Attributes:
        mass: kg.
        com: centre of mass in the T6 frame, m.
        inertia: about it, along the axes of T6, kg m2.
        shapes: in the T6 frame.
        tip: the frame its task is told in, in the T6 frame.
    """

    mass: float
    com: Vector3
    inertia: Vector3
    shapes: tuple[Shape, ...]
    tip: Transform


@dataclass(frozen=True, slots=True)
class Contact:
    """How two shapes push against one another.

    MuJoCo's contact is a spring and a damper per unit of the mass that meets in it, here given by
    natural frequency and damping ratio; what that makes of an arm's tip in N/m is measured
    (``tests/test_plant_scene.py``).

    Attributes:
        frequency: natural frequency, rad/s.
        damping: damping ratio.
        impedance: part of the contact force that is rigid, 0 to 1; the rest is the spring's.
        friction: sliding coefficient.
    """

    frequency: float = 1000.0
    damping: float = 1.0
    impedance: float = 0.95
    friction: float = 0.2


STEEL: Final = Contact()
"""Steel on steel, lubricated (P)."""


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """What an arm meets.

    Attributes:
        name: as it is asked for.
        fixtures: shapes in the base frame.
        tool: what the hand holds, or None.
        contact: between tool and fixtures.
        longest_step_s: physics step that resolves its contact, s.
    """

    name: str
    fixtures: tuple[Shape, ...] = ()
    tool: Tool | None = None
    contact: Contact = STEEL
    longest_step_s: float = 1e-3


FREE: Final = Scene("free")
"""Nothing but the arm."""

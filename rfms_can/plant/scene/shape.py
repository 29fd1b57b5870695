"""Fixtures around the arm and the tool in its hand: shapes, contact parameters, scenes. SI units.

Data only, so that a scene can be looked at without a physics engine; ``model_builder.py`` hands it
to MuJoCo.
"""

from dataclasses import dataclass
from enum import Enum, auto
from typing import Final

from rfms_can.transform import Transform, Vector3

_ORIGIN: Final = Transform.identity()

EDGE_RADIUS: Final = 0.25e-3
"""Radius of every edge of a solid shape, m: edges broken with a file (P)."""


class Kind(Enum):
    """Shapes the plant knows, and what their ``size`` means."""

    BOX = auto()
    """Half lengths along x, y and z."""
    CYLINDER = auto()
    """Radius, half length along z, 0."""
    SPHERE = auto()
    """Radius, 0, 0."""
    PLANE = auto()
    """Half lengths of what is drawn along x and y, 0; it is infinite, its normal is z."""


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """A rigid shape.

    Attributes:
        kind: of shape.
        size: by ``kind``, m; edges of a solid shape are rounded by ``EDGE_RADIUS``, inwards.
        pose: of its own frame, in the frame of the scene or of the hand.
        solid: False for a shape with mass but without contact.
    """

    kind: Kind
    size: Vector3
    pose: Transform
    solid: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class Tool:
    """A tool fixed rigidly in the hand.

    Attributes:
        mass: kg.
        com: centre of mass in the T6 frame, m.
        inertia: about it, along the axes of T6, kg m2.
        shapes: in the T6 frame; one of them solid.
        tip: the tool frame in which the task is given, in the T6 frame.
    """

    mass: float
    com: Vector3
    inertia: Vector3
    shapes: tuple[Shape, ...]
    tip: Transform


@dataclass(frozen=True, slots=True)
class Contact:
    """Contact parameters of two shapes, for each contact point.

    Attributes:
        stiffness: force per depth, N/m.
        damping: damping ratio, for the tool's mean effective mass.
        friction: sliding coefficient.
    """

    stiffness: float = 1e7
    damping: float = 1.0
    friction: float = 0.2


STEEL: Final = Contact()
"""Steel on steel, lubricated (P): 100 N sink in by 0.01 mm. A steel ball of 10 mm on a plate is as
stiff at 1.3 N, and three times as much at 50 N (Hertz, (6 E*^2 R F)^(1/3))."""

CONTACT_STEP_S: Final = 2.5e-4
"""Physics step that resolves this contact while joints stick and slip, s; 1 ms does not."""


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Tool and fixtures of a run.

    Attributes:
        name: as given on the command line.
        fixtures: shapes in the base frame.
        tool: what the hand holds, or None.
        place: true frame of the task in the base frame; a program knows the nominal one.
        contact: between tool and fixtures.
        longest_step_s: physics step that resolves its contact, s.
    """

    name: str
    fixtures: tuple[Shape, ...] = ()
    tool: Tool | None = None
    place: Transform = _ORIGIN
    contact: Contact = STEEL
    longest_step_s: float = 1e-3


FREE: Final = Scene("free")
"""Nothing but the arm."""

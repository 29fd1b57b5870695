"""A load in the hand: a known mass fixed rigidly to the flange."""

from dataclasses import dataclass, replace
from typing import Final

from rfms_can.arm.components import Link, Vector3
from rfms_can.arm.mechanism import JOINT_COUNT, Arm


@dataclass(frozen=True, slots=True)
class Load:
    """A load in the hand.

    Attributes:
        mass: kg.
        com: centre of mass in the T6 frame, m.
        inertia: xx, yy, zz about it, along the axes of T6, kg m2.
    """

    mass: float
    com: Vector3
    inertia: Vector3 = (0.0, 0.0, 0.0)


NOTHING: Final = Load(0.0, (0.0, 0.0, 0.0))


def known_load(arm: Arm) -> Load:
    """P: the known load of ``rfms identify``: a steel disc on a bracket at the flange.

    2.5 kg on the PUMA 560, its rated payload; scaled like the other parameters of the 260
    (``puma.py``). It is 0.10 m off the axis of joint 6 and 0.15 m beyond the wrist centre, so that
    its weight loads joints 2 to 6 by a tenth or more of their drives' torque.
    """
    scale = arm.d4 / 0.4318
    mass = 2.5 * scale**2
    radius, height = 0.05 * scale, 0.04 * scale
    across = mass * (3.0 * radius**2 + height**2) / 12.0
    along = mass * radius**2 / 2.0
    return Load(mass, (0.10 * scale, 0.0, 0.15 * scale), (across, across, along))


def load_alone(arm: Arm, load: Load) -> Arm:
    """The arm with massless links and drives and a load: the dynamics of the load alone."""
    nothing = Link(0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    drives = tuple(replace(drive, rotor_inertia=0.0) for drive in arm.drives)
    last = Link(load.mass, load.com, load.inertia)
    return replace(arm, links=(*(nothing,) * (JOINT_COUNT - 1), last), drives=drives)

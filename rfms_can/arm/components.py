"""Components of an arm: links, drives and their friction.

SI units and radians; everything is joint-side unless it says *motor*.
"""

from dataclasses import dataclass
from math import pi

Vector3 = tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Correction:
    """Correction of published link parameters that are not those of a rigid body."""

    mass: float  # kg
    inertia: Vector3  # kg m2, xx yy zz about the centre of mass
    reason: str


@dataclass(frozen=True, slots=True, eq=False)
class Link:
    """A link's inertial parameters as published, with the correction a physics engine needs.

    Attributes:
        mass: kg.
        com: centre of mass in the link's own Denavit-Hartenberg frame, m.
        inertia: xx, yy, zz about the centre of mass, axes of the link frame, kg m2.
        correction: None where the published values are those of a possible rigid body.
    """

    mass: float
    com: Vector3
    inertia: Vector3
    correction: Correction | None = None

    @property
    def physical_mass(self) -> float:
        """Mass of the corrected link, kg."""
        return self.mass if self.correction is None else self.correction.mass

    @property
    def physical_inertia(self) -> Vector3:
        """Inertia of the corrected link, kg m2: satisfies the triangle inequality."""
        return self.inertia if self.correction is None else self.correction.inertia


@dataclass(frozen=True, slots=True, eq=False)
class Drive:
    """A joint's motor, gear and encoder.

    Attributes:
        gear_ratio: motor angle per joint angle; negative where the motor turns against the joint.
        rotor_inertia: motor-side, kg m2.
        torque_limit: joint-side, Nm.
        torque_constant: motor-side Kt, Nm/A.
        counts_per_revolution: encoder counts per motor revolution; one index pulse each.
    """

    gear_ratio: float
    rotor_inertia: float
    torque_limit: float
    torque_constant: float
    counts_per_revolution: int

    @property
    def armature(self) -> float:
        """Rotor inertia seen by the joint, Jm G^2, kg m2."""
        return self.rotor_inertia * self.gear_ratio**2

    @property
    def torque_per_ampere(self) -> float:
        """Joint torque per motor current, G Kt, Nm/A; signed like the gear."""
        return self.gear_ratio * self.torque_constant

    @property
    def current_limit(self) -> float:
        """Motor current at the torque limit, A: the amplifier saturates here."""
        return self.torque_limit / abs(self.torque_per_ampere)

    @property
    def counts_per_radian(self) -> float:
        """Encoder counts per joint radian; signed like the gear."""
        return self.gear_ratio * self.counts_per_revolution / (2.0 * pi)

    @property
    def index_interval(self) -> float:
        """Joint angle between two index pulses, rad, positive."""
        return 2.0 * pi / abs(self.gear_ratio)


@dataclass(frozen=True, slots=True, eq=False)
class JointFriction:
    """Joint-side friction that depends on the direction of motion.

    The friction torque of a moving joint is ``-(coulomb_positive + viscous qd)`` for qd > 0 and
    ``+coulomb_negative - viscous qd`` for qd < 0; a resting joint stays at rest while the load is
    between ``-coulomb_negative`` and ``coulomb_positive``. Coulomb in Nm, viscous in Nms/rad; all
    are magnitudes, never negative. Both Coulomb torques grow by ``load`` times the motor's torque.
    """

    coulomb_positive: float
    coulomb_negative: float
    viscous: float
    load: float = 0.0

    def scaled(self, factor: float) -> "JointFriction":
        """The same friction, all torques times ``factor``."""
        positive, negative = self.coulomb_positive * factor, self.coulomb_negative * factor
        return JointFriction(positive, negative, self.viscous * factor, self.load)

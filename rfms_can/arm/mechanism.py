"""What an arm is made of: links, drives, friction, board scales, gripper. The numbers: ``puma.py``.

SI units and radians; everything is joint-side unless it says *motor*. Joint i has index i - 1.
Denavit-Hartenberg convention B (Paul, Appendix A), alpha = (+90, 0, -90, +90, -90, 0) degrees;
the base frame sits on the joint-2 axis, z up.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import copysign, pi
from typing import Final

from rfms_can.errors import ArmError

JOINTS: Final = 6
CONVERTER_CODES: Final = 2048
"""Codes on either side of zero of the board's 12-bit converters: -2048 to 2047."""

FORCE_DAC_FINENESS: Final = 4
"""P: full scale of the motor-current DAC over that of the force-set-point DAC, in joint torque.

The thesis says of the board's second DAC only that it "allows one to specify a force set point to
the joint" (section VI.4.4). Here the amplifier adds what the two ask for. A torque for contact is
small beside what moves the arm, so the second has the same 12 bits over a quarter of it: codes of
0.003 to 0.023 Nm on the joints of the PUMA 560, where those of the first are 0.010 to 0.091 Nm.
"""

COARSE_CODES: Final = 4096
"""Codes of the 12-bit coarse position (potentiometer): 0 to 4095."""

Vector3 = tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Correction:
    """Why and how a published link differs from one a rigid-body engine accepts."""

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

    A turning joint feels ``-(coulomb_positive + viscous qd)`` for qd > 0 and
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


@dataclass(frozen=True, slots=True, eq=False)
class BoardScale:
    """What one code of a joint's iSBX board means: shared by the board and whoever talks to it.

    Attributes:
        ampere_per_dac_code: motor current per code of the motor-current DAC.
        torque_per_dac_code: joint torque per code of the motor-current DAC, Nm; signed like the
            gear.
        torque_per_force_code: joint torque per code of the force-set-point DAC, Nm; signed like
            the gear. The amplifier adds the two, up to the drive's limit.
        speed_per_adc_code: joint speed per code of the velocity ADC, rad/s; signed like the gear.
        coarse_zero: joint angle at coarse code 0, rad.
        angle_per_coarse_code: rad.
        coarse_error: bound of |coarse position - joint angle|, rad; under a quarter of an index
            interval, so that the coarse position names the index pulse.
    """

    ampere_per_dac_code: float
    torque_per_dac_code: float
    torque_per_force_code: float
    speed_per_adc_code: float
    coarse_zero: float
    angle_per_coarse_code: float
    coarse_error: float


@dataclass(frozen=True, slots=True, eq=False)
class Gripper:
    """A gripper with one driven jaw: the opening is the only degree of freedom.

    Attributes:
        stroke: opening between closed (0) and fully open, m.
        mass: moving mass, motor included, kg.
        friction: viscous, Ns/m.
        force_limit: closing or opening force at the DAC's full scale, N.
        counts_per_metre: encoder counts per metre of opening.
    """

    stroke: float
    mass: float
    friction: float
    force_limit: float
    counts_per_metre: float

    @property
    def force_per_dac_code(self) -> float:
        """N per code of the gripper's DAC; positive opens."""
        return self.force_limit / CONVERTER_CODES


TACHOMETER_MARGIN: Final = 1.5  # full scale of the velocity ADC over the joint's speed limit
COARSE_MARGIN: Final = 0.05  # coarse range beyond each joint limit, as a part of the joint's range
COARSE_LINEARITY: Final = 0.1  # amplitude of the potentiometer's error, in index intervals


@dataclass(frozen=True, slots=True, eq=False)
class Arm:
    """A six-joint arm with a spherical wrist.

    Attributes:
        name: e.g. ``"puma260"``.
        arm_id: what travels on the wire: 260 or 560.
        a2, a3, d2, d3, d4, flange: Denavit-Hartenberg lengths, m; ``flange`` is d6, beyond T6.
        joint_limits: (lower, upper) per joint, rad: the plant's hard stops.
        speed_limits, acceleration_limits: rad/s and rad/s2, for trajectories.
        links, drives: one per joint.
        friction_sets: by name, one :class:`JointFriction` per joint.
        park: a pose inside the limits and away from every singularity, rad.
        gripper: what is bolted to the flange.
    """

    name: str
    arm_id: int
    a2: float
    a3: float
    d2: float
    d3: float
    d4: float
    flange: float
    joint_limits: tuple[tuple[float, float], ...]
    speed_limits: tuple[float, ...]
    acceleration_limits: tuple[float, ...]
    links: tuple[Link, ...]
    drives: tuple[Drive, ...]
    friction_sets: Mapping[str, tuple[JointFriction, ...]]
    park: tuple[float, ...]
    gripper: Gripper

    def __post_init__(self) -> None:
        for field in ("joint_limits", "speed_limits", "acceleration_limits", "links", "drives"):
            if len(getattr(self, field)) != JOINTS:
                raise ArmError(f"{self.name}: {field} needs {JOINTS} entries, one per joint")

    @property
    def shoulder_offset(self) -> float:
        """d2 + d3, m: all that the kinematics see of the two."""
        return self.d2 + self.d3

    @property
    def dh(self) -> tuple[tuple[float, float, float], ...]:
        """(alpha, a, d) per link, convention B: A_i = Rz(q_i) Tz(d_i) Tx(a_i) Rx(alpha_i)."""
        quarter = pi / 2.0
        return (
            (quarter, 0.0, 0.0),
            (0.0, self.a2, self.d2),
            (-quarter, self.a3, self.d3),
            (quarter, 0.0, self.d4),
            (-quarter, 0.0, 0.0),
            (0.0, 0.0, 0.0),
        )

    def board_scale(self, joint: int) -> BoardScale:
        """Scales of the board of joint index ``joint`` (0 to 5)."""
        drive = self.drives[joint]
        lower, upper = self.joint_limits[joint]
        margin = COARSE_MARGIN * (upper - lower)
        angle_per_code = (upper - lower + 2.0 * margin) / COARSE_CODES
        ampere_per_code = drive.current_limit / CONVERTER_CODES
        torque_per_code = ampere_per_code * drive.torque_per_ampere
        full_speed = copysign(TACHOMETER_MARGIN * self.speed_limits[joint], drive.gear_ratio)
        return BoardScale(
            ampere_per_dac_code=ampere_per_code,
            torque_per_dac_code=torque_per_code,
            torque_per_force_code=torque_per_code / FORCE_DAC_FINENESS,
            speed_per_adc_code=full_speed / CONVERTER_CODES,
            coarse_zero=lower - margin,
            angle_per_coarse_code=angle_per_code,
            coarse_error=COARSE_LINEARITY * drive.index_interval + angle_per_code,
        )

"""An arm: its lengths, limits, parts and gripper. The numbers: ``puma.py``.

SI units and radians. Joint i has index i - 1. Denavit-Hartenberg convention B (Paul, Appendix A),
alpha = (+90, 0, -90, +90, -90, 0) degrees; the base frame sits on the joint-2 axis, z up.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from typing import Final

from rfms_can.arm.board_scale import CONVERTER_CODES, BoardScale
from rfms_can.arm.components import Drive, JointFriction, Link
from rfms_can.errors import ArmError

JOINT_COUNT: Final = 6


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


STOP_ROOM: Final = 0.1
"""Way from the end of a joint's range to its hard stop, rad: nodes switch off halfway."""


@dataclass(frozen=True, slots=True, eq=False)
class Arm:
    """A six-joint arm with a spherical wrist.

    Attributes:
        name: e.g. ``"puma260"``.
        arm_id: its number on the wire: 260 or 560.
        a2, a3, d2, d3, d4, flange: Denavit-Hartenberg lengths, m; ``flange`` is d6, beyond T6.
        joint_limits: (lower, upper) per joint, rad: the range it is used in; see ``hard_stops``.
        speed_limits, acceleration_limits: rad/s and rad/s2, for trajectories.
        links, drives: one per joint.
        friction_sets: by name, one :class:`JointFriction` per joint.
        park: a pose inside the limits and away from every singularity, rad.
        gripper: at the flange.
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
            if len(getattr(self, field)) != JOINT_COUNT:
                raise ArmError(f"{self.name}: {field} needs {JOINT_COUNT} entries, one per joint")

    @property
    def hard_stops(self) -> tuple[tuple[float, float], ...]:
        """(lower, upper) per joint, rad: where it runs against metal, behind its limits."""
        return tuple((lower - STOP_ROOM, upper + STOP_ROOM) for lower, upper in self.joint_limits)

    @property
    def shoulder_offset(self) -> float:
        """d2 + d3, m: the kinematics depend only on the sum."""
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
        return BoardScale.of(self.drives[joint], self.joint_limits[joint], self.speed_limits[joint])

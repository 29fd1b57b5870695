"""Torque against motor current, per direction of motion (Eq. 4.13), and Table 4.1.

A moving joint gives ``tau = A_p I + B_p`` when it turns to positive angles and ``A_n I + B_n`` when
it turns to negative ones; I in DAC codes, counted positive where it drives to positive angles. The
offsets are Coulomb friction and the amplifier's current offset; where the slopes differ, friction
grows with the motor's torque.
"""

from dataclasses import dataclass, replace
from math import copysign
from typing import Final

from rfms_can.arm.board_scale import CONVERTER_CODES
from rfms_can.arm.components import JointFriction
from rfms_can.arm.mechanism import Arm
from rfms_can.arm.puma import OUNCE_INCH, PUMA_560


@dataclass(frozen=True, slots=True)
class TorqueLaw:
    """Eq. 4.13 of one joint, and its viscous friction.

    Attributes:
        slope_positive, slope_negative: A_p, A_n: joint torque per DAC code, Nm, positive.
        offset_positive, offset_negative: B_p, B_n: Nm.
        viscous: Nms/rad; the thesis gives none.
    """

    slope_positive: float
    offset_positive: float
    slope_negative: float
    offset_negative: float
    viscous: float

    def torque(self, current: float, speed: float) -> float:
        """Torque of a joint moving at ``speed`` (rad/s) at ``current`` (codes), Nm."""
        if speed > 0.0:
            dry = self.slope_positive * current + self.offset_positive
        else:
            dry = self.slope_negative * current + self.offset_negative
        return dry - self.viscous * speed

    @property
    def slope(self) -> float:
        """Motor torque per code without friction: the mean of the two directions, Nm."""
        return 0.5 * (self.slope_positive + self.slope_negative)

    @property
    def friction(self) -> JointFriction:
        """The friction of this law, for a motor with :attr:`slope`."""
        load = (self.slope_negative - self.slope_positive) / (2.0 * self.slope)
        return JointFriction(-self.offset_positive, self.offset_negative, self.viscous, load)

    @classmethod
    def of(cls, slope: float, friction: JointFriction, current_offset: float = 0.0) -> "TorqueLaw":
        """The law of a motor of ``slope`` (Nm per code) against a friction.

        ``current_offset`` is added by the amplifier to the DAC's code, in codes.
        """
        positive, negative = slope * (1.0 - friction.load), slope * (1.0 + friction.load)
        return cls(
            positive,
            positive * current_offset - friction.coulomb_positive,
            negative,
            negative * current_offset + friction.coulomb_negative,
            friction.viscous,
        )


TABLE_4_1: Final = (
    (9.06, -2017.0, 8.64, 1800.0),
    (13.44, -1088.0, 14.11, 1280.0),
    (7.28, -642.0, 7.02, 671.0),
    (1.72, -116.0, 1.77, 111.0),
    (1.46, -101.0, 1.45, 146.0),
    (1.76, -96.0, 1.76, 88.0),
)
"""S thesis: A_p, B_p, A_n, B_n of joints 1 to 6 of a PUMA 560, oz-in per DAC code and oz-in."""


def table_4_1(arm: Arm) -> tuple[TorqueLaw, ...]:
    """The laws of Table 4.1 in SI; for other arms than the 560 scaled by the torque limits.

    Viscous friction is that of the friction set ``thesis``.
    """
    laws = []
    for index, row in enumerate(TABLE_4_1):
        scale = arm.drives[index].torque_limit / PUMA_560.drives[index].torque_limit
        a_p, b_p, a_n, b_n = (OUNCE_INCH * scale * number for number in row)
        viscous = arm.friction_sets["thesis"][index].viscous
        laws.append(TorqueLaw(a_p, b_p, a_n, b_n, viscous))
    return tuple(laws)


def driven_by(arm: Arm, laws: tuple[TorqueLaw, ...]) -> Arm:
    """The arm with drives whose full current gives the torque of the laws' slopes."""
    drives = tuple(
        replace(drive, torque_limit=law.slope * CONVERTER_CODES)
        for drive, law in zip(arm.drives, laws, strict=True)
    )
    return replace(arm, drives=drives)


def joint_current(gear_ratio: float, code: float) -> float:
    """A DAC code counted positive where it drives the joint to positive angles."""
    return copysign(1.0, gear_ratio) * code

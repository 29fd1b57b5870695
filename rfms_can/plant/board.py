"""The iSBX board of one joint: two DACs, two ADCs and an incremental encoder (thesis VI.4.4).

The amplifier drives the sum of the two DACs, motor current and force set-point, within the drive's
current limit. Plain state without I/O; :class:`~rfms_can.arm.board_scale.BoardScale` has the scale
of the codes. Codes saturate at the rails -2048 and 2047 and round half up, so a run repeats bit by
bit.
"""

from math import floor, pi, sin
from typing import Final, Protocol

from rfms_can.arm import Arm
from rfms_can.arm.board_scale import (
    COARSE_CODES,
    COARSE_LINEARITY,
    CONVERTER_CODES,
    FORCE_DAC_FINENESS,
)

LOWEST_CODE: Final = -CONVERTER_CODES
HIGHEST_CODE: Final = CONVERTER_CODES - 1
COARSE_WAVES: Final = 3.0
"""Waves of the potentiometer's linearity error over its range."""

Sample = tuple[int, int, int, bool]
"""Counts since power-up, current ADC, velocity ADC, index seen since the last sample."""


class JointBoard(Protocol):
    """What the plant asks of the board of a joint; see :class:`Board`."""

    latched_index_counts: int | None

    def set_dacs(self, current_code: int, force_code: int = 0, /) -> float:
        """Write both DACs; return the joint torque that the motor's current makes, Nm."""

    def observe(self, q: float, qd: float) -> None:
        """Follow the joint to an angle (rad) and a speed (rad/s)."""

    def sample(self) -> Sample:
        """The values of MEASURE."""

    def coarse(self, q: float) -> int:
        """Code of the potentiometer at an angle (rad)."""


class Board:
    """The board of one joint, between the bus' codes and the joint's angle, speed and torque.

    The encoder counts from power-up, at an unknown angle: counts become an angle when an index
    pulse (one per motor revolution, at whole revolutions of the motor) is latched and the coarse
    position identifies that pulse.

    Attributes:
        latched_index_counts: counts at the last index pulse; None before the first.
    """

    def __init__(
        self, arm: Arm, joint: int, q: float, adc_slope: float = 1.0, adc_offset: float = 0.0
    ) -> None:
        """Power up the board of joint index ``joint`` (0 to 5) at angle ``q`` (rad).

        ``adc_slope`` and ``adc_offset`` are A_c and B_c of Eq. 4.14, I_adc = A_c I_dac + B_c, in
        codes. The printed 5.74 and -61.30 cannot be right (full current would read 11694, beyond
        any 12-bit converter), so the current reads back as it was set.
        """
        drive = arm.drives[joint]
        self._scale = arm.board_scale(joint)
        self._drive = drive
        self._adc_slope, self._adc_offset = adc_slope, adc_offset
        self._revolutions_per_radian = drive.gear_ratio / (2.0 * pi)
        self._counts_per_revolution = drive.counts_per_revolution
        self._linearity = COARSE_LINEARITY * drive.index_interval
        revolutions = q * self._revolutions_per_radian
        self._power_up_counts = floor(revolutions * drive.counts_per_revolution + 0.5)
        self._whole_revolutions = floor(revolutions)
        self._counts = 0
        self._speed_code = 0
        self._fine_code = 0
        self._index_seen = False
        self.latched_index_counts: int | None = None

    def set_dacs(self, current_code: int, force_code: int = 0) -> float:
        """Write both DACs; return the joint torque that the motor's current makes, Nm.

        Each converter saturates at its rails, the amplifier at those of the motor-current channel:
        the drive's current limit.
        """
        current = min(max(current_code, LOWEST_CODE), HIGHEST_CODE)
        force = min(max(force_code, LOWEST_CODE), HIGHEST_CODE)
        fine = FORCE_DAC_FINENESS * current + force
        self._fine_code = min(
            max(fine, FORCE_DAC_FINENESS * LOWEST_CODE), FORCE_DAC_FINENESS * HIGHEST_CODE
        )
        return self._fine_code * self._scale.torque_per_force_code

    @property
    def current(self) -> float:
        """Motor current the amplifier drives, A."""
        return self._fine_code * self._scale.ampere_per_dac_code / FORCE_DAC_FINENESS

    def observe(self, q: float, qd: float) -> None:
        """Follow the joint to angle ``q`` (rad) and speed ``qd`` (rad/s): once a control period.

        Every index pulse between the two angles is seen, and the last one crossed stays latched;
        a joint that crosses a pulse and returns within the period is seen as a joint at rest.
        """
        revolutions = q * self._revolutions_per_radian
        self._counts = (
            floor(revolutions * self._counts_per_revolution + 0.5) - self._power_up_counts
        )
        whole = floor(revolutions)
        if whole != self._whole_revolutions:
            # Pulse n lies at revolution n exactly: the last one crossed is below us when going up.
            pulse = whole if whole > self._whole_revolutions else whole + 1
            self._whole_revolutions = whole
            self._index_seen = True
            self.latched_index_counts = pulse * self._counts_per_revolution - self._power_up_counts
        self._speed_code = _code(qd / self._scale.speed_per_adc_code)

    def sample(self) -> Sample:
        """The values of MEASURE; clears the index flag.

        The current ADC has the scale of the motor-current DAC and reads the amplifier's current,
        the sum of both DACs.
        """
        index_seen, self._index_seen = self._index_seen, False
        driven = self._fine_code / FORCE_DAC_FINENESS
        current = _code(self._adc_slope * driven + self._adc_offset)
        return self._counts, current, self._speed_code, index_seen

    def coarse(self, q: float) -> int:
        """Code (0 to 4095) of the potentiometer at angle ``q`` (rad), linearity error included."""
        scale = self._scale
        fraction = (q - scale.coarse_zero) / scale.angle_per_coarse_code / COARSE_CODES
        error = self._linearity * sin(2.0 * pi * COARSE_WAVES * fraction)
        code = floor((q + error - scale.coarse_zero) / scale.angle_per_coarse_code + 0.5)
        return min(max(code, 0), COARSE_CODES - 1)


def _code(value: float) -> int:
    """The converter's code for ``value`` (in codes): rounded half up, saturated at the rails."""
    if value >= HIGHEST_CODE:
        return HIGHEST_CODE
    if value <= LOWEST_CODE:
        return LOWEST_CODE
    return floor(value + 0.5)

"""Scales of the converters of a joint's iSBX board."""

from dataclasses import dataclass
from math import copysign
from typing import Final

from rfms_can.arm.components import Drive

CONVERTER_CODES: Final = 2048
"""Codes on either side of zero of the board's 12-bit converters: -2048 to 2047."""

FORCE_DAC_FINENESS: Final = 4
"""P: full scale of the motor-current DAC over that of the force-set-point DAC, in joint torque.

The thesis says of the board's second DAC only that it "allows one to specify a force set point to
the joint" (section VI.4.4). Here the amplifier adds the two. A contact torque is small compared
with the torque that moves the arm, so the second has the same 12 bits over a quarter of it: its
codes are 0.003 to 0.023 Nm on the joints of the PUMA 560, those of the first 0.010 to 0.091 Nm.
"""

COARSE_CODES: Final = 4096
"""Codes of the 12-bit coarse position (potentiometer): 0 to 4095."""

TACHOMETER_MARGIN: Final = 1.5  # full scale of the velocity ADC over the joint's speed limit
COARSE_MARGIN: Final = 0.05  # coarse range beyond each joint limit over the joint's range
COARSE_LINEARITY: Final = 0.1  # amplitude of the potentiometer's error, in index intervals


@dataclass(frozen=True, slots=True, eq=False)
class BoardScale:
    """Scale of one code of a joint's iSBX board, shared by the board and its users.

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

    @classmethod
    def of(cls, drive: Drive, limits: tuple[float, float], speed_limit: float) -> "BoardScale":
        """The scales of the board at a drive.

        Args:
            drive: the joint's.
            limits: of the joint's angle, rad.
            speed_limit: of the joint, rad/s.
        """
        lower, upper = limits
        margin = COARSE_MARGIN * (upper - lower)
        angle_per_code = (upper - lower + 2.0 * margin) / COARSE_CODES
        ampere_per_code = drive.current_limit / CONVERTER_CODES
        torque_per_code = ampere_per_code * drive.torque_per_ampere
        full_speed = copysign(TACHOMETER_MARGIN * speed_limit, drive.gear_ratio)
        return cls(
            ampere_per_dac_code=ampere_per_code,
            torque_per_dac_code=torque_per_code,
            torque_per_force_code=torque_per_code / FORCE_DAC_FINENESS,
            speed_per_adc_code=full_speed / CONVERTER_CODES,
            coarse_zero=lower - margin,
            angle_per_coarse_code=angle_per_code,
            coarse_error=COARSE_LINEARITY * drive.index_interval + angle_per_code,
        )

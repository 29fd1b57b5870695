"""A board with errors: converter noise, gain and offset errors, exchanged encoder channels.

:class:`~rfms_can.plant.board.Board` is free of them. A run still repeats bit by bit: noise comes
from a seeded generator that the caller passes.
"""

import random
from dataclasses import dataclass

from rfms_can.arm import Arm
from rfms_can.plant.board import HIGHEST_CODE, LOWEST_CODE, Board, Sample


@dataclass(frozen=True, slots=True)
class BoardErrors:
    """Deviations of one board from an ideal one.

    Attributes:
        encoder_sign: -1 where the encoder's two channels are exchanged.
        current_offset: current offset of the amplifier, DAC codes.
        adc_slope, adc_offset: A_c and B_c of Eq. 4.14, codes.
        current_noise, velocity_noise: of the ADCs, standard deviation in codes.
        tachometer_gain: velocity told over the true one.
    """

    encoder_sign: int = 1
    current_offset: int = 0
    adc_slope: float = 1.0
    adc_offset: float = 0.0
    current_noise: float = 0.0
    velocity_noise: float = 0.0
    tachometer_gain: float = 1.0


IDEAL = BoardErrors()


class ImperfectBoard(Board):
    """A board with errors."""

    def __init__(
        self, arm: Arm, joint: int, q: float, errors: BoardErrors, noise: random.Random
    ) -> None:
        """Power up the board of joint index ``joint`` (0 to 5) at angle ``q`` (rad)."""
        super().__init__(arm, joint, q, errors.adc_slope, errors.adc_offset)
        self._errors = errors
        self._noise = noise

    def set_dacs(self, current: int, force: int = 0) -> float:
        """Write both DACs; return the joint torque that the current makes, Nm."""
        return super().set_dacs(current + self._errors.current_offset, force)

    def observe(self, q: float, qd: float) -> None:
        """Follow the joint; see ``Board``. A latched index counts as the encoder does."""
        before = self.latched_index_counts
        self.latched_index_counts = None
        super().observe(q, self._errors.tachometer_gain * qd)
        if self.latched_index_counts is None:
            self.latched_index_counts = before
        else:
            self.latched_index_counts *= self._errors.encoder_sign

    def sample(self) -> Sample:
        """The values of MEASURE."""
        counts, current, speed, index_seen = super().sample()
        errors, noise = self._errors, self._noise
        return (
            errors.encoder_sign * counts,
            _clamped(current + round(noise.gauss(0.0, errors.current_noise))),
            _clamped(speed + round(noise.gauss(0.0, errors.velocity_noise))),
            index_seen,
        )


def _clamped(code: int) -> int:
    return min(max(code, LOWEST_CODE), HIGHEST_CODE)

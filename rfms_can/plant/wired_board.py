"""A board as it comes out of the box: converters with noise and offsets, wires the wrong way round.

What :class:`~rfms_can.plant.board.Board` leaves out. A run still repeats bit by bit: noise is drawn
from a generator that is handed in.
"""

import random
from dataclasses import dataclass

from rfms_can.arm import Arm
from rfms_can.plant.board import HIGHEST_CODE, LOWEST_CODE, Board, Sample


@dataclass(frozen=True, slots=True)
class Wiring:
    """How one board differs from an ideal one.

    Attributes:
        encoder_sign: -1 where its two channels are exchanged.
        current_offset: current the amplifier adds by itself, DAC codes.
        adc_slope, adc_offset: A_c and B_c of Eq. 4.14, codes.
        current_noise, velocity_noise: of the ADCs, standard deviation in codes.
    """

    encoder_sign: int = 1
    current_offset: int = 0
    adc_slope: float = 1.0
    adc_offset: float = 0.0
    current_noise: float = 0.0
    velocity_noise: float = 0.0


IDEAL = Wiring()


class WiredBoard(Board):
    """A board with its wiring."""

    def __init__(
        self, arm: Arm, joint: int, q: float, wiring: Wiring, noise: random.Random
    ) -> None:
        """Power up the board of joint index ``joint`` (0 to 5) at angle ``q`` (rad)."""
        super().__init__(arm, joint, q, wiring.adc_slope, wiring.adc_offset)
        self._wiring = wiring
        self._noise = noise

    def set_dacs(self, current: int, force: int = 0) -> float:
        """Write both DACs; return the joint torque that the current makes, Nm."""
        return super().set_dacs(current + self._wiring.current_offset, force)

    def observe(self, q: float, qd: float) -> None:
        """Follow the joint; see ``Board``. A latched index counts as the encoder does."""
        before = self.latched_index_counts
        self.latched_index_counts = None
        super().observe(q, qd)
        if self.latched_index_counts is None:
            self.latched_index_counts = before
        else:
            self.latched_index_counts *= self._wiring.encoder_sign

    def sample(self) -> Sample:
        """What MEASURE carries."""
        counts, current, speed, index_seen = super().sample()
        wiring, noise = self._wiring, self._noise
        return (
            wiring.encoder_sign * counts,
            _clamped(current + round(noise.gauss(0.0, wiring.current_noise))),
            _clamped(speed + round(noise.gauss(0.0, wiring.velocity_noise))),
            index_seen,
        )


def _clamped(code: int) -> int:
    return min(max(code, LOWEST_CODE), HIGHEST_CODE)

"""A board of which something breaks in motion, beside ``Board`` and ``ImperfectBoard``.

It stands in front of a sound board, so it knows what that one would have said: the instant from
which a difference matters is told.
"""

from collections.abc import Callable
from math import ceil
from typing import Final, NamedTuple

from rfms_can.plant.board import HIGHEST_CODE, LOWEST_CODE, JointBoard, Sample

Codes = tuple[int, int]
"""Codes of the motor-current DAC and of the force-set-point DAC."""

ENCODER_FLOOR: Final = 2
"""Counts by which an encoder may be off before a fault has an effect: a servo at rest hunts by one
count either way."""
ADC_FLOOR: Final = 8
"""The same of an ADC, codes: over four standard deviations of the noisiest board we model."""
TACHOMETER_FLOOR: Final = (0.02 * 2048 / 1.5, 0.05)
"""The same of a tachometer: codes, a fiftieth of the joint's speed limit, and part of the speed. A
twentieth of the speed and a hundredth of the limit is what a sound one may be off."""
TORQUE_FLOOR_CODES: Final = 92
"""The least floor of an amplifier, codes of the motor-current DAC: its offset before it has been
identified (60), and what its sensor is off by."""
FRICTION_FLOOR: Final = 0.5
"""The floor of an amplifier over the joint's Coulomb friction, if that is more: friction is half as
much again on a cold morning, and no fault then."""


def _sound_value(_age: int, value: int) -> int:
    return value


def _sound_codes(_age: int, codes: Codes) -> Codes:
    return codes


class Damage(NamedTuple):
    """What is broken: each function makes of the age of the damage, in samples, and of what a sound
    board says what this one says.

    Attributes:
        counts: of the encoder.
        current: code of the current ADC.
        velocity: code of the velocity ADC.
        codes: what the amplifier drives instead of the codes of both DACs.
        polarity: -1 where the motor's two leads are exchanged.
        coarse: code of the potentiometer.
    """

    counts: Callable[[int, int], int] = _sound_value
    current: Callable[[int, int], int] = _sound_value
    velocity: Callable[[int, int], int] = _sound_value
    codes: Callable[[int, Codes], Codes] = _sound_codes
    polarity: int = 1
    coarse: Callable[[int, int], int] = _sound_value


def torque_floor(coulomb: float, torque_per_code: float) -> int:
    """Codes by which a joint's torque may differ before that is a fault.

    Args:
        coulomb: friction of the joint, Nm, the larger of both directions.
        torque_per_code: of its motor-current DAC, Nm.
    """
    return max(TORQUE_FLOOR_CODES, ceil(FRICTION_FLOOR * coulomb / abs(torque_per_code)))


class FaultyBoard:
    """A board with damage.

    Args:
        board: the sound one.
        damage: from now on.
        on_effect: called when a difference first exceeds the floors above.
        torque_floor: of the amplifier, codes; see ``torque_floor``.
    """

    def __init__(
        self,
        board: JointBoard,
        damage: Damage,
        on_effect: Callable[[], None],
        torque_floor: int = TORQUE_FLOOR_CODES,
    ) -> None:
        self._torque_floor = torque_floor
        self._board = board
        self._damage = damage
        self._on_effect = on_effect
        self._age = 0

    @property
    def latched_index_counts(self) -> int | None:
        """Counts at the last index pulse."""
        return self._board.latched_index_counts

    @latched_index_counts.setter
    def latched_index_counts(self, counts: int | None) -> None:
        self._board.latched_index_counts = counts

    def set_dacs(self, current_code: int, force_code: int = 0, /) -> float:
        """Write both DACs; return the joint torque that the motor's current makes, Nm."""
        codes = self._damage.codes(self._age, (current_code, force_code))
        driven = self._damage.polarity * codes[0]
        self._compare(driven - current_code, self._torque_floor)
        return self._damage.polarity * self._board.set_dacs(*codes)

    def observe(self, q: float, qd: float) -> None:
        """Follow the joint."""
        self._board.observe(q, qd)

    def sample(self) -> Sample:
        """The values of MEASURE."""
        sound = self._board.sample()
        damage, age = self._damage, self._age
        counts = damage.counts(age, sound[0])
        current = _code(damage.current(age, sound[1]))
        velocity = _code(damage.velocity(age, sound[2]))
        self._age += 1
        self._compare(counts - sound[0], ENCODER_FLOOR)
        self._compare(current - sound[1], ADC_FLOOR)
        offset, gain = TACHOMETER_FLOOR
        self._compare(velocity - sound[2], offset + gain * abs(sound[2]))
        return counts, current, velocity, sound[3]

    def coarse(self, q: float) -> int:
        """Code of the potentiometer at angle ``q`` (rad)."""
        sound = self._board.coarse(q)
        code = self._damage.coarse(self._age, sound)
        self._compare(code - sound, ADC_FLOOR)
        return code

    def _compare(self, difference: float, floor: float) -> None:
        if abs(difference) > floor:
            self._on_effect()


def _code(code: int) -> int:
    return min(max(code, LOWEST_CODE), HIGHEST_CODE)

"""The drive of a joint: does the amplifier do as it is told, the motor bear it, the joint turn?"""

from collections.abc import Mapping
from math import ceil
from typing import Final

from rfms_can.joint_nodes.servo import DAC_MAX, DAC_MIN
from rfms_can.wire.vocabulary import Parameter

FULL_SCALE: Final = 2048.0
"""Codes of the motor-current DAC and of the current ADC."""
REMEMBERED: Final = 5
"""DACs that a sample may show: that of two cycles before, and older ones where some were lost."""
GAIN_FRACTION: Final = 0.1
"""Part of the current by which its sensor may be off: the slope A_c of Eq. 4.14 is 0.92 on a board
that has not been identified."""
STALL_FRACTION: Final = 0.02
"""Speed over the limit below which a joint at its torque limit does not turn."""


class AmplifierWatch:
    """Compares the current that flows with the DACs that asked for it.

    Args:
        parameters: the node's configuration.
    """

    __slots__ = ("_at", "_driven", "_force_per_current", "_heard", "_tolerance")

    def __init__(self, parameters: Mapping[Parameter, float]) -> None:
        p = parameters
        self._tolerance: Final = FULL_SCALE * p[Parameter.CURRENT_TOLERANCE]
        self._force_per_current: Final = (
            p[Parameter.TORQUE_PER_FORCE_CODE] / p[Parameter.TORQUE_PER_CODE]
        )
        self._driven = [0.0] * REMEMBERED
        self.reset()

    def reset(self) -> None:
        """Forget what was asked for: another current flows, as where the brake holds."""
        self._heard = self._at = 0

    def drive(self, current_code: int, force_code: int) -> None:
        """Remember one DAC frame: the amplifier adds the two, up to its limit."""
        driven = current_code + self._force_per_current * force_code
        if driven > DAC_MAX:
            driven = DAC_MAX
        elif driven < DAC_MIN:
            driven = DAC_MIN
        self._driven[self._at] = driven
        self._at = (self._at + 1) % REMEMBERED
        if self._heard < REMEMBERED:
            self._heard += 1

    def border(self, current_adc: int) -> float | None:
        """What a current code is beyond, in codes; None if one of the DACs explains it."""
        if self._heard < REMEMBERED:
            return None
        driven = self._driven
        high = max(driven)
        high += self._tolerance + GAIN_FRACTION * abs(high)
        if current_adc > high:
            return high
        low = min(driven)
        low -= self._tolerance + GAIN_FRACTION * abs(low)
        return low if current_adc < low else None


class OverloadWatch:
    """Heat of a motor's winding, I squared t: its torque's square beyond what it bears for ever.

    Args:
        parameters: the node's configuration.

    Attributes:
        heat: N2 m2 s.
        bound: of it.
    """

    __slots__ = ("_borne", "_continuous", "_period", "bound", "heat")

    def __init__(self, parameters: Mapping[Parameter, float]) -> None:
        p = parameters
        self._continuous: Final = p[Parameter.CONTINUOUS_TORQUE]
        self._borne: Final = self._continuous**2
        self._period: Final = p[Parameter.PERIOD]
        self.bound: Final = p[Parameter.OVERLOAD_TIME] * (
            p[Parameter.TORQUE_LIMIT] ** 2 - self._borne
        )
        self.heat = 0.0

    def bears(self, torque: float) -> bool:
        """Take the torque of a cycle, Nm; whether the motor bears it."""
        heat = self.heat + self._period * (torque * torque - self._borne)
        self.heat = heat = heat if heat > 0.0 else 0.0
        return heat <= self.bound or abs(torque) <= self._continuous


class StallWatch:
    """A joint that pushes with all its torque and does not turn.

    Args:
        parameters: the node's configuration.

    Attributes:
        run: torques in a row that were cut to the limit while it stood.
        bound: of them.
    """

    __slots__ = ("_turns", "bound", "run")

    def __init__(self, parameters: Mapping[Parameter, float]) -> None:
        p = parameters
        self._turns: Final = STALL_FRACTION * p[Parameter.SPEED_LIMIT]
        self.bound: Final = ceil(p[Parameter.STALL_TIME] / p[Parameter.PERIOD])
        self.run = 0

    def stalls(self, cut: bool, speed: float) -> bool:
        """Take a torque: whether it was cut to the limit, and the joint's speed, rad/s."""
        self.run = self.run + 1 if cut and -self._turns < speed < self._turns else 0
        return self.run > self.bound

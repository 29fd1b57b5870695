"""The wrist force/torque sensor: six strain-gauge channels between hand and tool.

What it reads is the truth times a scale, plus a bias and noise, within its range: whoever uses it
has to take out the bias and the weight of the tool.
"""

import random
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from rfms_can.transform import Vector6

FORCE_RANGE: Final = 400.0  # N; P: size of the JR3 and Lord sensors of the time
TORQUE_RANGE: Final = 40.0  # Nm
_RANGES: Final = (FORCE_RANGE,) * 3 + (TORQUE_RANGE,) * 3


@dataclass(frozen=True, slots=True)
class SensorErrors:
    """What is wrong with a sensor.

    Attributes:
        bias: reading without load: N along x, y, z, Nm about x, y, z.
        scale: reading over truth, of each channel.
        noise: standard deviation of a sample, N and Nm.
        seed: makes the noise.
    """

    bias: Vector6 = (0.0,) * 6
    scale: Vector6 = (1.0,) * 6
    noise: Vector6 = (0.0,) * 6
    seed: int = 1


GOOD: Final = SensorErrors(
    bias=(1.5, -0.8, 2.1, 0.05, -0.03, 0.02),
    scale=(1.01, 0.99, 1.005, 1.0, 1.01, 0.995),
    noise=(0.1, 0.1, 0.1, 0.005, 0.005, 0.005),
)
"""A good one (P): 1 % of scale, noise of a tenth of a newton."""


class WristSensor:
    """Samples six channels.

    Args:
        errors: what is wrong with it.
    """

    def __init__(self, errors: SensorErrors = GOOD) -> None:
        self._errors = errors
        self._random = random.Random(errors.seed)

    def sample(self, truth: Sequence[float]) -> list[float]:
        """The reading, (6,), N and Nm, of what the hand does to the tool at T6."""
        errors, gauss = self._errors, self._random.gauss
        return [
            min(max(scale * value + bias + (gauss(0.0, noise) if noise else 0.0), -limit), limit)
            for value, scale, bias, noise, limit in zip(
                truth, errors.scale, errors.bias, errors.noise, _RANGES, strict=True
            )
        ]

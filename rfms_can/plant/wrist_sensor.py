"""The wrist force/torque sensor: six strain-gauge channels between hand and tool.

Its reading is the true wrench, averaged over a control period as by an integrating converter, times
a scale, plus a bias and noise, within its range. Bias, and the weight and inertia of the tool, are
to be compensated by its user.
"""

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

from rfms_can.arm.wrist import SENSOR_RANGE
from rfms_can.errors import PlantError
from rfms_can.transform import Vector6


@dataclass(frozen=True, slots=True)
class SensorErrors:
    """Errors of a sensor.

    Attributes:
        bias: reading without load: N along x, y, z, Nm about x, y, z.
        scale: reading over truth, of each channel.
        noise: standard deviation of a sample, N and Nm.
    """

    bias: Vector6 = (0.0,) * 6
    scale: Vector6 = (1.0,) * 6
    noise: Vector6 = (0.0,) * 6


IDEAL: Final = SensorErrors()
"""Reads the truth."""

GOOD: Final = SensorErrors(
    bias=(1.5, -0.8, 2.1, 0.05, -0.03, 0.02),
    scale=(1.01, 0.99, 1.005, 1.0, 1.01, 0.995),
    noise=(0.1, 0.1, 0.1, 0.005, 0.005, 0.005),
)
"""A good one (P): 1 % of scale, noise of a tenth of a newton."""

NO_SENSOR: Final = "none"
SENSORS: Final[Mapping[str, SensorErrors]] = MappingProxyType({"ideal": IDEAL, "good": GOOD})
"""By name."""


class WristSensor:
    """Samples six channels.

    Args:
        errors: of the sensor.
        seed: of the noise.
    """

    def __init__(self, errors: SensorErrors = GOOD, seed: int = 1) -> None:
        self._errors = errors
        self._random = random.Random(seed)

    def sample(self, truth: Sequence[float]) -> list[float]:
        """The reading, (6,), N and Nm, for the true wrench at T6, mean of a period."""
        errors, gauss = self._errors, self._random.gauss
        return [
            min(max(scale * value + bias + (gauss(0.0, noise) if noise else 0.0), -limit), limit)
            for value, scale, bias, noise, limit in zip(
                truth, errors.scale, errors.bias, errors.noise, SENSOR_RANGE, strict=True
            )
        ]


def sensor_from(name: str, seed: int) -> WristSensor | None:
    """The sensor of a name, its noise seeded by ``seed``; None for ``none``.

    Raises:
        PlantError: the name does not exist.
    """
    if name == NO_SENSOR:
        return None
    if name not in SENSORS:
        raise PlantError(
            f"sensor {name!r} does not exist; there are: {NO_SENSOR}, {', '.join(SENSORS)}"
        )
    return WristSensor(SENSORS[name], seed)

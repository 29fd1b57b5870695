"""The gripper's mechanics and board: one jaw opening, driven by a motor force.

Closing and opening move the jaw against viscous friction; end stops, and a workpiece between the
fingers, stop it. A stalled jaw keeps its force, which the current ADC shows.
"""

from math import floor

from rfms_can.arm import Gripper
from rfms_can.errors import PlantError
from rfms_can.plant.board import HIGHEST_CODE, LOWEST_CODE

JawSample = tuple[int, int]
"""Encoder counts since power-up, current ADC code."""


class Jaw:
    """The gripper's one degree of freedom, powered up at an unknown opening.

    Attributes:
        opening: distance between the fingers, m.
        speed: m/s, positive opens.
        part_width: width of the workpiece between the fingers, m; 0 for none.
    """

    def __init__(self, gripper: Gripper, opening: float, part_width: float = 0.0) -> None:
        """Start at ``opening`` (m) with a part of ``part_width`` (m) between the fingers.

        Raises:
            PlantError: the opening is outside the stroke or narrower than the part.
        """
        if not 0.0 <= part_width <= opening <= gripper.stroke:
            raise PlantError(
                f"gripper: opening {opening} m with a part of {part_width} m; "
                f"it needs 0 <= part <= opening <= stroke {gripper.stroke} m"
            )
        self._gripper = gripper
        self._power_up_counts = floor(opening * gripper.counts_per_metre + 0.5)
        self._code = 0
        self.opening = opening
        self.speed = 0.0
        self.part_width = part_width

    def set_motor_current(self, code: int) -> None:
        """Write the motor-current DAC; positive codes open."""
        self._code = min(max(code, LOWEST_CODE), HIGHEST_CODE)

    def put_part(self, width: float) -> None:
        """Put a workpiece of ``width`` (m) between the fingers, or remove it (0).

        Raises:
            PlantError: it does not fit between the fingers as they stand.
        """
        if not 0.0 <= width <= self.opening:
            raise PlantError(
                f"gripper: a part of {width} m does not fit in an opening of {self.opening:.4f} m"
            )
        self.part_width = width

    def step(self, step_s: float) -> None:
        """Advance ``step_s`` seconds: backward Euler, perfectly inelastic stops."""
        gripper = self._gripper
        force = self._code * gripper.force_per_dac_code
        self.speed = (gripper.mass * self.speed + step_s * force) / (
            gripper.mass + step_s * gripper.friction
        )
        opening = self.opening + step_s * self.speed
        stopped = min(max(opening, self.part_width), gripper.stroke)
        if stopped != opening:
            self.speed = 0.0
        self.opening = stopped

    def sample(self) -> JawSample:
        """Counts since power-up and the current ADC (which reads the DAC back)."""
        counts = floor(self.opening * self._gripper.counts_per_metre + 0.5)
        return counts - self._power_up_counts, self._code

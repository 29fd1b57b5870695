"""Whether arm and jaw stand still, by their encoders."""

from typing import Final

from rfms_can.arm import Arm
from rfms_can.master.arm_state import ArmState

STILL_CYCLES: Final = 12
"""Cycles without a count from an encoder that mean its axis stands still."""


class Stillness:
    """Counts the cycles for which arm and jaw have not moved by more than a count."""

    __slots__ = ("_arm", "_counts_per_rad", "_jaw", "_jaw_counts", "_q")

    def __init__(self, arm: Arm) -> None:
        self._counts_per_rad = [abs(drive.counts_per_radian) for drive in arm.drives]
        self._q = [0.0] * len(self._counts_per_rad)
        self._jaw_counts = 0
        self._arm = self._jaw = 0

    def watch(self, state: ArmState) -> None:
        """Look at the encoders, once a cycle."""
        still = all(
            abs(q - before) * scale < 1.5
            for q, before, scale in zip(state.q, self._q, self._counts_per_rad, strict=True)
        )
        self._arm = self._arm + 1 if still else 0
        self._q[:] = state.q
        jaw_still = abs(state.jaw_counts - self._jaw_counts) <= 1
        self._jaw = self._jaw + 1 if jaw_still else 0
        self._jaw_counts = state.jaw_counts

    def jaw_commanded(self) -> None:
        """The jaw will move: it has to come to rest again."""
        self._jaw = 0

    def arm_commanded(self) -> None:
        """The arm will move: it has to come to rest again."""
        self._arm = 0

    @property
    def arm(self) -> bool:
        """Whether all joints stand still."""
        return self._arm >= STILL_CYCLES

    @property
    def jaw(self) -> bool:
        """Whether the jaw stands still."""
        return self._jaw >= STILL_CYCLES

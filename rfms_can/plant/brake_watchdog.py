"""When a brake closes and opens: by the DAC frames of the node whose joint it holds."""

from typing import Final

SILENT_CYCLES: Final = 3
"""Cycles without a DAC frame after which a brake closes."""


class BrakeWatchdog:
    """The brakes of all boards: closed from power-up until a node sends its first DAC frame.

    Args:
        boards: how many there are.
    """

    __slots__ = ("_silent",)

    def __init__(self, boards: int) -> None:
        self._silent = [SILENT_CYCLES] * boards  # cycles without a DAC frame, by board

    def release(self, board: int) -> None:
        """A DAC frame has come: the brake opens."""
        self._silent[board] = 0

    def miss(self, board: int) -> bool:
        """One more cycle without a DAC frame; whether the brake closes now."""
        self._silent[board] += 1
        return self._silent[board] == SILENT_CYCLES

    def close_all(self) -> None:
        """Close every brake, until its node speaks again."""
        self._silent = [SILENT_CYCLES] * len(self._silent)

    def closed(self, board: int) -> bool:
        """Whether the brake holds."""
        return self._silent[board] >= SILENT_CYCLES

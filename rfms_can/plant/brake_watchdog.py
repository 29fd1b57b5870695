"""When a brake closes and opens: by the DAC frames of the node whose joint it holds.

A brake closes only on what must be held. When one node falls silent while the arm moves, the
others send no DAC either until their ladders bring them to a controlled stop, in the third cycle:
they must come to rest on their ramps. So where no joint is heard, brakes wait one cycle more.
"""

from collections.abc import Sequence
from typing import Final

SILENT_CYCLES: Final = 3
"""Cycles without a DAC frame after which a brake closes, where another joint is heard."""
SPEECHLESS_CYCLES: Final = SILENT_CYCLES + 1
"""The same where none is: joints that wait for one of them speak again in the third cycle."""


class BrakeWatchdog:
    """The brakes of all boards: closed from power-up until a node sends its first DAC frame.

    A node that falls silent while the arm is driven is lost: its brake, once closed, stays closed
    until RESET, whatever it sends then.

    Args:
        boards: how many there are.
        joints: how many of them, the first, are joints: their nodes wait for each other.
    """

    __slots__ = ("_closed", "_joints", "_lost", "_silent")

    def __init__(self, boards: int, joints: int) -> None:
        self._joints = joints
        self._silent = [0] * boards  # cycles without a DAC frame, by board
        self._closed = [True] * boards
        self._lost = [False] * boards

    def end_cycle(self, heard: Sequence[bool], *, driven: bool, together: bool = True) -> list[int]:
        """A cycle has ended: open the brakes of those that were heard, close those of the silent.

        Args:
            heard: by board, whether a DAC frame came; of one that is lost it does not count.
            driven: whether the arm was driven in this cycle, so that no node may be silent.
            together: whether each joint waits for frames of the others then: not as it homes.

        Returns:
            The boards whose brakes close now.
        """
        speechless = together and not any(heard[: self._joints])
        bound = SPEECHLESS_CYCLES if speechless else SILENT_CYCLES
        closing = []
        for board, came in enumerate(heard):
            if came:
                self._silent[board] = 0
                self._closed[board] = self._lost[board]
                continue
            self._silent[board] += 1
            if self._silent[board] >= bound and not self._closed[board]:
                self._closed[board] = True
                self._lost[board] = driven
                closing.append(board)
        return closing

    def start(self) -> None:
        """The arm is enabled: until now the nodes had no need to speak."""
        self._silent = [0] * len(self._silent)

    def close_all(self) -> None:
        """Close every brake, until its node speaks again."""
        self._closed = [True] * len(self._closed)

    def reset(self) -> None:
        """Nodes that were lost may open their brakes again."""
        self._lost = [False] * len(self._lost)

    def closed(self, board: int) -> bool:
        """Whether the brake holds."""
        return self._closed[board]

    def lost(self, board: int) -> bool:
        """Whether the board's node fell silent while the arm was driven, with no RESET since."""
        return self._lost[board]

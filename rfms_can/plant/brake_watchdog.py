"""When a brake closes and opens: by the DAC frames of the node whose joint it holds.

A brake closes only on what must be held. When one node falls silent while the arm moves, the
others send no DAC either until their ladders bring them to a controlled stop, in the third cycle:
they must come to rest on their ramps. So where the joints wait for one of them, brakes wait one
cycle more. They do where no joint is heard, or one alone: that whose own ERROR is lost on the bus,
or refused by all who hear it, has all six and drives on.

A plant that hears neither SYNC nor any DAC is deaf itself, most likely: its joints come to rest on
their ramps meanwhile, and may be heard again. It waits until they should be damped.
"""

from collections.abc import Sequence
from typing import Final

SILENT_CYCLES: Final = 3
"""Cycles without a DAC frame after which a brake closes, where the other joints are heard."""
SPEECHLESS_CYCLES: Final = SILENT_CYCLES + 1
"""The same where the joints wait for one of them: they speak again in the third cycle."""
DEAF_CYCLES: Final = 6
"""The same where not even SYNC is heard of an arm that is driven: one more than the joints take to
damped motion (R3)."""
ALONE: Final = 1
"""Joints that are heard, at most, where all wait for one of them."""


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

    def end_cycle(
        self,
        heard: Sequence[bool],
        *,
        driven: bool,
        together: bool = True,
        synchronised: bool = True,
    ) -> list[int]:
        """A cycle has ended: open the brakes of those that were heard, close those of the silent.

        Args:
            heard: by board, whether a DAC frame came; of one that is lost it does not count.
            driven: whether the arm was driven in this cycle, so that no node may be silent.
            together: whether each joint waits for frames of the others then: not as it homes.
            synchronised: whether a SYNC has begun it.

        Returns:
            The boards whose brakes close now.
        """
        bound = self._bound(heard, together, deaf=driven and not synchronised)
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

    def _bound(self, heard: Sequence[bool], together: bool, deaf: bool) -> int:
        """Cycles of silence after which a brake closes at the end of this one."""
        if deaf and not any(heard):
            return DEAF_CYCLES
        waiting = together and sum(heard[: self._joints]) <= ALONE
        return SPEECHLESS_CYCLES if waiting else SILENT_CYCLES

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

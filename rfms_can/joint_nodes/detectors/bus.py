"""What a node sees of its bus: frames that are bad again and again, a second master, its port."""

from typing import Final

from rfms_can.node.port_counts import PortCounts
from rfms_can.wire.contract import LAST_CYCLE

WINDOW_CYCLES: Final = 10
"""Cycles within which ``BAD_IN_WINDOW`` refused frames of one identifier are too many."""
BAD_IN_WINDOW: Final = 3
FARTHEST_CYCLES: Final = 4
"""Cycles by which a SYNC of the own master may be ahead of the last one, or late behind it; of one
that comes after others were missed, ahead of the cycle under way."""


def ahead(cycle: int, of: int) -> int:
    """Cycles from ``of`` to ``cycle``: numbers of a u32, which begins again at 0."""
    return cycle - of & LAST_CYCLE


class BadFrames:
    """Refused frames, by identifier: when the last of them came."""

    __slots__ = ("_cycles",)

    def __init__(self) -> None:
        self._cycles: dict[int, tuple[int, ...]] = {}

    def reset(self) -> None:
        """Forget them."""
        self._cycles.clear()

    def too_many(self, identifier: int, cycle: int) -> bool:
        """Take one that came in a cycle; whether there were too many in the last ones."""
        earlier = self._cycles.get(identifier, ())
        self._cycles[identifier] = (*earlier, cycle)[1 - BAD_IN_WINDOW :]
        full = len(earlier) == BAD_IN_WINDOW - 1
        return full and ahead(cycle, earlier[0]) < WINDOW_CYCLES


class SyncNumbers:
    """The cycle numbers of the master that drives.

    Attributes:
        last: of the last SYNC that was its; None before the first.
    """

    __slots__ = ("last",)

    def __init__(self) -> None:
        self.last: int | None = None

    def reset(self) -> None:
        """A master may begin with any number."""
        self.last = None

    def is_foreign(self, cycle: int, missed: int = 0) -> bool:
        """Whether no SYNC of that master has this number now.

        Args:
            cycle: the number.
            missed: SYNCs in a row that have not come: the master may have gone on meanwhile.
        """
        if self.last is None:
            return False
        off = ahead(cycle, self.last)
        return FARTHEST_CYCLES + missed < off < LAST_CYCLE + 1 - FARTHEST_CYCLES


class PortWatch:
    """What has become worse at the own port."""

    __slots__ = ("_seen",)

    def __init__(self) -> None:
        self._seen = PortCounts()

    def news(self, counts: PortCounts) -> PortCounts:
        """Take its counts; what has been counted since they were taken last."""
        seen, self._seen = self._seen, counts
        return PortCounts(counts.bus_offs - seen.bus_offs, counts.overflows - seen.overflows)

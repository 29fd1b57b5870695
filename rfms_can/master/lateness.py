"""Whether the master itself is late: its SYNC comes back long after it was due.

SYNC is due on a schedule; when it is heard back it has gone out. A master that needs most of a
cycle for that leaves its nodes no time to answer, and would blame them for it.
"""

from typing import Final

from rfms_can.master.fault import Fault
from rfms_can.messages.culprit import Culprit
from rfms_can.wire.nodes import MASTER, NODE_NAMES

LATE: Final = 1 / 2
"""Lateness over the period from which a cycle is late: what is left does not do for the answers."""
LATE_CYCLES: Final = 3
"""Late cycles in a row after which the master halts the arm."""
LATE_AGAIN: Final = 1 / 3
"""Lateness over the period from which the last of them counts, gone out or not: the command to
stop goes out as late."""
OVERSLEPT: Final = 3
"""Periods by which the master may miss its own deadline; the nodes have begun to stop then."""


class Lateness:
    """Counts the late cycles in a row.

    Args:
        period_ns: control period, ns.
        scheduled: whether cycles begin on a schedule; else it judges nothing.
    """

    __slots__ = ("_confirmed", "_due_ns", "_late", "_period_ns", "_scheduled", "_watching")

    def __init__(self, period_ns: int, *, scheduled: bool) -> None:
        self._period_ns: Final = period_ns
        self._scheduled: Final = scheduled
        self.forget()

    def forget(self) -> None:
        """The arm is enabled: what came before does not count."""
        self._late = 0
        self._due_ns = 0
        self._confirmed = True
        self._watching = False

    def begin(self, due_ns: int) -> None:
        """SYNC is handed over; it was due at ``due_ns``."""
        if not self._scheduled:
            return
        if not self._confirmed:  # that of the cycle before has not even gone out
            self._late += 1
        self._due_ns = due_ns
        self._confirmed = False

    def confirm(self, now_ns: int) -> None:
        """SYNC has gone out."""
        if not self._confirmed:
            self._confirmed = True
            late = now_ns - self._due_ns > LATE * self._period_ns
            self._late = self._late + 1 if late else 0

    @property
    def deadline_ns(self) -> int | None:
        """When SYNC is late for the last time that is borne, ns; None if it is not waited for."""
        if self._confirmed or self._late < LATE_CYCLES - 1:
            return None
        return self._due_ns + round(LATE_AGAIN * self._period_ns)

    def judge(self, now_ns: int, cycle: int) -> Fault | None:
        """Whether the master has been late too often."""
        deadline_ns = self.deadline_ns
        late = deadline_ns is not None and now_ns >= deadline_ns
        if not late and self._late < LATE_CYCLES:
            return None
        return self._fault(now_ns - self._due_ns, LATE, cycle, f"for {LATE_CYCLES} cycles")

    def overslept(self, deadline_ns: int, now_ns: int, cycle: int) -> Fault | None:
        """Whether the master has come to its deadline so late that its nodes stop."""
        late_ns = now_ns - deadline_ns
        if not self._scheduled or late_ns < OVERSLEPT * self._period_ns:
            return None
        return self._fault(late_ns, float(OVERSLEPT), cycle, "at once")

    def _fault(self, late_ns: int, bound: float, cycle: int, since: str) -> Fault:
        name, periods = NODE_NAMES[MASTER], late_ns / self._period_ns
        return Fault(
            f"{name}: its SYNC is {periods:.1f} periods late (bound {bound:.1f}, {since}): its "
            f"computer is too slow, or too busy, for the rate",
            Culprit(name, "SYNC", cycle, periods, bound),
        )

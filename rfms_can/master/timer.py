"""When control cycles begin: the period, the barrier of lockstep, pacing."""

from typing import Final

from rfms_can.master.settings import MasterSettings


class CycleTimer:
    """The master's one deadline, and what it means in each clock.

    ========  ==========================================  ========================================
    clock     the next cycle begins                       the deadline of a cycle under way
    ========  ==========================================  ========================================
    virtual   a period after this one began               the same: what is missing then is late
    realtime  the same, on an absolute schedule           the same
    lockstep  at once when all have answered; paced:      the barrier; paced: once all have
              a period after this one began               answered, the end of the period
    ========  ==========================================  ========================================

    Args:
        settings: clock, rate and barrier.

    Attributes:
        lockstep, realtime: the clock.
    """

    __slots__ = (
        "_began_ns",
        "_deadline_ns",
        "_limit_ns",
        "_paced",
        "_period_ns",
        "_urgent",
        "lockstep",
        "realtime",
    )

    def __init__(self, settings: MasterSettings) -> None:
        self.lockstep: Final = settings.clock_definition.waits_for_nodes
        self.realtime: Final = settings.clock_definition.scheduled
        self._paced = settings.paced
        self._period_ns = settings.period_ns
        self._limit_ns = settings.cycle_limit_ns
        self._began_ns = 0
        self._deadline_ns: int | None = 0
        self._urgent = False

    @property
    def deadline_ns(self) -> int | None:
        """When the driver has to call next, ns; None if never."""
        return 0 if self._urgent else self._deadline_ns

    @property
    def stopped(self) -> bool:
        """Whether no further cycle begins."""
        return self._deadline_ns is None

    def due(self, now_ns: int) -> int | None:
        """The deadline that has been reached, ns, or None."""
        deadline_ns = self._deadline_ns
        return None if deadline_ns is None or now_ns < deadline_ns else deadline_ns

    def begin(self, began_ns: int) -> None:
        """A cycle begins: at ``began_ns``, its deadline on the schedule, whenever it is sent."""
        self._began_ns = began_ns
        self._deadline_ns = began_ns + self._limit_ns

    def close(self) -> bool:
        """A cycle is closed; whether the next one begins at once."""
        if not self.lockstep or self._deadline_ns is None:
            return False
        if self._paced:
            self._deadline_ns = self._began_ns + self._period_ns
            return False
        return True

    def pace(self, paced: bool) -> None:
        """Lockstep cycles are not shorter than the period; for a bus that idles."""
        self._paced = paced

    def retry(self, at_ns: int) -> None:
        """Before cycles run: call again then."""
        self._deadline_ns = at_ns

    def stop(self) -> None:
        """No further cycle begins."""
        self._deadline_ns = None

    def send_now(self) -> None:
        """Have the driver fetch what waits to be sent, without waiting for the deadline."""
        self._urgent = True

    def take_urgent(self) -> bool:
        """Whether the driver has come for what could not wait; once."""
        urgent, self._urgent = self._urgent, False
        return urgent

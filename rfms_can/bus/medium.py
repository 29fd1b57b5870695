"""The shared medium of the simulated bus: arbitration, transmission, error frames.

It handles controllers and frames, not nodes: ``SimulatedBus`` starts the next transmission and
delivers a frame at its end.

***One identifier from two controllers at once**: both win arbitration and go on sending. If the
frames are identical bit for bit, neither detects it and both transmissions succeed: the constant
payload of the emergency stop relies on it. If they differ, the first sender of a recessive bit that
reads back dominant signals an error; both count it and retransmit, until the loser is
error-passive: from then on its error flags do not destroy the other frame.
"""

from collections.abc import Callable, Sequence
from heapq import heapify, heappop, heappush
from typing import Final

from rfms_can.bus.controller import Controller
from rfms_can.bus.disturbance import Disturbance, Disturber
from rfms_can.bus.statistics import BusStatistics
from rfms_can.bus.timing import INTERMISSION_BITS, BusTiming
from rfms_can.wire.frame import Frame

ERROR_FRAME_BITS: Final = 12 + 8  # two superposed error flags, delimiter
SUSPEND_BITS: Final = 8

Entry = tuple[int, int, int, Controller, Frame]
"""A queued frame: identifier, serial number, hand-over time (ns), controller, frame."""


def _dominance(entry: Entry) -> tuple[bool, int, bytes]:
    """Sort key: the smaller frame sends the dominant bit where two of one identifier differ."""
    frame = entry[4]
    return frame.fd, len(frame.data), frame.data


class Medium:
    """The medium and the transmit queues of all controllers on it.

    Attributes:
        pending: heap of the waiting frames, highest priority first.
        sending: the frame on the wire; None between frames.
        twins: the same frame, sent by other controllers at the same time.
        disturbance: of the frame on the wire.
        disturber: asked at the start of each transmission; None if none is.
        end_ns: end of its last bit, or of the error frame that ends it.
        idle_ns: end of the intermission after it.
    """

    __slots__ = (
        "_duration_ns",
        "_errors_seen",
        "_failed",
        "_intermission_ns",
        "_losers",
        "_nominal_ns",
        "_on_bus_off",
        "_serial",
        "_start_ns",
        "_suspended_until_ns",
        "disturbance",
        "disturber",
        "end_ns",
        "idle_ns",
        "pending",
        "sending",
        "statistics",
        "twins",
    )

    def __init__(
        self,
        timing: BusTiming,
        start_ns: int,
        worst_case: bool,
        disturber: Disturber | None,
        on_bus_off: Callable[[], None],
    ) -> None:
        self.statistics = BusStatistics(since_ns=start_ns)
        self.pending: list[Entry] = []
        self.sending: Entry | None = None
        self.twins: tuple[Entry, ...] = ()
        self.disturbance: Disturbance | None = None
        self.end_ns = self.idle_ns = self._start_ns = start_ns
        self.disturber = disturber
        self._nominal_ns = timing.nominal_ns
        self._intermission_ns = timing.nominal_ns(INTERMISSION_BITS)
        self._duration_ns: Callable[[Frame], int] = (
            (lambda frame: timing.worst_case_ns(len(frame.data), frame.fd))
            if worst_case
            else timing.exact_ns
        )
        self._on_bus_off = on_bus_off
        self._failed: tuple[Entry, ...] = ()  # destroyed by an error flag
        self._losers: tuple[Controller, ...] = ()  # error-passive, lost against their identifier
        self._serial = 0
        self._errors_seen = False  # until then all error counters are zero
        self._suspended_until_ns = start_ns

    def queue(self, controller: Controller, frames: Sequence[Frame], now_ns: int) -> None:
        """Put frames into a controller's transmit queue; overflows are counted."""
        for frame in frames:
            if controller.pending >= controller.tx_capacity or controller.bus_off:
                controller.tx_overflow += 1
                continue
            controller.pending += 1
            self._serial += 1
            heappush(self.pending, (frame.id, self._serial, now_ns, controller, frame))

    def start(self, now_ns: int) -> None:
        """Arbitrate among the pending frames; the winner is on the wire from ``now_ns`` on."""
        if now_ns < self._suspended_until_ns:
            entry = self._pop_not_suspended(now_ns)
            if entry is None:
                return
        else:
            entry = heappop(self.pending)
        if self.pending and self.pending[0][0] == entry[0]:
            entry = self._resolve_same_identifier(entry, now_ns)
        frame = entry[4]
        self.sending = entry
        self._start_ns = now_ns
        self.idle_ns = now_ns + self._duration_ns(frame)
        self.end_ns = self.idle_ns - self._intermission_ns
        if self._failed:
            self._destroy(1.0)
        elif self.disturber is not None:
            self.disturbance = self.disturber(now_ns, frame, entry[3].name)
            if self.disturbance is not None and self.disturbance.error_at is not None:
                self._failed = (entry, *self.twins)
                self._destroy(self.disturbance.error_at)

    def finish(self, controllers: Sequence[Controller]) -> Entry | None:
        """End the transmission: the frame if it was sent, None if it was destroyed."""
        entry = self.sending
        assert entry is not None
        self.sending = None
        if self._failed:
            self._count_error(controllers)
            return None
        entry[3].pending -= 1
        if self.twins or self._errors_seen:  # losers are error-passive: errors were seen
            self._count_success(entry, controllers)
        self.statistics.count_frame(entry[0], self.idle_ns - self._start_ns, self.end_ns - entry[2])
        return entry

    def drop(self, controller: Controller) -> None:
        """Forget a controller's queue; its frame on the wire ends as an error frame."""
        self.pending = [entry for entry in self.pending if entry[3] is not controller]
        heapify(self.pending)
        controller.pending = 0
        if self.sending is not None and self.sending[3] is controller:
            self._failed = (self.sending, *self.twins)

    def _destroy(self, fraction: float) -> None:
        """Let an error flag start after a fraction of the frame."""
        flagged_ns = self._start_ns + round(fraction * (self.end_ns - self._start_ns))
        self.end_ns = flagged_ns + self._nominal_ns(ERROR_FRAME_BITS)
        self.idle_ns = self.end_ns + self._intermission_ns

    def _pop_not_suspended(self, now_ns: int) -> Entry | None:
        """The highest-priority frame of a controller that is not suspended; None if all are."""
        free = [entry for entry in self.pending if entry[3].suspended_until_ns <= now_ns]
        if not free:
            self.idle_ns = min(entry[3].suspended_until_ns for entry in self.pending)
            return None
        winner = min(free)
        self.pending.remove(winner)
        heapify(self.pending)
        return winner

    def _resolve_same_identifier(self, first: Entry, now_ns: int) -> Entry:
        """Resolve simultaneous frames of one identifier; sets the twins or the failure."""
        meeting = {first[3].name: first}
        for entry in sorted(self.pending):
            if entry[0] != first[0]:
                break
            if entry[3].suspended_until_ns <= now_ns:
                meeting.setdefault(entry[3].name, entry)
        entries = list(meeting.values())
        winner = min(entries, key=_dominance)
        losers = [entry for entry in entries if entry[4] != winner[4]]
        if losers and not all(entry[3].error_passive for entry in losers):
            self._failed = tuple(entries)
            self.statistics.collisions += 1
        else:
            self.twins = tuple(e for e in entries if e[4] == winner[4] and e is not winner)
            self._losers = tuple(entry[3] for entry in losers)
        leaving = self._failed or (winner, *self.twins)
        # identity of entries is their serial number
        gone = {entry[1] for entry in leaving}
        self.pending = [e for e in (first, *self.pending) if e[1] not in gone]
        heapify(self.pending)
        return winner

    def _count_error(self, controllers: Sequence[Controller]) -> None:
        """Update the error counters after an error frame; requeue the destroyed frames."""
        failed, self._failed, self.twins, self._losers = self._failed, (), (), ()
        self.disturbance = None
        self._errors_seen = True
        self.statistics.error_frames += 1
        self.statistics.busy_ns += self.idle_ns - self._start_ns
        senders = [entry[3] for entry in failed]
        for controller in controllers:
            if controller not in senders and not controller.bus_off:
                controller.receive_failed()
        for entry in failed:
            heappush(self.pending, entry)
            self._count_transmit_error(entry[3])

    def _count_success(self, entry: Entry, controllers: Sequence[Controller]) -> None:
        """Update the error counters after a successful frame, of one controller or several."""
        losers, self._losers = self._losers, ()
        for twin in self.twins:
            twin[3].pending -= 1
        senders = [entry[3], *(twin[3] for twin in self.twins)]
        for controller in controllers:
            if controller in losers:
                self._count_transmit_error(controller)
            elif controller not in senders:
                controller.received()
            elif controller.tec:
                controller.tec -= 1
                self._suspend(controller)

    def _count_transmit_error(self, controller: Controller) -> None:
        controller.transmit_failed()
        if controller.bus_off:
            self.drop(controller)
            self._on_bus_off()
        else:
            self._suspend(controller)

    def _suspend(self, controller: Controller) -> None:
        """Make an error-passive sender wait eight bits longer than the others."""
        if controller.error_passive:
            until_ns = self.idle_ns + self._nominal_ns(SUSPEND_BITS)
            controller.suspended_until_ns = until_ns
            self._suspended_until_ns = max(self._suspended_until_ns, until_ns)

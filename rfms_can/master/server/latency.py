"""From a request's receipt to the SETPOINT it acts in: cycles, and in real time nanoseconds."""

from bisect import bisect_right
from typing import Final, NamedTuple

from rfms_can.master.node import MasterNode
from rfms_can.messages.numbers import LATENCY_EDGES_NS
from rfms_can.wire.contract import LAST_CYCLE

CYCLE_BINS: Final = 4
MAX_PENDING: Final = 1024
"""Requests whose set-point is awaited at a time; more are not measured."""


class _Pending(NamedTuple):
    tick: int
    in_progress: int
    received_ns: int


class Latency:
    """Measures, by what the master has sent, when requests came to act.

    Attributes:
        cycles: histogram of cycles between the one in progress at receipt and the one whose
            SETPOINT carries it; the last bin takes all that is more.
        times: histogram of the times between, by ``LATENCY_EDGES_NS``; empty unless in real time.
        longest_ns: the longest of them.
    """

    def __init__(self, master: MasterNode) -> None:
        self._master = master
        self._realtime = master.settings.clock_definition.scheduled
        self._pending: list[_Pending] = []
        self.cycles = [0] * CYCLE_BINS
        self.times = [0] * (len(LATENCY_EDGES_NS) + 1) if self._realtime else []
        self.longest_ns = 0

    def taken(self, received_ns: int) -> None:
        """A request that changes the motion has been taken."""
        master = self._master
        if len(self._pending) < MAX_PENDING:
            tick = master.motion.generator.tick_count
            self._pending.append(_Pending(tick, master.cycle.in_progress, received_ns))

    def look(self) -> None:
        """See which requests have been sent by now; at best once for every cycle."""
        if not self._pending:
            return
        sent = self._master.cycle.sent
        waiting = []
        for pending in self._pending:
            if sent.tick <= pending.tick:
                waiting.append(pending)
                continue
            later = sent.tick - pending.tick - 1  # set-points sent since, one for each cycle
            cycles = sent.cycle - later - pending.in_progress & LAST_CYCLE
            self.cycles[min(cycles, CYCLE_BINS - 1)] += 1
            if self._realtime:
                time_ns = sent.sent_ns - pending.received_ns
                self.times[bisect_right(LATENCY_EDGES_NS, time_ns)] += 1
                self.longest_ns = max(self.longest_ns, time_ns)
        self._pending = waiting

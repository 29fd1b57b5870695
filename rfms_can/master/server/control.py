"""Who controls the arm, the controlled stop when control is lost, and when time may pass."""

from collections import deque
from typing import Final

from rfms_can.errors import LeaseError
from rfms_can.master.node import MasterNode
from rfms_can.master.phases import Phase
from rfms_can.master.report import holds
from rfms_can.master.server.lease import Lease
from rfms_can.messages import AtRest, LeaseRequest, Outcome

EVENTS_KEPT: Final = 100
CREEP: Final = 1e-4
"""Commanded joint rate, rad/s, below which an arm rests: the end of a transition has some."""
_AT_REST: Final = AtRest()
_TAKEN_IN: Final = frozenset((Phase.RUN, Phase.HALT))
"""Phases in which the lease can be acquired: also of a halted arm, to reset it."""


class Control:
    """The lease, and the controlled stop of an arm without a controller.

    Attributes:
        lease: who controls the arm.
        lapses: how often the arm was stopped because control was lost.
        events: lines for a person at the server; the reader empties it.
    """

    def __init__(self, master: MasterNode) -> None:
        self.lease = Lease()
        self.lapses = 0
        self.events: deque[str] = deque(maxlen=EVENTS_KEPT)
        self._master = master
        self._last: str | None = None
        self._why = ""  # the arm was stopped
        self._stopping = False

    def handle(self, word: str, request: LeaseRequest, now_ns: int) -> None:
        """Do what a session asks of the lease.

        Raises:
            LeaseError: another session has it, or none has; or the arm is not enabled, or is being
                brought to rest because control was lost.
        """
        lease, phase = self.lease, self._master.phase
        if request.action == "acquire":
            if phase not in _TAKEN_IN:
                raise LeaseError(f"the arm is not enabled (phase {phase.name}); try again later")
            if self._stopping and not self._master.motion.at_rest:
                raise LeaseError(f"{self._why}: it can be had when it rests, try again in a moment")
            if lease.holder is None:
                self.events.append(f"{request.name!r} controls the arm")
            lease.acquire(word, request.name, request.duration_s, now_ns)
            if word != self._last:  # another program: the names of the last one are not its own
                self._master.motion.forget()
            self._last, self._stopping = word, False
            return
        lease.check(word, now_ns)
        if request.action == "renew":
            lease.extend(request.duration_s, now_ns)
        else:
            self._lose(Outcome.STOPPED, "gave the arm back")

    def look(self, now_ns: int) -> str | None:
        """See whether the lease has lapsed; word of the session whose it was, or None."""
        if not self.lease.lapsed(now_ns):
            return None
        word = self.lease.holder
        self._lose(Outcome.LAPSED, "did not renew its lease")
        return word

    def _lose(self, how: Outcome, why: str) -> None:
        """Control of the arm is lost: a controlled stop, which changes nothing for one at rest.

        Args:
            how: the outcome of the moves that are stopped or dropped.
            why: what the holder did, after its name.
        """
        master = self._master
        text = f"{self.lease.name!r} {why}"
        self.lease.free()
        moves = not self._rests()
        if master.phase is Phase.RUN:
            master.motion.stop(how, text)
        if master.phase is Phase.RUN and moves:
            self._stopping = True
            self.lapses += 1
            text += ": the arm is brought to rest"
            self._why = text
        self.events.append(text)

    def cycle_closed(self) -> None:
        """See whether an arm that was stopped rests."""
        master = self._master
        if self._stopping and (master.phase is not Phase.RUN or self._rests()):
            self._stopping = False

    def _rests(self) -> bool:
        """Whether the arm stands still and is commanded to: not following a slow goal either."""
        rates = self._master.motion.commanded.rate
        return holds(self._master, _AT_REST) and max(map(abs, rates)) < CREEP

    def time_may_pass(self, *, holder_waits: bool) -> bool:
        """Whether the next cycle may begin: but for real time, coordinators are part of the clock.

        Time passes while the holder of the lease waits, while the arm is brought up, and while it
        is brought to rest because control was lost or by a fault.
        """
        master = self._master
        if not master.settings.clock_definition.waits_for_programs:
            return True
        if master.phase is Phase.HALT:
            return not master.cycle.settled
        return holder_waits or self._stopping or master.phase is not Phase.RUN

"""The server's core: sessions, lease, waits, emergency stops and the clock rule, without sockets.

The owner of the sockets hands in what peers sent and when, and sends what is handed back. Nothing a
peer sends raises: what cannot be read, is out of turn or not allowed is refused with a reason and
counted.
"""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Final, get_args

from rfms_can.errors import FaultError, LeaseError, LinkError, RfmsError
from rfms_can.master.node import MasterNode
from rfms_can.master.server.control import Control
from rfms_can.master.server.latency import Latency
from rfms_can.master.server.reading import (
    Head,
    read_emergency,
    read_head,
    read_lift,
    read_request,
)
from rfms_can.master.server.replies import Outgoing, Replies, Result
from rfms_can.master.server.sensors import Sensors
from rfms_can.master.server.sessions import Session, Sessions, Wait
from rfms_can.master.server.waits import Waits
from rfms_can.messages import (
    Answer,
    AnyRequest,
    GrantRequest,
    LeaseRequest,
    MoveRequest,
    OutcomeQuery,
    Query,
    ResetRequest,
    SensorRequest,
    ServerNumbers,
    Status,
    StopRequest,
    TransformMessage,
    WaitRequest,
)
from rfms_can.messages.session import QueryKind
from rfms_can.tables import complete

_TIMED: Final = (TransformMessage, MoveRequest, StopRequest)
"""Requests whose latency to the bus is measured."""

NO_GRANTS: Final[Mapping[str, Sequence[str]]] = MappingProxyType({})


class Server:
    """Answers coordinators on behalf of a master.

    Args:
        master: the master; its bus is run elsewhere.
        grants: references by the sensor that may observe them, under any coordinator.

    Attributes:
        unattended: lockstep cycles that went on although the holder of the lease did not wait.
    """

    def __init__(self, master: MasterNode, grants: Mapping[str, Sequence[str]] = NO_GRANTS) -> None:
        self.unattended = 0
        self._master = master
        self._sessions = Sessions()
        self._control = Control(master)
        self._sensors = Sensors(master, self._control.lease, self._control.events, grants)
        self._replies = Replies(master, self._control.lease)
        self._replies.sensors = lambda: self._sensors.states
        self._waits = Waits(master, self._sessions, self._replies)
        self._latency = Latency(master)
        self._ending = ""
        self._noted: str | None = None
        self._requests = self._repeated = self._emergencies = 0

    # --- what comes in ------------------------------------------------------------------------

    def receive(self, peer: bytes, data: bytes, now_ns: int) -> list[Outgoing]:
        """Take a message.

        Args:
            peer: who sent it, as the sockets tell peers apart.
            data: the message.
            now_ns: wall-clock time of its receipt, monotonic.

        Returns:
            Replies to send; one to a wait comes when it holds.
        """
        head = read_head(data)
        if isinstance(head, str):
            self._replies.make(peer, 0, LinkError(head))
        else:
            lease = self._control.lease
            if head.session == lease.holder:
                lease.renew(now_ns)  # a peer that speaks is alive
            self._sensors.heard(head.session, now_ns)
            self._look(now_ns)
            self._take(peer, head, now_ns)
        return self._replies.take()

    def emergency(self, data: bytes) -> list[Outgoing]:
        """Take what came on the queue of emergency stops; it needs no lease and has no reply.

        Returns:
            Replies to who waited.
        """
        emergency = read_emergency(data)
        if isinstance(emergency, str):
            self._replies.refused += 1
            return []
        self._emergencies += 1
        reason = f": {emergency.reason!r}" if emergency.reason else ""
        self._master.emergency_stop(f"emergency stop by {emergency.name!r}{reason}")
        self._waits.answer(self._failure())
        return self._replies.take()

    def operator(self, data: bytes) -> None:
        """Take what came on the operator's queue: a person lifts the emergency stop."""
        lift = read_lift(data)
        if isinstance(lift, str):
            self._replies.refused += 1
        elif self._master.lift_emergency_stop():
            self._control.events.append(
                f"{lift.name!r} lifted the emergency stop; the arm stays halted until it is reset"
            )

    # --- time ---------------------------------------------------------------------------------

    @property
    def time_may_pass(self) -> bool:
        """Whether the next cycle may begin; see ``Control.time_may_pass``. Sensors wait too."""
        control, waits = self._control, self._waits
        all_wait = waits.of(control.lease.holder) and self._sensors.all_wait(waits.of)
        return control.time_may_pass(holder_waits=all_wait)

    @property
    def holder(self) -> str | None:
        """What the holder of the lease calls itself; None while the lease is free."""
        return self._control.lease.name

    @property
    def events(self) -> deque[str]:
        """Lines for a person at the server; the reader empties it."""
        return self._control.events

    def close_cycle(self, now_ns: int) -> list[Outgoing]:
        """A cycle has been closed: answer the waits that hold now. Broadcast ``status`` then.

        Args:
            now_ns: wall-clock time, monotonic.

        Returns:
            Replies to send.
        """
        self._latency.look()
        lockstep = self._master.settings.clock_definition.waits_for_nodes
        if lockstep and self.holder is not None and not self.time_may_pass:
            self.unattended += 1
        self._control.cycle_closed()
        return self.look(now_ns)

    def look(self, now_ns: int) -> list[Outgoing]:
        """See whether the lease has lapsed and whether waits hold; now and then, if no cycle ends.

        Args:
            now_ns: wall-clock time, monotonic.

        Returns:
            Replies to send.
        """
        self._look(now_ns)
        self._waits.answer(self._failure())
        return self._replies.take()

    def status(self) -> Status:
        """The arm's state, as of the last closed cycle."""
        return self._replies.status()

    def end(self, reason: str) -> list[Outgoing]:
        """The server ends: tell who waits, and refuse all requests from now on."""
        self._ending = reason
        self._waits.answer(self._failure())
        return self._replies.take()

    def numbers(self) -> ServerNumbers:
        """What has been counted so far."""
        latency = self._latency
        return ServerNumbers(
            sessions=len(self._sessions),
            requests=self._requests,
            repeated=self._repeated,
            refused=self._replies.refused,
            emergencies=self._emergencies,
            lapses=self._control.lapses,
            unattended=self.unattended,
            latency_cycles=list(latency.cycles),
            latency_ns=list(latency.times),
            latency_max_ns=latency.longest_ns,
        )

    # --- one request --------------------------------------------------------------------------

    def _take(self, peer: bytes, head: Head, now_ns: int) -> None:
        """See that it is its turn, and process it once."""
        session = self._sessions.find(head.session)
        due = 1 if session is None else session.serial + 1
        if head.serial == due:
            session = session or self._open(head.session)
            session.peer = peer
            session.serial = head.serial
            self._process(session, head, now_ns)
        elif session is not None and session.knows(head.serial):
            self._repeated += 1
            session.peer = peer
            reply = session.replies.get(head.serial)
            if reply is not None:
                self._replies.repeat(peer, reply)
        else:
            known = "the session is not known here" if session is None else "out of turn"
            error = LinkError(f"serial {head.serial}: {known}, {due} is expected")
            self._replies.make(peer, head.serial, error)

    def _open(self, word: str) -> Session:
        session, forgotten = self._sessions.open(word, keep=self._control.lease.holder)
        if forgotten is not None:
            self._waits.end(forgotten, LinkError("forgotten: too many sessions spoke since"))
        return session

    def _process(self, session: Session, head: Head, now_ns: int) -> None:
        self._requests += 1
        result: Result
        try:
            request = read_request(head)
            if isinstance(request, str):
                raise LinkError(request)
            if isinstance(request, WaitRequest):
                self._check_running()
                self._check_kept(session)
                self._sensors.check_wait(session.word)
                self._waits.begin(session, Wait(head.serial, request.any_of))
                return
            result = self._do(session, request, now_ns)
        except RfmsError as error:
            result = error
        reply = self._replies.make(session.peer, head.serial, result)
        session.keep(head.serial, reply, of_wait=False)

    def _do(self, session: Session, request: AnyRequest, now_ns: int) -> Answer:
        """Process a request that is answered at once; raises ``RfmsError`` to refuse it."""
        master = self._master
        if isinstance(request, OutcomeQuery):
            outcomes = master.motion.generator.outcomes
            return Answer(outcomes=outcomes.of(request.first, request.last))
        if isinstance(request, Query):
            return _ANSWERS[request.what](self, request)
        self._check_serving()
        if isinstance(request, SensorRequest):
            self._check_running()
            self._sensors.handle(session.word, request, now_ns)
            return Answer()
        observes = self._sensors.check(session.word, request)
        if isinstance(request, LeaseRequest):
            if request.action == "renew":
                self._check_kept(session)
            self._control.handle(session.word, request, now_ns)
            session.lost = None
            return Answer()
        self._check_kept(session)
        if not observes:
            self._control.lease.check(session.word, now_ns)
        if not isinstance(request, ResetRequest):
            self._check_running()
        if isinstance(request, GrantRequest):
            self._sensors.grant(request)
            return Answer()
        answer = master.handle(request)
        if isinstance(request, _TIMED):
            self._latency.taken(now_ns)
        return answer

    def _names(self, query: Query) -> Answer:
        return Answer(world=self._master.motion.world.names(query.start))

    def _look(self, now_ns: int) -> None:
        self._note_fault()
        name = self.holder
        word = self._control.look(now_ns)
        session = None if word is None else self._sessions.find(word)
        if session is not None:
            session.lost = (
                f"{name!r} did not renew its lease in time and no longer controls the arm, which "
                "was brought to rest and its moves dropped: connect again"
            )
            self._waits.end(session, LeaseError(session.lost))

        for sensor, error in self._sensors.look(now_ns):
            session = self._sessions.find(sensor)
            if session is not None:
                self._waits.end(session, error)

    def _note_fault(self) -> None:
        """Tell a person at the server when the arm is halted, and when it is enabled again."""
        fault = self._master.fault
        if fault != self._noted:
            self._noted = fault
            culprit = self._master.culprit
            whom = "" if culprit is None else f"; culprit: {culprit.words}"
            halted = f"halted: {fault}{whom}; reset() of its program, or rfms reset, leads back"
            self.events.append("reset: the arm is called back" if fault is None else halted)

    def _check_kept(self, session: Session) -> None:
        """A session that lost the lease is told so at its next word, whatever it asks for."""
        if session.lost is not None:
            raise LeaseError(session.lost)

    def _failure(self) -> RfmsError | None:
        """Why the arm takes no further requests, or None."""
        if self._master.fault is not None:
            return FaultError(self._master.fault)
        return LinkError(self._ending) if self._ending else None

    def _check_serving(self) -> None:
        if self._ending:
            raise LinkError(self._ending)

    def _check_running(self) -> None:
        failure = self._failure()
        if failure is not None:
            raise failure


_ANSWERS: Final[dict[QueryKind, Callable[[Server, Query], Answer]]] = complete(
    {
        "status": lambda *_: Answer(),  # each reply tells it
        "world": Server._names,
        "server": lambda server, _: Answer(server=server.numbers()),
    },
    get_args(QueryKind),
)

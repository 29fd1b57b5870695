"""A server's core on a simulated rig: coordinators that say what tests want, no sockets."""

from collections.abc import Callable
from typing import Any

import msgspec

from rfms_can.master.phases import Phase
from rfms_can.master.server.core import Server
from rfms_can.master.server.replies import Outgoing
from rfms_can.messages import (
    AnyRequest,
    EmergencyStop,
    Envelope,
    LeaseRequest,
    ModeMessage,
    MoveRequest,
    PositionMessage,
    Reply,
    TransformMessage,
)
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.transform import Transform
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame

encode = msgspec.msgpack.encode
_replies = msgspec.msgpack.Decoder(Reply)
SECOND = 1_000_000_000


class Bench:
    """An enabled arm on the simulated bus, its server, and a wall clock of its own.

    Attributes:
        now_ns: wall-clock time; tests move it.
        inbox: replies by peer.
    """

    def __init__(self, wire: Wire) -> None:
        self.rig = SimulatedRig(RunSettings(friction="none"), wire)
        self.master = self.rig.master
        self.rig.pump(lambda: self.master.phase is Phase.READY)
        self.master.start()
        self.rig.pump(lambda: self.master.phase is Phase.RUN)
        self.server = Server(self.master)
        self.now_ns = 0
        self.inbox: dict[bytes, list[Reply]] = {}
        self.frames: list[Frame] = []
        self.rig.observe(lambda _, frame: self.frames.append(frame))

    def hear(self, outgoing: list[Outgoing]) -> list[Reply]:
        """Put replies into the peers' inboxes; all of them."""
        replies = []
        for peer, data in outgoing:
            replies.append(_replies.decode(data))
            self.inbox.setdefault(peer, []).append(replies[-1])
        return replies

    def give(self, data: bytes, peer: bytes = b"somebody") -> list[Reply]:
        """Hand bytes to the server as they are."""
        return self.hear(self.server.receive(peer, data, self.now_ns))

    def emergency(self, name: str, reason: str = "") -> list[Reply]:
        """An emergency stop."""
        return self.hear(self.server.emergency(encode(EmergencyStop(name, reason))))

    def cycles(self, number: int = 1) -> None:
        """Let cycles be closed, whatever the clock rule says."""
        for _ in range(number):
            closed = self.master.closed
            self.rig.pump(lambda closed=closed: self.master.closed > closed)  # type: ignore[misc]
            self.hear(self.server.close_cycle(self.now_ns))

    def steps(self, number: int) -> None:
        """Let so many things happen on the bus, and cycles be closed with them."""
        closed = self.master.closed
        for _ in range(number):
            self.rig.bus.step()
            if self.master.closed != closed:
                closed = self.master.closed
                self.hear(self.server.close_cycle(self.now_ns))

    def run(self, until: Callable[[], bool], limit: int = 5000) -> int:
        """Let time pass as long as the server says it may; how many cycles that were."""
        for count in range(limit):
            if until() or not self.server.time_may_pass:
                return count
            self.cycles()
        raise AssertionError(f"not within {limit} cycles")

    @property
    def t6(self) -> Transform:
        """Where the arm is."""
        return Transform(*self.server.status().t6)


class Coordinator:
    """One session."""

    def __init__(self, bench: Bench, name: str) -> None:
        self.bench = bench
        self.name = name
        self.peer = name.encode()
        self.session = f"session of {name}".ljust(16, "x")
        self.serial = 0

    def envelope(self, message: AnyRequest, serial: int | None = None) -> bytes:
        """A request under the next serial number, or another."""
        if serial is None:
            serial = self.serial = self.serial + 1
        return encode(Envelope(self.session, serial, message))

    def ask(self, message: AnyRequest) -> Reply | None:
        """Send a request; the reply to it, None if it waits."""
        replies = self.bench.give(self.envelope(message), self.peer)
        return next((reply for reply in replies if reply.serial == self.serial), None)

    def done(self, message: AnyRequest) -> Reply:
        """Send a request that must be taken."""
        reply = self.ask(message)
        assert reply is not None
        assert reply.refusal is None, reply.refusal
        return reply

    def refused(self, message: AnyRequest) -> tuple[str, str]:
        """Send a request that must be refused: error and reason."""
        reply = self.ask(message)
        assert reply is not None
        assert reply.refusal is not None
        assert reply.answer is None
        return reply.refusal.error, reply.refusal.reason

    def acquire(self, duration_s: float = 1.0) -> "Coordinator":
        """Take the lease."""
        self.done(LeaseRequest("acquire", self.name, duration_s))
        return self

    def move(self, name: str = "there", seconds: float = 1.0, **by: Any) -> int:
        """Ask for a move by a translation from where the arm is (m); its number."""
        place = Transform.translation(by.get("x", 0.0), by.get("y", 0.0), by.get("z", 0.05))
        self.done(TransformMessage(name, place @ self.bench.t6))
        self.done(PositionMessage(name, ["t6"], [name]))
        self.done(ModeMessage(name, "joint", 0.2, seconds))
        answer = self.done(MoveRequest(name, name)).answer
        assert answer is not None
        return answer.sequence

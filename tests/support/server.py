"""Servers: a core on a simulated rig without sockets, and a real one in a thread with clients."""

import json
import secrets
import socket
import subprocess
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Self

import msgspec

from rfms_can.link.client import ClientSocket
from rfms_can.master.phases import Phase
from rfms_can.master.server.core import Server
from rfms_can.master.server.replies import Outgoing
from rfms_can.messages import (
    Answer,
    AnyCondition,
    AnyRequest,
    EmergencyStop,
    Envelope,
    LeaseRequest,
    ModeMessage,
    MoveRequest,
    PositionMessage,
    Query,
    Refusal,
    Reply,
    Status,
    TransformMessage,
    WaitRequest,
)
from rfms_can.rig.serve import Listening, Served, Serving, serve
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.transform import Transform
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from support.command_line import end, kill, start

encode = msgspec.msgpack.Encoder().encode
_reply = msgspec.msgpack.Decoder(Reply).decode
_status = msgspec.msgpack.Decoder(Status).decode
LONG_S = 20.0
SECOND = 1_000_000_000


class Session(ABC):
    """What a coordinator says to a server, whatever carries it.

    Attributes:
        name: it gives itself.
        lease_s: how long its leases last.
    """

    lease_s = 1.0

    def __init__(self, name: str) -> None:
        self.name = name

    @abstractmethod
    def ask(self, message: AnyRequest) -> Reply | None:
        """Send a request; the reply to it, None if it waits."""

    @property
    @abstractmethod
    def t6(self) -> Transform:
        """Where the arm is."""

    def query(self) -> Status:
        """The status in the reply to a query."""
        reply = self.ask(Query())
        assert reply is not None
        return reply.status

    def done(self, message: AnyRequest) -> Answer:
        """Send a request that must be taken."""
        reply = self.ask(message)
        assert reply is not None
        assert reply.refusal is None, reply.refusal
        assert reply.answer is not None
        return reply.answer

    def refused(self, message: AnyRequest) -> Refusal:
        """Send a request that must be refused."""
        reply = self.ask(message)
        assert reply is not None
        assert reply.answer is None
        assert reply.refusal is not None
        return reply.refusal

    def acquire(self, duration_s: float | None = None) -> Self:
        """Take the lease."""
        self.done(LeaseRequest("acquire", self.name, duration_s or self.lease_s))
        return self

    def move(
        self,
        name: str = "there",
        seconds: float = 1.0,
        *,
        x: float = 0.0,
        y: float = 0.0,
        z: float = 0.05,
    ) -> int:
        """Ask for a move by a translation from where the arm is (m); its number."""
        self.done(TransformMessage(name, Transform.translation(x, y, z) @ self.t6))
        self.done(PositionMessage(name, ["t6"], [name]))
        self.done(ModeMessage(name, "joint", 0.2, seconds))
        return self.done(MoveRequest(name, name)).sequence


class Client(Session):
    """One session with a server.

    Attributes:
        socket: its sockets.
        serial: number of the request sent last.
    """

    lease_s = 2.0

    def __init__(self, address: str, name: str = "client") -> None:
        self.socket = ClientSocket(address)
        super().__init__(name)
        self.session = secrets.token_hex(16)
        self.serial = 0

    def send(self, message: AnyRequest) -> int:
        """Send a request; its number."""
        self.serial += 1
        self.socket.send(encode(Envelope(self.session, self.serial, message)))
        return self.serial

    def reply(self, serial: int, timeout_s: float = LONG_S) -> Reply:
        """The reply to a request; others are dropped."""
        until = time.monotonic() + timeout_s
        while time.monotonic() < until:
            data = self.socket.receive(0.2)
            reply = None if data is None else _reply(data)
            if reply is not None and reply.serial == serial:
                return reply
        raise AssertionError(f"{self.name}: no reply to {serial} within {timeout_s} s")

    def ask(self, message: AnyRequest) -> Reply:
        """Send a request and wait for its reply."""
        return self.reply(self.send(message))

    @property
    def t6(self) -> Transform:
        """Where the arm is."""
        return Transform(*self.query().t6)

    def wait(self, *any_of: AnyCondition) -> Reply:
        """Wait, and renew the lease meanwhile."""
        serial = self.send(WaitRequest(list(any_of)))
        for _ in range(200):
            try:
                return self.reply(serial, 0.25)
            except AssertionError:
                self.send(LeaseRequest("renew", duration_s=self.lease_s))
        raise AssertionError(f"{self.name}: no end of {any_of}")

    def status(self, timeout_s: float = LONG_S) -> Status:
        """The newest status that has been broadcast."""
        data = self.socket.newest_status(timeout_s)
        assert data is not None
        return _status(data)

    def watch(self, until: Callable[[Status], bool], timeout_s: float = LONG_S) -> Status:
        """Read the status until a condition on it holds."""
        end = time.monotonic() + timeout_s
        while time.monotonic() < end:
            status = self.status()
            if until(status):
                return status
        raise AssertionError(f"not within {timeout_s} s: {status}")

    def emergency(self, reason: str = "") -> None:
        """An emergency stop."""
        self.socket.emergency(encode(EmergencyStop(self.name, reason)))

    def close(self) -> None:
        """Disconnect."""
        self.socket.close()


class Running:
    """``rfms serve`` in a thread of this process, so that tests see what it ended with.

    Attributes:
        served: how it ended; None while it runs.
        serving: what runs, once it does.
    """

    def __init__(self, settings: RunSettings, listening: Listening) -> None:
        self.served: Served | None = None
        self.serving: Serving | None = None
        self.failure: BaseException | None = None
        self.clients: list[Client] = []
        self.name = listening.name
        self._stop = threading.Event()
        self._ready = threading.Event()
        self._thread = threading.Thread(target=self._run, args=(settings, listening))
        self._thread.start()
        while not self._ready.wait(0.05):
            assert self._thread.is_alive(), self.failure

    def _run(self, settings: RunSettings, listening: Listening) -> None:
        def show(serving: Serving) -> None:
            self.serving = serving

        try:
            self.served = serve(
                settings,
                listening,
                ready=self._ready.set,
                shown=show,
                interrupted=self._stop.is_set,
            )
        except BaseException as error:
            self.failure = error

    def __enter__(self) -> "Running":
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    def client(self, name: str) -> Client:
        """A client of it, closed at its end."""
        self.clients.append(Client(self.name, name))
        return self.clients[-1]

    def end(self) -> Served:
        """Let it end, as a signal would."""
        self._stop.set()
        return self.join()

    def join(self) -> Served:
        """Wait until it has ended; how it did."""
        self._thread.join(LONG_S)
        assert not self._thread.is_alive()
        for client in self.clients:
            client.close()
        self.clients.clear()
        assert self.failure is None, self.failure
        assert self.served is not None
        return self.served


class ServeProcess:
    """``rfms serve --json`` as a process; what is left of it is killed at the end."""

    def __init__(self, *arguments: str) -> None:
        self.process: subprocess.Popen[str] = start("serve", "--json", *arguments)
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        assert line, end(self.process)
        assert json.loads(line) == {"ready": "rfms"}

    def __enter__(self) -> "ServeProcess":
        return self

    def __exit__(self, *_: object) -> None:
        kill(self.process)
        end(self.process)


def free_port() -> int:
    """A port with two free ones after it."""
    while True:
        with socket.socket() as first:
            first.bind(("127.0.0.1", 0))
            port = int(first.getsockname()[1])
        try:
            for number in (port, port + 1, port + 2):
                with socket.socket() as one:
                    one.bind(("127.0.0.1", number))
        except OSError:
            continue
        return port


class ServerBench:
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
            replies.append(_reply(data))
            self.inbox.setdefault(peer, []).append(replies[-1])
        return replies

    def give(self, data: bytes, peer: bytes = b"peer") -> list[Reply]:
        """Hand bytes to the server as they are."""
        return self.hear(self.server.receive(peer, data, self.now_ns))

    def emergency(self, name: str, reason: str = "") -> list[Reply]:
        """An emergency stop."""
        return self.hear(self.server.emergency(encode(EmergencyStop(name, reason))))

    def cycles(self, number: int = 1) -> None:
        """Let cycles be closed, whatever the clock rule says; fewer if no cycle begins any more."""
        master = self.master
        for _ in range(number):
            until = master.closed + 1
            self.rig.pump(lambda until=until: master.closed >= until or master.timer.stopped)  # type: ignore[misc]
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


class Coordinator(Session):
    """A session with a server on a bench."""

    def __init__(self, bench: ServerBench, name: str) -> None:
        self.bench = bench
        super().__init__(name)
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

    @property
    def t6(self) -> Transform:
        """Where the arm is."""
        return self.bench.t6

"""Clients of a real server for tests: requests over its sockets, one after the other."""

import secrets
import threading
import time
from collections.abc import Callable

import msgspec

from rfms_can.link.client import ClientSocket
from rfms_can.messages import (
    Answer,
    AnyCondition,
    AnyRequest,
    EmergencyStop,
    Envelope,
    LeaseRequest,
    Refusal,
    Reply,
    Status,
    WaitRequest,
)
from rfms_can.rig.serve import Listening, Served, Serving, serve
from rfms_can.rig.settings import RunSettings

_encode = msgspec.msgpack.Encoder().encode
_reply = msgspec.msgpack.Decoder(Reply).decode
_status = msgspec.msgpack.Decoder(Status).decode
LONG_S = 20.0


class Client:
    """One session with a server.

    Attributes:
        socket: its sockets.
        serial: number of the request sent last.
    """

    def __init__(self, address: str, name: str = "client") -> None:
        self.socket = ClientSocket(address)
        self.name = name
        self.session = secrets.token_hex(16)
        self.serial = 0

    def send(self, message: AnyRequest) -> int:
        """Send a request; its number."""
        self.serial += 1
        self.socket.send(_encode(Envelope(self.session, self.serial, message)))
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

    def done(self, message: AnyRequest) -> Answer:
        """Send a request that must be taken."""
        reply = self.ask(message)
        assert reply.refusal is None, reply.refusal
        assert reply.answer is not None
        return reply.answer

    def refused(self, message: AnyRequest) -> Refusal:
        """Send a request that must be refused."""
        reply = self.ask(message)
        assert reply.refusal is not None
        return reply.refusal

    def acquire(self, duration_s: float = 2.0) -> None:
        """Take the lease."""
        self.done(LeaseRequest("acquire", self.name, duration_s))

    def wait(self, *any_of: AnyCondition) -> Reply:
        """Wait, and renew the lease meanwhile."""
        serial = self.send(WaitRequest(list(any_of)))
        for _ in range(200):
            try:
                return self.reply(serial, 0.25)
            except AssertionError:
                self.send(LeaseRequest("renew", duration_s=2.0))
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
        self.socket.emergency(_encode(EmergencyStop(self.name, reason)))

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

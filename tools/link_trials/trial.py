"""One trial from its seed: a server, a client in motion, what happens to it, and the truth."""

import contextlib
import json
import os
import random
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, Self

from link_trials import client
from link_trials.judgement import EVENTS, Event, Row
from link_trials.relay import HOST, Relay, free_ports
from rfms_can.coordinator import LeaseError, MoveOutcome, RfmsError, Status, connect
from rfms_can.coordinator.remote import RemoteLink
from rfms_can.link.address import SOCKETS
from rfms_can.link.client import ClientSocket
from rfms_can.messages import CycleReached

NAME: Final = "trials"
LEASE_S: Final = 0.4
SEGMENT_S: Final = 6.0
"""Time of the long move on the arm's clock, s."""
LIFT_M: Final = 0.05
LONGEST_S: Final = 30.0
"""Wall time after which a client has not ended, or an arm does not rest, s."""
LOOK_S: Final = 0.01
PROGRAMS: Final = (*client.PROGRAMS, client.COROUTINES)
_SERVE: Final = "from rfms_can.cli.app import main; main()"


class Server:
    """``rfms serve`` in a process of its own, with a relay before its TCP ports.

    Args:
        arguments: of ``rfms serve`` besides.

    Attributes:
        address: of the relay.
        low: height of the arm at its start, m.
    """

    def __init__(self, *arguments: str) -> None:
        ports = free_ports(2 * len(SOCKETS))
        tcp = ports + len(SOCKETS)
        command = [sys.executable, "-c", _SERVE, "serve", "--json", "--name", NAME]
        self._process = subprocess.Popen(
            [*command, "--tcp", str(tcp), *arguments], stdout=subprocess.PIPE, text=True
        )
        assert self._process.stdout is not None
        if json.loads(self._process.stdout.readline() or "{}") != {"ready": NAME}:
            raise RuntimeError("the server did not come up; see its message above")
        self.relay = Relay(ports, tcp, len(SOCKETS))
        self.address = f"tcp://{HOST}:{ports}"
        with Observer() as observer:
            self.low = observer.status().t6[11]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.send_signal(signal.SIGTERM)
        try:
            self._process.communicate(timeout=LONGEST_S)
        except subprocess.TimeoutExpired:
            self._process.kill()


class Observer:
    """A session that reads, and never controls the arm."""

    def __init__(self) -> None:
        self._socket = ClientSocket(NAME)
        self._link = RemoteLink(self._socket, "observer", LEASE_S)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._socket.close()

    def status(self) -> Status:
        """The server's state now."""
        self._link.wait(CycleReached(0))
        return self._link.status()

    def until(self, holds: Callable[[Status], bool], longest_s: float = LONGEST_S) -> float | None:
        """How long it took until a condition on the state held, s; None if it did not."""
        began = time.monotonic()
        while time.monotonic() < began + longest_s:
            if holds(self.status()):
                return time.monotonic() - began
            time.sleep(LOOK_S)
        return None

    def outcomes(self, moves: list[int]) -> list[MoveOutcome]:
        """How moves ended."""
        return self._link.outcomes(moves[0], moves[-1]) if moves else []


class Client:
    """The client under trial.

    Attributes:
        words: what it has said.
    """

    def __init__(self, address: str, program: str, low: float) -> None:
        numbers = (LEASE_S, SEGMENT_S, low, low + LIFT_M)
        self.words: dict[str, Any] = {}
        self._process = subprocess.Popen(
            [sys.executable, client.__file__, address, program, *map(str, numbers)],
            stdout=subprocess.PIPE,
            text=True,
        )
        self._moves = threading.Event()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            with contextlib.suppress(json.JSONDecodeError):  # killed in mid-line
                self.words |= json.loads(line)
            if "moves" in self.words or "error" in self.words:
                self._moves.set()

    def moving(self) -> None:
        """Wait until it has asked for its moves."""
        self._moves.wait(LONGEST_S)

    def signal(self, number: signal.Signals) -> None:
        """Send it a signal, if it still runs."""
        if self._process.poll() is None:
            os.kill(self._process.pid, number)

    def end(self) -> int | None:
        """Wait for its end; its exit code, None if it did not end by itself."""
        try:
            code: int | None = self._process.wait(LONGEST_S)
        except subprocess.TimeoutExpired:
            code = None
            self._process.kill()
        self._reader.join(LONGEST_S)
        return code


def next_client(low: float, *, retry_s: float = LONGEST_S) -> str:
    """Another client takes the arm and moves it; how its move ended."""
    until = time.monotonic() + retry_s
    while True:
        try:
            with connect(NAME, name="next", lease_s=2.0) as arm:
                number = client.move(arm, 1.5, low, low + LIFT_M)
                arm.wait(number)
                return arm.outcome(number).how.value
        except LeaseError as error:
            if time.monotonic() > until:
                return str(error)
            time.sleep(0.05)
        except RfmsError as error:
            return f"{type(error).__name__}: {error}"


def run_trial(seed: int, server: Server) -> Row:
    """The trial of a seed: the event in turn, all else drawn."""
    rng = random.Random(seed)
    event = list(Event)[seed % len(Event)]
    program = rng.choice(PROGRAMS)
    delay_s, lasts_s = rng.uniform(0.0, 0.4), _lasts(event, rng)
    address = server.address if EVENTS[event].over_tcp else NAME
    one = Client(address, program, server.low)
    one.moving()
    with Observer() as observer:
        observer.until(lambda status: status.stage != "IDLE", 5.0)
        time.sleep(delay_s)
        before = observer.status()
        served = _DO[event](one, server, lasts_s)
        began = time.monotonic()
        lost = lasts_s > 0.0 and observer.status().lease != client.NAME
        if event in (Event.FREEZE, Event.TAKEN):
            one.signal(signal.SIGCONT)
        server.relay.mend()
        code = one.end()
        rested = observer.until(
            lambda s: s.at_rest and s.waiting == 0 and s.lease is None and s.stage == "IDLE"
        )
        rest_s = None if rested is None else time.monotonic() - began
        served = served or next_client(server.low)
        truth = observer.outcomes(one.words.get("moves", []))
        fault = observer.status().fault
    lapsed = any(outcome.how.value == "lapsed" for outcome in truth)
    return Row(
        seed=seed,
        event=event,
        program=program,
        lasted_s=round(lasts_s, 3),
        in_motion=before.stage != "IDLE",
        lost=(lost or lapsed) and EVENTS[event].goes_on,
        exit=code,
        heard=one.words.get("error"),
        claims=one.words.get("claims", {}),
        truth={str(outcome.sequence): outcome.how.value for outcome in truth},
        rest_s=None if rest_s is None else round(rest_s, 3),
        served=served,
        fault=fault,
    )


def _lasts(event: Event, rng: random.Random) -> float:
    """How long it is frozen or cut off, s: about the lease; a connection also for long."""
    match event:
        case Event.FREEZE:
            return rng.uniform(0.05, 1.5)
        case Event.CUT:
            return rng.choice((rng.uniform(0.05, 1.5), 7.0))
        case Event.TAKEN:
            return 3.0 * LEASE_S
        case _:
            return 0.0


def _kill(one: Client, _server: Server, _lasts_s: float) -> str:
    one.signal(signal.SIGKILL)
    return ""


def _freeze(one: Client, _server: Server, lasts_s: float) -> str:
    one.signal(signal.SIGSTOP)
    time.sleep(lasts_s)
    return ""


def _cut(_one: Client, server: Server, lasts_s: float) -> str:
    server.relay.cut()
    time.sleep(lasts_s)
    return ""


def _take(one: Client, server: Server, lasts_s: float) -> str:
    """Another client takes the lapsed lease, and is disturbed by the first one's return."""
    one.signal(signal.SIGSTOP)
    time.sleep(lasts_s)
    served: list[str] = []
    other = threading.Thread(target=lambda: served.append(next_client(server.low)))
    other.start()
    with Observer() as observer:
        observer.until(lambda status: status.lease == "next", 5.0)
    one.signal(signal.SIGCONT)
    other.join(LONGEST_S)
    return served[0] if served else "it was not served"


def _interrupt(one: Client, _server: Server, _lasts_s: float) -> str:
    one.signal(signal.SIGINT)
    return ""


_DO: Final[dict[Event, Callable[[Client, Server, float], str]]] = {
    Event.KILL: _kill,
    Event.FREEZE: _freeze,
    Event.CUT: _cut,
    Event.TAKEN: _take,
    Event.GIVEN: _interrupt,
}


def runtime_directory(path: Path) -> None:
    """Let servers of this process and its children meet in a directory of their own."""
    os.environ["XDG_RUNTIME_DIR"] = str(path)

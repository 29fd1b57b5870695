"""All processes of a bus: started, monitored and ended together."""

import contextlib
import os
import time
from pathlib import Path
from tempfile import TemporaryFile
from typing import Final

import msgspec

from rfms_can.bus.driver import open_port
from rfms_can.master.settings import CLOCKS
from rfms_can.rig.child import Child, Stop
from rfms_can.rig.idle import run_idle
from rfms_can.rig.processes import OTHERS, check_bus, check_no_master, start_hub, start_node
from rfms_can.rig.program import load_program
from rfms_can.rig.record import LOG, Record
from rfms_can.rig.recorder import Recorder
from rfms_can.rig.result import RunResult
from rfms_can.rig.runner import execute
from rfms_can.rig.session import Program
from rfms_can.rig.settings import RunSettings
from rfms_can.wire.contract import Wire
from rfms_can.wire.emergency import in_words
from rfms_can.wire.nodes import HEARTBEAT_EVERY, MASTER, NODE_NAMES
from rfms_can.wire.protection import Refusal
from rfms_can.wire.records import Emcy, Heartbeat
from rfms_can.wire.vocabulary import NodeState

NODES: Final = (MASTER, *OTHERS)
SILENT: Final = "SILENT"
MISSED_BEATS: Final = 3
"""Heartbeats in a row that a node may miss before its last one is no news of it."""


class Health(msgspec.Struct):
    """Health of a node.

    Attributes:
        node: its name.
        pid: its process; 0 if it was not started here.
        alive: whether the process runs.
        exit_code: of a process that has ended; None while it runs.
        state: by its last heartbeat; empty before the first, SILENT where it should have told
            another one since.
        error_register, discarded: by its last heartbeat.
        silent_s: time since its last heartbeat, s; None before the first.
        emergency: its last emergency message.
    """

    node: str
    pid: int = 0
    alive: bool = True
    exit_code: int | None = None
    state: str = ""
    error_register: int = 0
    discarded: int = 0
    silent_s: float | None = None
    emergency: str = ""


class Fleet:
    """Hub, recorder, eight nodes and the master as processes; this process monitors them.

    Args:
        settings: of the run.
        program: of the master; None to wait with the brakes on.
        record: directory to record into, or None; without a program only the log.
        elsewhere: numbers of nodes that are started elsewhere.

    Raises:
        BusError: the bus does not exist, or another master drives it.
    """

    def __init__(
        self,
        settings: RunSettings,
        program: Path | None,
        record: Path | None,
        elsewhere: frozenset[int],
    ) -> None:
        self._wire = Wire()
        self._settings = settings
        self.health = {n: Health(NODE_NAMES[n]) for n in NODES}
        self.children: dict[int, Child] = {}
        self._helpers: list[Child] = []
        self._heard: dict[int, float] = {}
        self._record = record
        self._result = TemporaryFile()  # noqa: SIM115  # shared with the master's process
        loaded = None if program is None else load_program(program)
        try:
            hub = start_hub(settings)
            self._helpers += [] if hub is None else [hub]
            check_bus(settings)
            if hub is None and MASTER not in elsewhere:
                check_no_master(settings)
            self._listen()  # first: nodes announce themselves once, and again only if asked
            if record is not None and loaded is None:  # a program's master records by itself
                Record(record)
                self._helpers.insert(0, Recorder(record / LOG, settings))
            for node in OTHERS:
                if node not in elsewhere:
                    self.children[node] = start_node(node, settings, self._wire)
            if MASTER not in elsewhere:
                self.children[MASTER] = self._start_master(loaded)
            for node, child in self.children.items():
                self.health[node].pid = child.pid
        except BaseException:
            self.close()
            raise

    def _start_master(self, program: Program | None) -> Child:
        settings, record = self._settings, self._record

        def body(stop: Stop) -> None:
            if program is None:
                run_idle(settings, stop)
                return
            with contextlib.suppress(KeyboardInterrupt):  # stopped by a signal: the arm is braked
                outcome = execute(program, settings, record=record, attach=True, interrupted=stop)
                os.write(self._result.fileno(), msgspec.json.encode(outcome.result))
                if outcome.fault is not None:
                    raise outcome.fault

        return Child("master", body, quiet=True)

    def _listen(self) -> None:
        wire = self._wire
        self._beats = {wire.id(Heartbeat, n): (n, wire.receiver(Heartbeat, n)) for n in NODES}
        self._emergencies = {wire.id(Emcy, n): (n, wire.receiver(Emcy, n)) for n in NODES}
        accepts = frozenset((*self._beats, *self._emergencies))
        self._port = open_port(self._settings.bus, accepts, client="rfms up")

    def watch(self, seconds: float) -> None:
        """Listen for a while and update ``health``."""
        until = time.monotonic() + seconds
        while (left := until - time.monotonic()) > 0.0:
            frame = self._port.recv(left)
            if frame is None:
                continue
            if frame.id in self._beats:
                node, beats = self._beats[frame.id]
                beat = beats.decoder.decode(frame)
                if not isinstance(beat, Refusal):
                    self._heard[node] = time.monotonic()
                    health = self.health[node]
                    health.state = NodeState(beat.state).name
                    health.error_register = beat.error_register
                    health.discarded = beat.discarded
            else:
                node, emergencies = self._emergencies[frame.id]
                emergency = emergencies.decoder.decode(frame)
                if not isinstance(emergency, Refusal):
                    self.health[node].emergency = in_words(self._wire, node, emergency)
        now, limit_s = time.monotonic(), self._silence_s
        for node, health in self.health.items():
            health.silent_s = now - self._heard[node] if node in self._heard else None
            if health.silent_s is not None and health.silent_s > limit_s:
                health.state = SILENT
            if node in self.children:
                health.alive = self.children[node].alive
                health.exit_code = self.children[node].exit_code

    @property
    def _silence_s(self) -> float:
        """Silence, s, after which a node's last heartbeat tells nothing of it any more.

        Heartbeats come with SYNC: where the master has ended, none will.
        """
        settings, master = self._settings, self.children.get(MASTER)
        beats_s = MISSED_BEATS * HEARTBEAT_EVERY / settings.rate
        if master is not None and not master.alive:
            return beats_s
        waits = CLOCKS[settings.the_clock].waits_for_nodes  # and for programs, in between
        return beats_s + (settings.barrier if waits else 0.0)

    def dead(self) -> list[Child]:
        """Processes that have ended, the hub included."""
        return [c for c in (*self._helpers, *self.children.values()) if not c.alive]

    @property
    def result(self) -> RunResult | None:
        """The numbers of the program's run, once it is over; None where it was not finished."""
        self._result.seek(0)
        told = self._result.read()
        return msgspec.json.decode(told, type=RunResult) if told else None

    def close(self) -> None:
        """End everything: the master first, so that it can brake the arm; then nodes, then bus."""
        master = self.children.get(MASTER)
        if master is not None:
            master.signal()
            master.join()
        for group in ([c for n, c in self.children.items() if n != MASTER], self._helpers):
            for child in group:
                child.signal()
            for child in group:
                child.join()
        if hasattr(self, "_port"):
            self._port.close()

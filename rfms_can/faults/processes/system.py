"""A real system that moves: ``rfms hub`` and ``rfms up`` with a program; a stranger listens."""

import json
import os
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import msgspec

from rfms_can.arm import arm_by_name
from rfms_can.bus.hub.address import live_hubs
from rfms_can.bus.url import HUB, parse_bus_url
from rfms_can.errors import RfmsError
from rfms_can.faults.processes.command import SEAM_SIGNAL, Command, Main, processes_of, runs
from rfms_can.faults.processes.joints import Joints
from rfms_can.faults.processes.tape import Tape
from rfms_can.rig.record import LOG
from rfms_can.rig.result import RunResult
from rfms_can.wire.nodes import MASTER, NODE_NAMES
from rfms_can.wire.records import Measure, Sync
from rfms_can.wire.vocabulary import NodeState

RATE_HZ: Final = 250.0
PERIOD_S: Final = 1.0 / RATE_HZ
BARRIER_S: Final = {True: 0.2, False: 0.5}
"""Longest lockstep cycle on a hub, and on a CAN interface (there is one processor for all there).

A busy machine must not miss it; what fails is found in cycles of this length.
"""
BEGIN_S: Final = 120.0
"""How long a system may take until it moves."""
END_S: Final = 90.0
"""How long its program may take to its end."""
SLOWEST: Final = 0.3
"""Of all joints, over their limits, at which a fault may be put in: as on the simulated bus."""
STARTS: Final = 100
"""Cycles of the enabled arm that are not looked at: it begins to move."""
RECENT: Final = 40
"""Frames that are decoded to know how fast the joints are now: two control cycles or more."""
_PROGRAM: Final = "strokes.py"
_RECORD: Final = "record"


class NotReadyError(RfmsError):
    """No fault could be put in: the system, or the machine, was not ready for it."""


class System:
    """Processes on a bus, whose arm moves. Nothing of it outlives this object's ``close``.

    Args:
        main: the command line.
        bus: URL of the bus; a hub is started, and ended with the system.
        arm: name of the arm.
        directory: of the program, the record and what the commands print.
        joint: number of the joint that is to be at fault.
        seam: what ``SEAM_SIGNAL`` does to a process of the system.
        strokes: of its program.
        recorded: whether the run is recorded.

    Attributes:
        bus, arm, joint: as given.
        tape: what the stranger hears.
        joints: by the tape, up to where the fault is put in.
        up: the command that started the nodes.
        hub: the hub; None on a CAN interface.
        joined: the command that a fault has added, or None.
        barrier_s: longest cycle, s.
        cycles: of the enabled arm, up to where the fault is put in.
        back_ns: when a process was let go on, or started again; None if none was.

    Raises:
        RfmsError: it does not come up; the message has the last words of the command.
    """

    def __init__(
        self,
        main: Main,
        bus: str,
        arm: str,
        directory: Path,
        joint: int,
        seam: Callable[[], None] | None = None,
        *,
        strokes: int,
        recorded: bool = False,
    ) -> None:
        url = parse_bus_url(bus)
        self.bus, self.arm, self.joint = bus, arm, joint
        self.on_hub = url.interface == HUB
        self.interface = url.channel
        self.barrier_s = BARRIER_S[self.on_hub]
        self.hub: Command | None = None
        self.joined: Command | None = None
        self._main, self._directory = main, directory
        self._pids: dict[str, int] = {}
        self._commands: list[Command] = []
        self._taken = 0
        self.cycles = 0
        self.back_ns: int | None = None
        self.joints = Joints(arm_by_name(arm), PERIOD_S)
        try:
            if self.on_hub:
                self.hub = self._run("hub", url.channel)
                self._wait(lambda: url.channel in live_hubs(), self.hub)
            self.tape = Tape(bus)
            self.up = self._run(*self._words(strokes, recorded), seam=seam)
        except BaseException:
            self.close()
            raise

    def _words(self, strokes: int, recorded: bool) -> list[str]:
        program = self._directory / _PROGRAM
        program.write_text(
            f"from rfms_can.faults.processes.strokes import program_of\n\n"
            f"program = program_of({self.arm!r}, {strokes})\n"
        )
        record = ["--record", str(self._directory / _RECORD)] if recorded else []
        common = ["--arm", self.arm, *self._of_a_node(), "--keep-going", "--json"]
        return ["up", str(program), *common, *record]

    def _of_a_node(self) -> list[str]:
        return ["--bus", self.bus, "--barrier", f"{self.barrier_s:g}"]

    def _run(self, *words: str, seam: Callable[[], None] | None = None) -> Command:
        command = Command(self._main, words, self._directory, seam)
        self._commands.append(command)
        return command

    def _wait(self, condition: Callable[[], bool], command: Command) -> None:
        until = time.monotonic() + BEGIN_S
        while not condition():
            if time.monotonic() > until or not command.alive:
                raise RfmsError(f"the system did not come up: {command.complaint or 'no word'}")
            time.sleep(0.01)

    # --- before the fault ---------------------------------------------------------------------

    def run_to(self, cycle: int) -> None:
        """Wait until the arm has moved for so many cycles, and all joints are fast.

        Raises:
            NotReadyError: it does not, or was not seen while it did.
        """

        def there() -> bool:
            self._look()
            moves = self.cycles >= STARTS + cycle and self.joints.slowest >= SLOWEST
            return moves and self.tape.caught_up  # else it is the past that moves

        until = time.monotonic() + BEGIN_S
        while not self.tape.listen(1.0, there):
            runs_on = self.up.alive and self._master_runs
            if time.monotonic() > until or not runs_on:
                what = f"runs, after {BEGIN_S:g} s" if runs_on else "has ended"
                last = self.up.err.read_text(errors="replace").strip() or "no complaint"
                raise NotReadyError(
                    f"the arm was not seen moving: its master {what}, {self.cycles} cycles "
                    f"heard: {' '.join(last.split())}"
                )

    @property
    def _master_runs(self) -> bool:
        """Whether the master runs; it may not have begun yet."""
        told = b"\n" in self.up.out.read_bytes() if self.up.out.exists() else False
        return not told or runs(self.pid(MASTER))

    def _look(self) -> None:
        """Take in the last of what was heard since the last look."""
        start, self._taken = self._taken, len(self.tape.frames)
        recent = max(start, self._taken - RECENT)
        for _, node, values in self.tape.heard(recent, self._taken):
            if isinstance(values, Measure):
                self.joints.take(node - 1, values)
            elif isinstance(values, Sync) and values.state == NodeState.OPERATIONAL:
                self.cycles = values.cycle

    # --- for injectors ------------------------------------------------------------------------

    def pid(self, node: int) -> int:
        """Process id of a node, as ``rfms up --json`` tells it."""
        if not self._pids:
            with self.up.out.open() as out:
                health: list[dict[str, Any]] = json.loads(out.readline())
            self._pids = {one["node"]: one["pid"] for one in health}
        return self._pids[NODE_NAMES[node]]

    def signal(self, node: int, number: signal.Signals) -> None:
        """Send a signal to the process of a node."""
        os.kill(self.pid(node), number)

    def signal_all(self) -> None:
        """Send ``SEAM_SIGNAL`` to all processes of ``rfms up``."""
        for pid in processes_of(self.up.pid):
            os.kill(pid, SEAM_SIGNAL)

    @property
    def running(self) -> bool:
        """Whether any process of ``rfms up`` is there."""
        return bool(self.up.alive or processes_of(self.up.pid))

    def comes_back(self) -> None:
        """A process goes on, or is started again, now."""
        self.back_ns = time.monotonic_ns()

    def wait_cycles(self, cycles: float) -> None:
        """Listen for so many of the longest cycles."""
        self.tape.listen(cycles * self.barrier_s)

    def start(self, *words: str) -> None:
        """Start another command on the same bus."""
        self.joined = self._run(*words, *self._of_a_node())

    @property
    def log(self) -> Path:
        """Log of the run, where it is recorded."""
        return self._directory / _RECORD / LOG

    # --- after it -----------------------------------------------------------------------------

    def finish(self) -> list[int]:
        """End all commands as Ctrl-C does; process ids of what they left behind."""
        left: list[int] = []
        for command in reversed(self._commands):
            left += command.end()
        return left

    @property
    def result(self) -> RunResult | None:
        """The numbers of the run; None where its master did not live to tell them."""
        lines = self.up.out.read_text().splitlines() if self.up.out.exists() else []
        if not lines or not lines[-1].startswith("{"):
            return None
        values = json.loads(lines[-1])
        values.pop("cycles_per_s", None)
        return msgspec.convert(values, type=RunResult)

    def close(self) -> None:
        """Kill what still runs."""
        for command in self._commands:
            command.kill()
        tape = getattr(self, "tape", None)
        if tape is not None:
            tape.close()

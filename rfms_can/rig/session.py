"""One run: bring the bus up, enable, let a program move the arm, disable; collect the numbers.

If a program ends by its own error or by a fault of the bus, the arm is brought to rest and braked
before the error is passed on to the caller.
"""

import time
from array import array
from collections.abc import Callable
from typing import Protocol

from rfms_can.coordinator import Arm
from rfms_can.coordinator.moves import Moves
from rfms_can.coordinator.program_link import ProgramLink
from rfms_can.coordinator.stopping import finish, stopped
from rfms_can.errors import FaultError
from rfms_can.master.node import MasterNode
from rfms_can.master.phases import Phase
from rfms_can.master.report import holds
from rfms_can.messages import StopRequest
from rfms_can.rig.link import DirectLink
from rfms_can.rig.realtime import ThreadedPump
from rfms_can.rig.result import RunResult, discarded_frames, joint_results, troubled_ports
from rfms_can.rig.truth import SceneResult

Program = Callable[[Arm], None]
Progress = Callable[["Session"], None]

HALT_CYCLES = 125
"""Cycles a halted arm is given to come to rest before it is braked."""
SILENT_CYCLES = 5
"""Cycles without answers after which the nodes are not waited for any more."""
PROGRESS_EVERY = 50
"""Cycles between two progress reports."""


class Rig(Protocol):
    """The nodes and their bus, as a session needs them."""

    master: MasterNode

    def pump(self, condition: Callable[[], bool]) -> None:
        """Run until a condition holds; it is evaluated after every event."""

    def begin_measuring(self) -> None:
        """Start counting bus statistics."""

    @property
    def load(self) -> float | None:
        """Fraction of the time the bus was busy, if it can be measured."""

    @property
    def scene(self) -> SceneResult | None:
        """Contact with the scene, if the plant is in this process."""

    @property
    def frames(self) -> int:
        """Frames on the bus, as far as this end sees them."""

    def close(self) -> None:
        """End processes and close ports."""


class Session:
    """Runs programs on a rig.

    Args:
        rig: the nodes and their bus.
        bus_bound: worst-case load of a cycle, for the result.
        progress: called every ``PROGRESS_EVERY`` cycles.
        keep: keep the commanded trajectory for plots.
        each_cycle: called once for every closed cycle.
        threaded: whether in real time the bus has a thread of its own, beside the program's.
        interrupted: whether the program is to end.
        program_runs: told where a signal may raise at once; see ``ProgramLink``.

    Attributes:
        link: the program's link to the master.
        commanded: six joint angles a cycle, rad, if kept: those sent, in double precision.
        unrecorded: what of the record is missing, for the result.
    """

    def __init__(
        self,
        rig: Rig,
        *,
        bus_bound: float | None = None,
        progress: Progress | None = None,
        keep: bool = False,
        each_cycle: Callable[[], None] | None = None,
        threaded: bool = True,
        interrupted: Callable[[], bool] = lambda: False,
        program_runs: Callable[[bool], None] = lambda _: None,
    ) -> None:
        self.rig = rig
        self.master = rig.master
        waits = rig.master.settings.clock_definition.waits_for_programs
        self._thread = ThreadedPump(rig.pump) if threaded and not waits else None
        self._interrupted, self._program_runs = interrupted, program_runs
        self._program: ProgramLink | None = None
        self.link = DirectLink(rig.master, self._thread or rig.pump, self._on_cycle, self._ends)
        self.commanded: array[float] = array("d")
        self.unrecorded: list[str] = []
        self._bus_bound = bus_bound
        self._progress = progress
        self._keep = keep
        self._each_cycle = each_cycle
        self._enabled_at = self._wall_s = 0.0
        self._error: str | None = None

    def _on_cycle(self) -> None:
        master = self.master
        if self._keep and self.link.running:
            self.commanded.extend(master.motion.commanded.theta)
        if self._each_cycle is not None:
            self._each_cycle()
        if self._progress is not None and master.closed % PROGRESS_EVERY == 0:
            self._progress(self)

    def run(self, program: Program) -> RunResult:
        """Bring up, enable, run the program, bring to rest, disable.

        Raises:
            FaultError: a latched fault halted the run.
            ProgramError: the program asked for something impossible.
            KeyboardInterrupt: the program was interrupted; the arm is at rest and braked.
        """
        try:
            self.bring_up()
            moves = Moves()
            self._run(program, moves)
            finish(self.link, moves)
        except FaultError:
            self.coast(HALT_CYCLES)
            raise
        except BaseException as error:
            self._error = f"{type(error).__name__}: {error}".removesuffix(": ")
            self.stop_moving()
            raise
        finally:
            self.disable()
        return self.result()

    def _run(self, program: Program, moves: Moves) -> None:
        self._program = ProgramLink(
            self.link, interrupted=self._interrupted, program_runs=self._program_runs
        )
        with self._program as link:
            program(Arm(link, moves))

    def _ends(self) -> bool:
        """Whether a wait is to be cut short: interrupted, or a thread's at the program's end."""
        return self._interrupted() or (self._program is not None and self._program.ending)

    def bring_up(self) -> None:
        """From power-up to an enabled arm: roll call, configuration, homing, start."""
        master = self.master
        self.link.run_until(lambda: master.phase is Phase.READY)
        master.start()
        self.link.run_until(lambda: master.phase is Phase.RUN)
        self.rig.begin_measuring()
        self._enabled_at = time.perf_counter()

    def stop_moving(self) -> None:
        """Controlled stop along the path, before the arm is braked; waits until it is at rest.

        An arm that never comes to rest, because its servos oscillate, is braked after a timeout.
        """
        if self.link.running:
            self.link.request(StopRequest())
            master, ends = self.master, stopped(self.link.status())
            self.link.pass_time(
                lambda: master.fault is not None or any(holds(master, end) for end in ends)
            )

    def coast(self, cycles: int) -> None:
        """Let a halted arm come to rest; gives up early on a bus that does not answer."""
        master, statistics = self.master, self.master.statistics
        until, silent = master.closed + cycles, statistics.incomplete + SILENT_CYCLES
        if master.next_deadline_ns() is not None:
            self.link.pass_time(lambda: master.closed >= until or statistics.incomplete >= silent)

    def disable(self) -> None:
        """Torque off and brakes on, for good."""
        if self._enabled_at and not self._wall_s:
            self._wall_s = time.perf_counter() - self._enabled_at
        master = self.master
        master.stop()
        if master.next_deadline_ns() is not None:
            self.link.pass_time(lambda: master.ended)

    def close(self) -> None:
        """End the bus' thread, where there is one."""
        if self._thread is not None:
            self._thread.close()

    def result(self) -> RunResult:
        """The numbers so far."""
        master, statistics = self.master, self.master.statistics
        bus_offs, overflows = troubled_ports(master)
        return RunResult(
            fault=master.fault,
            error=self._error,
            cycles=statistics.cycles,
            incomplete=statistics.incomplete,
            missing=dict(statistics.missing),
            joints=joint_results(master.arm, statistics),
            frames=self.rig.frames,
            bus_load=self.rig.load,
            bus_bound=self._bus_bound,
            discarded=discarded_frames(master),
            foreign=master.foreign,
            lost=master.lost,
            lateness=list(statistics.lateness),
            wall_s=self._wall_s,
            scene=self.rig.scene,
            reported=list(master.rows.reported),
            reset_faults=list(master.machine.reset_faults),
            unrecorded=list(self.unrecorded),
            bus_offs=bus_offs,
            overflows=overflows,
            culprit=master.culprit,
        )

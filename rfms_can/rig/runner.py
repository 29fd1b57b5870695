"""One run from settings to result: makes the rig, runs the program, writes the record."""

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final, NamedTuple, Protocol

from rfms_can.bus.budget import Cycle, budget
from rfms_can.bus.timing import BusTiming
from rfms_can.errors import FaultError, RfmsError
from rfms_can.rig.candump import CandumpWriter
from rfms_can.rig.processes import OTHERS, Front, ProcessRig, as_made
from rfms_can.rig.record import LOG, Record
from rfms_can.rig.result import RunResult
from rfms_can.rig.session import Program, Progress, Rig, Session
from rfms_can.rig.settings import RunSettings, SettingsError
from rfms_can.rig.simulated import SimulatedRig

COMPLIES: Final = ["COMPLY", "BIAS"]
"""Frames of a cycle in which the arm complies."""


class Log(Protocol):
    """What writes the frames of a run."""

    @property
    def cut(self) -> str:
        """Why it is not whole, once it is closed; empty if it is."""

    def close(self) -> None:
        """Finish it; again without effect."""


class Outcome(NamedTuple):
    """How a run ended.

    Attributes:
        result: its numbers.
        fault: the latched fault that halted it, or None.
    """

    result: RunResult
    fault: FaultError | None


def execute(
    program: Program,
    settings: RunSettings,
    *,
    record: Path | None = None,
    progress: Progress | None = None,
    attach: bool = False,
    watch: Callable[[Rig], None] | None = None,
    interrupted: Callable[[], bool] = lambda: False,
    program_runs: Callable[[bool], None] = lambda _: None,
    terms: bool = False,
    front: Front = as_made,
) -> Outcome:
    """Run a program.

    Args:
        program: called with the arm once it is enabled.
        settings: of the run.
        record: directory to record into, or None.
        progress: called now and then while it runs.
        attach: the other nodes are on the bus already: start none.
        watch: called with the rig before the run, in this process, not the nodes'.
        interrupted: whether the program is to end; called while it waits.
        program_runs: told where a signal may raise at once; see ``ProgramLink``.
        terms: record the terms of the joints' torques as well.
        front: what stands in front of each node where nodes are processes.

    Raises:
        SettingsError: the simulated bus is too slow for the rate, or terms cannot be recorded.
        RfmsError: whatever ended the run other than a latched fault; the arm is braked.
        KeyboardInterrupt: ``interrupted`` returned True; the arm is braked.
    """
    if terms and (record is None or not settings.simulated):
        raise SettingsError(
            f"--terms needs --record DIRECTORY and bus 'sim', whose joints are in this process; "
            f"bus {settings.bus}, {'no directory' if record is None else f'directory {record}'}"
        )
    run_record = None if record is None else Record(record)
    rig, log = make_rig(settings, run_record, attach, front)
    try:
        if terms and isinstance(rig, SimulatedRig):
            rig.record_terms()
        if watch is not None:
            watch(rig)
        session = Session(
            rig,
            bus_bound=checked_bus_bound(settings),
            progress=progress,
            keep=run_record is not None,
            interrupted=interrupted,
            program_runs=program_runs,
        )
        return _run(session, program, settings, run_record, log)
    finally:
        rig.close()
        if log is not None:
            log.close()


def _run(
    session: Session,
    program: Program,
    settings: RunSettings,
    run_record: Record | None,
    log: Log | None,
) -> Outcome:
    """Run and complete the record, even after an error."""
    fault: FaultError | None = None
    try:
        session.run(program)
    except FaultError as error:
        fault = error
    finally:
        session.close()
        complete_record(session, settings, run_record, log)
    return Outcome(session.result(), fault)


def complete_record(
    session: Session, settings: RunSettings, run_record: Record | None, log: Log | None
) -> None:
    """Complete the record of a run, if there is one.

    A disk that is full takes the record and nothing else: the result says what is missing.
    """
    missing = session.unrecorded
    if log is not None:
        log.close()
        if log.cut:
            missing.append(f"{LOG} is cut: {log.cut}")
    if run_record is None:
        return
    for write in _writes(session, settings, run_record):
        try:
            write()
        except RfmsError as error:
            missing.append(str(error))


def _writes(
    session: Session, settings: RunSettings, record: Record
) -> Iterator[Callable[[], None]]:
    """What writes the files beside the log; the summary last, with what is missing."""
    master, rig = session.master, session.rig
    yield lambda: record.settings(settings, master.arm, master.arm_state.zero_counts)
    yield lambda: record.commanded(session.commanded)
    if isinstance(rig, SimulatedRig):
        watch, terms = rig.watch, rig.terms
        if watch is not None:
            yield lambda: record.truth(watch.rows)
        if terms is not None:
            yield lambda: record.terms(terms)
    yield lambda: record.summary(session.result())


def make_rig(
    settings: RunSettings, run_record: Record | None, attach: bool, front: Front = as_made
) -> tuple[Rig, Log | None]:
    """The nodes on the bus of the settings, and the log of the frames, if there is one."""
    if not settings.simulated:
        elsewhere = frozenset(OTHERS) if attach else frozenset()
        kept = None if run_record is None else run_record.log
        processes = ProcessRig(settings, kept, elsewhere, front)
        return processes, processes.recorder
    rig = SimulatedRig(settings)
    if run_record is None:
        return rig, None
    if rig.watch is not None:
        rig.watch.keep_every_cycle()
    writer = CandumpWriter(run_record.log, "sim0")
    rig.observe(writer.write)
    return rig, writer


def checked_bus_bound(settings: RunSettings) -> float:
    """The bound of the bus load; refused above 100 % on the simulated bus."""
    bound = bus_bound(settings)
    if settings.simulated and bound > 1.0:
        raise SettingsError(
            f"rate {settings.rate:g} Hz: a cycle's frames take {100 * bound:.0f} % of the bus at "
            f"{settings.bit_rate}/{settings.data_bit_rate} bit/s, which carries "
            f"{math.floor(settings.rate / bound)} Hz: lower the rate, or raise data_bit_rate in "
            f"the config file"
        )
    return bound


def bus_bound(settings: RunSettings) -> float:
    """Worst-case load of a cycle of such a run: the usual frames; FORCE with a sensor; COMPLY and
    BIAS with a tool in the hand, since the arm may then comply in every cycle."""
    timing = BusTiming(settings.bit_rate, settings.data_bit_rate)
    more = ["FORCE"] * settings.master().sensor + COMPLIES * (settings.the_scene.tool is not None)
    return budget(settings.rate, timing, cycle=Cycle.USUAL, occasional=more).load

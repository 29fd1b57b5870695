"""One run from settings to result: makes the rig, runs the program, writes the record."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Final, NamedTuple

from rfms_can.bus.budget import Cycle, budget
from rfms_can.bus.timing import BusTiming
from rfms_can.errors import FaultError
from rfms_can.rig.candump import CandumpWriter
from rfms_can.rig.processes import OTHERS, Front, ProcessRig, as_made
from rfms_can.rig.record import Record
from rfms_can.rig.result import RunResult
from rfms_can.rig.session import Program, Progress, Rig, Session
from rfms_can.rig.settings import RunSettings, SettingsError
from rfms_can.rig.simulated import SimulatedRig

COMPLIES: Final = ["COMPLY", "BIAS"]
"""Frames of a cycle in which the arm complies."""


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
    rig, writer = make_rig(settings, run_record, attach, front)
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
        return _run(session, program, settings, run_record)
    finally:
        rig.close()
        if writer is not None:
            writer.close()


def _run(
    session: Session, program: Program, settings: RunSettings, run_record: Record | None
) -> Outcome:
    """Run and complete the record, even after an error."""
    fault: FaultError | None = None
    try:
        session.run(program)
    except FaultError as error:
        fault = error
    finally:
        session.close()
        complete_record(session, settings, run_record)
    return Outcome(session.result(), fault)


def complete_record(session: Session, settings: RunSettings, run_record: Record | None) -> None:
    """Complete the record of a run, if there is one."""
    if run_record is not None:
        master = session.master
        run_record.settings(settings, master.arm, master.arm_state.zero_counts)
        run_record.commanded(session.commanded)
        if isinstance(session.rig, SimulatedRig):
            if session.rig.watch is not None:
                run_record.truth(session.rig.watch.rows)
            if session.rig.terms is not None:
                run_record.terms(session.rig.terms)
        run_record.summary(session.result())


def make_rig(
    settings: RunSettings, run_record: Record | None, attach: bool, front: Front = as_made
) -> tuple[Rig, CandumpWriter | None]:
    """The nodes on the bus of the settings, and the log writer where no process records."""
    if not settings.simulated:
        elsewhere = frozenset(OTHERS) if attach else frozenset()
        log = None if run_record is None else run_record.log
        return ProcessRig(settings, log, elsewhere, front), None
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

"""One peg, one hole: run the program on the simulated bus and judge it by the plant's truth."""

import contextlib
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from rfms_can.analysis.campaign.job import Insertion, Job
from rfms_can.analysis.peg_figures import INSERTED, peg_figures
from rfms_can.errors import ProgramError, RfmsError
from rfms_can.rig.program import load_program
from rfms_can.rig.runner import execute
from rfms_can.rig.session import Rig
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.rig.truth import Truth

SETTLED: Final = 25
"""Cycles for which it is still watched then."""


def insert(job: Job, program: Path) -> Insertion:
    """Run one job.

    Args:
        job: the job.
        program: the program's file.

    Raises:
        RfmsError: the program cannot be loaded.
    """
    settings = job.settings
    watched: list[SimulatedRig] = []

    def watch(rig: Rig) -> None:
        assert isinstance(rig, SimulatedRig) and rig.watch is not None
        rig.watch.keep_every_cycle()
        watched.append(rig)

    def is_in() -> bool:
        """Whether the peg is inserted; the program is then interrupted."""
        rows = watched[0].watch.rows if watched and watched[0].watch else []
        return len(rows) > SETTLED and -rows[-SETTLED].tip.pz >= INSERTED

    why = ""
    run = load_program(program)
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            outcome = execute(run, settings, watch=watch, interrupted=is_in)
        if outcome.fault is not None:
            why = str(outcome.fault)
    except KeyboardInterrupt:
        pass  # it is in
    except RfmsError as error:
        why = _reason(error)
    (rig,) = watched
    assert rig.watch is not None
    return _judged(job, rig.watch.rows, 1.0 / settings.rate, why)


def _reason(error: RfmsError) -> str:
    """What the program said, without the place in its file."""
    said = error.__cause__
    return str(said if isinstance(said, ProgramError) else error)


def _judged(job: Job, rows: Sequence[Truth], period_s: float, why: str) -> Insertion:
    """Forces until the peg is in."""
    figures = peg_figures(rows)
    inserted = figures.depth >= INSERTED and not why
    if not inserted and not why:
        why = f"stopped {1e3 * figures.depth:.1f} mm deep"
    return Insertion(
        *job.group,
        seed=job.seed,
        inserted=inserted,
        why=why,
        depth=figures.depth,
        lateral_peak=figures.lateral_peak,
        lateral_mean=figures.lateral_mean,
        axial_peak=figures.axial_peak,
        seconds=figures.cycles * period_s,
    )

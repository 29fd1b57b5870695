"""Many trials: which there are, made on the engine of campaigns, summed up row by row."""

import os
from collections.abc import Generator, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec

from rfms_can.bus.url import HUB
from rfms_can.engine import Backend, Kept, carry_out, run
from rfms_can.errors import RfmsError
from rfms_can.faults.processes.command import Main
from rfms_can.faults.processes.trial import made
from rfms_can.faults.results import Conditions, trial_of
from rfms_can.faults.table import ROWS, Variant, Where, variant_of, variants
from rfms_can.faults.trial import Result, Trial, groups, made_of

CHUNK = 12
"""Trials that a process makes of one warm system before it hands their results over."""


class Line(msgspec.Struct, frozen=True):
    """A variant on one arm, summed up.

    Attributes:
        row, variant, arm: which.
        seeds: trials made.
        met: whether all of them met the row; False without one.
        bound: cycles until the fault has to be found.
        worst: largest number of cycles until it was found; None if it was not, once or always.
        reaction: what came of it, in the words of the table; several where seeds differ.
        culprit_ok: whether the right one was named in all.
        reenabled: whether anything was enabled again in any.
        replay: trial that was not met, as ``rfms faults --replay`` takes it; None if all were.
        why: what that one did not meet.
    """

    row: int
    variant: str
    arm: str
    seeds: int
    met: bool
    bound: float
    worst: float | None
    reaction: str
    culprit_ok: bool
    reenabled: bool
    replay: str | None = None
    why: list[str] = []


def rows_from(text: str) -> list[int]:
    """Numbers of rows of words like ``1,4-7``; all of them if it is empty.

    Raises:
        RfmsError: it is not such a list, or a row does not exist.
    """
    if not text:
        return list(ROWS)
    numbers: list[int] = []
    for word in text.split(","):
        first, dash, last = word.strip().partition("-")
        if not (first.isdecimal() and (last.isdecimal() or not dash)):
            raise RfmsError(f"rows {text!r}: give numbers and ranges, as in 1,4-7")
        numbers += range(int(first), int(last or first) + 1)
    unknown = [number for number in numbers if number not in ROWS]
    if unknown:
        raise RfmsError(f"row {unknown[0]} does not exist: there are 1 to {max(ROWS)}")
    return numbers


def trial_from(text: str, arm: str, where: Where) -> Trial:
    """The trial of ``ROW:VARIANT:SEED`` on a system.

    Raises:
        RfmsError: there is none such.
    """
    row, _, rest = text.partition(":")
    name, _, seed = rest.rpartition(":")
    if not (row.isdecimal() and seed.isdecimal() and name):
        raise RfmsError(f"{text!r}: give ROW:VARIANT:SEED, as in 1:lose_dac:0")
    (number,) = rows_from(row)
    variant = variant_of(number, name)
    if variant is None:
        names = ", ".join(variant.name for variant in ROWS[number].variants)
        raise RfmsError(f"row {number} has no variant {name!r}; there are: {names}")
    if variant.where is not where:
        raise RfmsError(f"row {number}, {name}: it needs {variant.where.value}; give another --bus")
    return Trial(number, name, arm, int(seed))


def trials_of(
    rows: Iterable[int], arms: Sequence[str], seeds: int, where: Where = Where.SIM
) -> list[Trial]:
    """All trials of some rows, seed by seed, so that what there is can be looked at early."""
    wanted = set(rows)
    return [
        Trial(row, variant.name, arm, seed)
        for seed in range(seeds)
        for arm in arms
        for row, variant in variants()
        if row in wanted and variant.where is where
    ]


@dataclass(frozen=True)
class Processes:
    """Makes trials of processes, one at a time in each worker.

    Attributes:
        bus: URL of a CAN interface; empty for a hub of its own for each trial.
        main: the command line.
    """

    bus: str
    main: Main

    def make(self, trial: Trial, keep: Path | None = None) -> Result:
        """The result of a trial; see ``made``."""
        return made(trial, self.bus or f"{HUB}:faults-{os.getpid()}", self.main, keep)


def run_all(
    trials: Sequence[Trial],
    kept: Kept[Conditions, Result],
    backend: Backend,
    processes: Processes | None = None,
) -> list[Result]:
    """Make the trials that have not been made yet; the results of all, in their order.

    Args:
        trials: all of them.
        kept: results of earlier calls.
        backend: of the engine.
        processes: where trials of processes are made; None for those on the simulated bus.

    Raises:
        EngineError: as ``rfms_can.engine.run`` does.
    """
    return carry_out(
        trials,
        lambda left: (
            _made(left, backend)
            if processes is None
            else run(processes.make, left, backend, name=lambda trial: trial.words)
        ),
        kept,
        what="faults",
        job_key=lambda trial: trial,
        result_key=trial_of,
    )


def _made(trials: Sequence[Trial], backend: Backend) -> Generator[Result, None, None]:
    chunks = [
        group[start : start + CHUNK]
        for group in groups(trials)
        for start in range(0, len(group), CHUNK)
    ]
    for some in run(_chunk, chunks, backend, name=_name):
        yield from some


def _name(trials: list[Trial]) -> str:
    return f"{trials[0].arm} {trials[0].words} and {len(trials) - 1} more"


def _chunk(trials: list[Trial]) -> list[Result]:
    return list(made_of(trials))


def lines_of(
    rows: Iterable[int],
    arms: Sequence[str],
    results: Iterable[Result],
    where: Where = Where.SIM,
) -> list[Line]:
    """A line for each variant of some rows on each arm, in the order of the table."""
    by_variant: dict[tuple[int, str, str], list[Result]] = {}
    for result in results:
        by_variant.setdefault((result.row, result.variant, result.arm), []).append(result)
    wanted = set(rows)
    return [
        _line(row, variant, arm, by_variant.get((row, variant.name, arm), []))
        for row, variant in variants()
        if row in wanted and variant.where is where
        for arm in arms
    ]


def _line(row: int, variant: Variant, arm: str, results: list[Result]) -> Line:
    results = sorted(results, key=lambda result: result.seed)
    found = [result.found for result in results]
    numbers = [cycles for cycles in found if cycles is not None]
    failed = next((result for result in results if not result.met), None)
    return Line(
        row=row,
        variant=variant.name,
        arm=arm,
        seeds=len(results),
        met=bool(results) and failed is None,
        bound=variant.bound,
        worst=max(numbers) if numbers and len(numbers) == len(found) else None,
        reaction=", ".join(sorted({result.reaction for result in results if result.reaction})),
        culprit_ok=bool(results) and all(result.culprit_ok for result in results),
        reenabled=any(result.facts is not None and result.facts.reenabled for result in results),
        replay=None if failed is None else trial_of(failed).words,
        why=[] if failed is None else failed.problems,
    )


def met_rows(lines: Iterable[Line]) -> dict[int, bool]:
    """Whether each row is met: all its variants on all arms are."""
    met: dict[int, bool] = {}
    for line in lines:
        met[line.row] = met.get(line.row, True) and line.met
    return met

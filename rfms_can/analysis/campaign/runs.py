"""Runs the jobs of a campaign that have not been run yet."""

import tempfile
from collections.abc import Iterable, Sequence
from functools import cache, partial
from pathlib import Path

from rfms_can.analysis.campaign.conditions import Conditions
from rfms_can.analysis.campaign.insertion import insert
from rfms_can.analysis.campaign.job import Group, Insertion, Job
from rfms_can.engine import Backend, Kept, carry_out, run


def jobs_of(groups: Iterable[Group], seeds: Sequence[int], dither: float) -> list[Job]:
    """All jobs of some groups, seed by seed, so that what there is can be compared early."""
    groups = list(groups)
    return [Job(group, seed, dither) for seed in seeds for group in groups]


def run_all(
    jobs: Sequence[Job], program: Path, kept: Kept[Conditions, Insertion], backend: Backend
) -> list[Insertion]:
    """Run what has not been run yet.

    Args:
        jobs: all jobs.
        program: the program's file. A worker elsewhere is sent its text, without modules beside it.
        kept: results of earlier calls; new ones are added.
        backend: what runs the jobs.

    Returns:
        One result for each job, in their order.

    Raises:
        EngineError: as ``rfms_can.engine.run`` does.
    """
    one = partial(_insert, program=program, text=program.read_bytes())
    return carry_out(
        jobs,
        lambda left: run(one, left, backend, name=_name),
        kept,
        what="peg in hole",
        job_key=lambda job: (*job.group, job.seed),
        result_key=lambda insertion: (*insertion.group, insertion.seed),
    )


def _name(job: Job) -> str:
    return f"{' '.join(map(str, job.group))}, seed {job.seed}"


def _insert(job: Job, program: Path, text: bytes) -> Insertion:
    return insert(job, _here(program, text))


@cache
def _here(program: Path, text: bytes) -> Path:
    """The program's file on this machine: itself, or one with its text."""
    try:
        if program.read_bytes() == text:
            return program
    except OSError:
        pass  # of another machine
    copy = Path(_directory().name) / program.name
    copy.write_bytes(text)
    return copy


@cache
def _directory() -> "tempfile.TemporaryDirectory[str]":
    """Removed when this process ends."""
    return tempfile.TemporaryDirectory(prefix="rfms-")

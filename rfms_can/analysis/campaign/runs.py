"""Many jobs on the cores of this machine; results are kept as they come, and not made twice."""

import multiprocessing
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path

import msgspec

from rfms_can.analysis.campaign.insertion import insert
from rfms_can.analysis.campaign.job import Group, Insertion, Job

_DECODER = msgspec.json.Decoder(Insertion)


def jobs_of(groups: Iterable[Group], seeds: Sequence[int], dither: float) -> list[Job]:
    """All jobs of some groups, seed by seed, so that what there is can be compared early."""
    groups = list(groups)
    return [Job(group, seed, dither) for seed in seeds for group in groups]


def kept(file: Path | None) -> list[Insertion]:
    """Results of earlier calls."""
    if file is None or not file.is_file():
        return []
    lines = file.read_bytes().splitlines()
    return [_DECODER.decode(line) for line in lines if line.strip()]


def run_all(
    jobs: Sequence[Job],
    program: Path,
    *,
    workers: int = 1,
    keep: Path | None = None,
    done: Callable[[Insertion], None] = lambda _: None,
) -> list[Insertion]:
    """Run what has not been run yet.

    Args:
        jobs: all there are.
        program: the program's file.
        workers: processes.
        keep: file of JSON lines; results are read from it and added to it.
        done: told of each result.

    Returns:
        One result for each job, in their order.
    """
    results = {(*result.group, result.seed): result for result in kept(keep)}
    left = [job for job in jobs if (*job.group, job.seed) not in results]
    for job in jobs:
        result = results.get((*job.group, job.seed))
        if result is not None:
            done(result)
    for result in _runs(left, program, workers):
        results[(*result.group, result.seed)] = result
        if keep is not None:
            with keep.open("ab") as file:
                file.write(msgspec.json.encode(result) + b"\n")
        done(result)
    return [results[(*job.group, job.seed)] for job in jobs]


def _runs(jobs: Sequence[Job], program: Path, workers: int) -> Iterable[Insertion]:
    one = partial(insert, program=program)
    if workers <= 1 or len(jobs) <= 1:
        yield from map(one, jobs)
        return
    with multiprocessing.get_context("fork").Pool(workers) as pool:
        yield from pool.imap_unordered(one, jobs)

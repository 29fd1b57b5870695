"""Runs jobs on the processors of this machine; finished runs are not repeated."""

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path

from rfms_can.analysis.campaign.insertion import insert
from rfms_can.analysis.campaign.job import Group, Insertion, Job
from rfms_can.analysis.campaign.results import Results
from rfms_can.rig.workers import workers


def jobs_of(groups: Iterable[Group], seeds: Sequence[int], dither: float) -> list[Job]:
    """All jobs of some groups, seed by seed, so that what there is can be compared early."""
    groups = list(groups)
    return [Job(group, seed, dither) for seed in seeds for group in groups]


def run_all(
    jobs: Sequence[Job],
    program: Path,
    results: Results,
    *,
    processes: int = 1,
    done: Callable[[Insertion], None] = lambda _: None,
) -> list[Insertion]:
    """Run what has not been run yet.

    Args:
        jobs: all jobs.
        program: the program's file.
        results: of earlier calls; new ones are added.
        processes: number of parallel processes.
        done: called with each result, also of earlier calls.

    Returns:
        One result for each job, in their order.
    """
    known = {(*run.group, run.seed): run for run in results.runs}
    asked = [(*job.group, job.seed) for job in jobs]
    for key in asked:
        if key in known:
            done(known[key])
    left = [job for key, job in zip(asked, jobs, strict=True) if key not in known]
    for run in _runs(left, program, processes):
        known[(*run.group, run.seed)] = run
        results.add(run)
        done(run)
    return [known[key] for key in asked]


def _runs(jobs: Sequence[Job], program: Path, processes: int) -> Iterable[Insertion]:
    one = partial(insert, program=program)
    if processes <= 1 or len(jobs) <= 1:
        yield from map(one, jobs)
        return
    with workers(processes) as pool:
        yield from pool.imap_unordered(one, jobs)

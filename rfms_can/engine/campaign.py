"""Carries out a campaign: what its file has is not made again; what is made is kept at once."""

from collections.abc import Callable, Generator, Hashable, Sequence
from contextlib import closing
from typing import TypeVar

from rfms_can.engine.kept import C, Kept, R
from rfms_can.engine.progress import Progress
from rfms_can.engine.signals import sigterm_interrupts

J = TypeVar("J")


def _silent(_: object) -> str:
    return ""


def carry_out(
    jobs: Sequence[J],
    make: Callable[[list[J]], Generator[R, None, None]],
    kept: Kept[C, R],
    *,
    what: str,
    job_key: Callable[[J], Hashable],
    result_key: Callable[[R], Hashable],
    remark: Callable[[R], str] = _silent,
) -> list[R]:
    """Run the jobs whose results are not kept yet.

    Args:
        jobs: all jobs of the campaign, in order.
        make: results of the jobs that are left, in any order; ``run`` with a function.
        kept: results of earlier calls; new ones are added as they come.
        what: is counted, in one or two words, for the progress.
        job_key, result_key: equal where a result is of a job.
        remark: a line to print about a new result, or "".

    Returns:
        One result for each job, in their order, whatever computed them.

    Raises:
        EngineError: as ``run`` does.
        KeyboardInterrupt: by Ctrl-C, or SIGTERM; finished runs are kept.
    """
    order = [job_key(job) for job in jobs]
    known = {result_key(result): result for result in kept.results}
    left = [job for key, job in zip(order, jobs, strict=True) if key not in known]
    with (
        sigterm_interrupts(),
        Progress(what, len(jobs), len(jobs) - len(left)) as progress,
        closing(make(left)) as results,
    ):
        for result in results:
            key = result_key(result)
            if key in known:
                continue
            known[key] = result
            kept.add(result)
            line = remark(result)
            if line:
                progress.say(line)
            progress.advance()
    kept.arrange(order, result_key)
    return [known[key] for key in order]

"""Jobs and what computes them: results as they come, or in the order of the jobs."""

from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import closing
from dataclasses import dataclass
from typing import Final, Generic, Protocol, TypeVar

from rfms_can.errors import JobError

J = TypeVar("J")
R = TypeVar("R")

NAME_LENGTH: Final = 120
"""Longest name of a job in a message, characters."""


def described(job: object) -> str:
    """A job in a message: its ``name`` if it has one, otherwise its ``repr``, on one line."""
    words = " ".join(str(getattr(job, "name", None) or repr(job)).split())
    return words if len(words) <= NAME_LENGTH else words[: NAME_LENGTH - 3] + "..."


def _nothing() -> None:
    pass


@dataclass(frozen=True)
class Work(Generic[J, R]):
    """What a backend is given.

    Attributes:
        one: makes the result of a job. It, the jobs and the results can be pickled.
        jobs: taken one by one as a worker is free, so they may be endless.
        name: of a job, for messages.
        tick: called a few times a second while results are waited for; what it raises ends all.
    """

    one: Callable[[J], R]
    jobs: Iterable[J]
    name: Callable[[J], str] = described
    tick: Callable[[], None] = _nothing

    def failed(self, job: J, error: BaseException) -> JobError:
        """The error of a job that raised one."""
        why = " ".join(str(error).split())
        return JobError(f"job {self.name(job)}: {type(error).__name__}: {why}")

    def given_up(self, job: J, times: int, how: str) -> JobError:
        """The error of a job whose workers were lost, each time."""
        return JobError(
            f"job {self.name(job)}: given up after {times} workers were lost over it, the last "
            f"{how}: run it alone, with --workers 1, and look at its memory"
        )


class Backend(Protocol):
    """Computes jobs.

    A worker that is lost, killed for instance, has its job done again by another, a few times.
    Whatever ends the iteration, an exception, a signal or ``close()``, ends the workers too.
    """

    def results(self, work: Work[J, R]) -> Iterator[tuple[int, R]]:
        """The number of each job, counted from 0, and its result, as they come.

        Raises:
            JobError: a job raised, or was given up; it is named. The others end.
        """


class Serial:
    """Jobs one after another, in this process."""

    def results(self, work: Work[J, R]) -> Iterator[tuple[int, R]]:
        """See ``Backend``."""
        for index, job in enumerate(work.jobs):
            try:
                result = work.one(job)
            except Exception as error:
                raise work.failed(job, error) from error
            yield index, result
            work.tick()


def run(
    one: Callable[[J], R],
    jobs: Iterable[J],
    backend: Backend,
    *,
    in_order: bool = False,
    name: Callable[[J], str] = described,
    tick: Callable[[], None] = _nothing,
) -> Generator[R, None, None]:
    """The results of all jobs.

    Args:
        one: makes the result of a job; it, the jobs and the results can be pickled.
        jobs: in order; taken as workers are free, so they may be endless.
        backend: what computes them.
        in_order: results in the order of the jobs; otherwise as they come.
        name: of a job, for messages.
        tick: called a few times a second while results are waited for; what it raises ends all.

    Raises:
        EngineError: the backend cannot be had, as ``Cluster`` tells.
        JobError: a job raised, or was given up; it is named.
    """
    early: dict[int, R] = {}
    due = 0
    with closing(_iterating(backend.results(Work(one, jobs, name, tick)))) as results:
        for index, result in results:
            if not in_order:
                yield result
                continue
            early[index] = result
            while due in early:
                yield early.pop(due)
                due += 1


def _iterating(results: Iterator[tuple[int, R]]) -> Generator[tuple[int, R], None, None]:
    yield from results

"""Worker processes of this machine. One that is lost has its job done again by another."""

import os
import pickle
import signal
import traceback
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from typing import Any, Final, Generic, NamedTuple

from rfms_can.engine.jobs import J, R, Work
from rfms_can.errors import EngineError

SIGNALS: Final = (signal.SIGINT, signal.SIGTERM)
ATTEMPTS: Final = 3
"""Workers that may be lost over a job before it is given up."""
LOOK_S: Final = 0.2
"""Longest time between two calls of ``tick``, s."""
END_S: Final = 5.0
"""How long a worker may take to end before it is killed, s."""

_CONTEXT: Final = get_context("fork")


class Processes:
    """Jobs in processes of this machine, each one job at a time.

    The processes are forked, so the function needs no module of its own. Each leads a process
    group, with whatever it starts itself: Ctrl-C is for this process alone, which then ends them.
    If this process is killed, they end with the job they have.

    Args:
        count: how many processes, 1 or more.

    Raises:
        EngineError: it is less than 1.
    """

    def __init__(self, count: int) -> None:
        if count < 1:
            raise EngineError(f"workers {count}: give one or more")
        self.count: Final = count

    def results(self, work: Work[J, R]) -> Iterator[tuple[int, R]]:
        """See ``Backend``."""
        crew = _Crew(work, self.count)
        try:
            while crew.hand_out():
                for worker in crew.ready():
                    task, outcome = worker.answer()
                    if outcome is None:
                        crew.lost(worker, task)
                        continue
                    if outcome.error is not None:
                        raise work.failed(task.job, outcome.error) from outcome.error
                    crew.hand_out()  # it works on while the result is used
                    yield task.index, outcome.result
                work.tick()
        finally:
            crew.end()


@dataclass
class _Task(Generic[J]):
    """A job, its number, and the workers lost over it so far."""

    index: int
    job: J
    lost: int = 0


class _Outcome(NamedTuple):
    """A job's result, or what it raised."""

    result: Any
    error: BaseException | None = None


class _Crew(Generic[J, R]):
    """The workers, and the jobs that they have not been given yet."""

    def __init__(self, work: Work[J, R], count: int) -> None:
        self._work = work
        self._count = count
        self._tasks = (_Task(index, job) for index, job in enumerate(work.jobs))
        self._again: deque[_Task[J]] = deque()
        self._workers: list[_Worker[J, R]] = []

    def hand_out(self) -> bool:
        """Give every free worker a job; whether any worker has one."""
        free = [worker for worker in self._workers if worker.task is None]
        while free or len(self._workers) < self._count:
            task = self._again.popleft() if self._again else next(self._tasks, None)
            if task is None:
                break
            worker = free.pop() if free else self._hired()
            try:
                worker.begin(task)
            except (pickle.PicklingError, TypeError, AttributeError) as error:
                raise self._work.failed(task.job, error) from error
        return any(worker.task is not None for worker in self._workers)

    def _hired(self) -> "_Worker[J, R]":
        worker = _Worker(self._work.one, [each.connection for each in self._workers])
        self._workers.append(worker)
        return worker

    def ready(self) -> "list[_Worker[J, R]]":
        """Those that have answered, or are lost."""
        busy = {each.connection: each for each in self._workers if each.task is not None}
        return [busy[connection] for connection in wait(list(busy), LOOK_S)]  # type: ignore[index]

    def lost(self, worker: "_Worker[J, R]", task: _Task[J]) -> None:
        """Have its job done again, first of all.

        Raises:
            JobError: it has been given up.
        """
        self._workers.remove(worker)
        how = worker.end()
        task.lost += 1
        if task.lost >= ATTEMPTS:
            raise self._work.given_up(task.job, task.lost, how)
        self._again.appendleft(task)

    def end(self) -> None:
        """End all, at once."""
        for worker in self._workers:
            worker.terminate()
        for worker in self._workers:
            worker.end()


class _Worker(Generic[J, R]):
    """A process and the task that it has.

    It is forked with signals blocked: a process that has just been forked still has the handlers
    of its parent, which may note a signal instead of dying of it.

    Args:
        one: makes the result of a job.
        others: our ends of the pipes of its colleagues, which it must not hold open.
    """

    def __init__(self, one: Callable[[J], R], others: Sequence["Connection[Any, Any]"]) -> None:
        self.task: _Task[J] | None = None
        self.connection, theirs = _CONTEXT.Pipe()
        self._process = _CONTEXT.Process(
            target=_serve, args=(one, theirs, [self.connection, *others])
        )
        before = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
        try:
            self._process.start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        theirs.close()
        assert self._process.pid is not None
        self._pid = self._process.pid
        with suppress(OSError):
            os.setpgid(self._pid, self._pid)  # here too: it may be ended before it has begun

    def begin(self, task: _Task[J]) -> None:
        """Give it a job; one that is lost already answers nothing."""
        self.task = task
        with suppress(BrokenPipeError, ConnectionResetError):
            self.connection.send(task.job)

    def answer(self) -> tuple[_Task[J], _Outcome | None]:
        """Its task and the outcome; None if the worker is lost."""
        task, self.task = self.task, None
        assert task is not None
        try:
            return task, _Outcome(*self.connection.recv())
        except (EOFError, ConnectionResetError):
            return task, None

    def terminate(self) -> None:
        """Ask it to end, and what it has started."""
        with suppress(ProcessLookupError):
            os.killpg(self._pid, signal.SIGTERM)

    def end(self) -> str:
        """Wait for its end; how it ended, in words."""
        self.terminate()
        self._process.join(END_S)
        if self._process.exitcode is None:
            self._process.kill()
            self._process.join()
        self.connection.close()
        code = self._process.exitcode or 0
        return f"by {signal.Signals(-code).name}" if code < 0 else f"with exit code {code}"


def _serve(
    one: Callable[[J], R],
    connection: "Connection[Any, Any]",
    others: Sequence["Connection[Any, Any]"],
) -> None:
    """Jobs until the parent closes its end, or is gone."""
    for other in others:
        other.close()
    os.setpgid(0, 0)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)
    with suppress(EOFError, BrokenPipeError, ConnectionResetError):
        while True:
            connection.send_bytes(_outcome(one, connection.recv()))


def _outcome(one: Callable[[J], R], job: J) -> bytes:
    """An ``_Outcome``, pickled; its error has the traceback as a note."""
    try:
        return pickle.dumps((one(job), None))
    except BaseException as error:
        error.add_note(traceback.format_exc())
        return pickle.dumps((None, portable(error)))


def portable(error: BaseException) -> BaseException:
    """An error that can be pickled and read again: itself, or its words."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error

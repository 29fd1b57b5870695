"""Jobs in processes: in order or as they come, whatever is lost, whatever ends them."""

import itertools
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Final

import pytest
from support.command_line import assert_none_left

from rfms_can.engine import Backend, Processes, Serial, backend_of, run
from rfms_can.engine.processes import ATTEMPTS
from rfms_can.errors import EngineError, JobError, PlantError
from rfms_can.rig.interrupt import signals_noted

HASTY: Final = """
from rfms_can.engine import Processes, run
from rfms_can.rig.interrupt import signals_noted

for _ in range(15):
    with signals_noted():
        next(run(abs, range(100), Processes(8)))  # ended before they have begun
print("done")
"""
LONG: Final = """
import sys, time
from rfms_can.engine import Processes, run
from rfms_can.engine.signals import sigterm_interrupts

with sigterm_interrupts():
    for _ in run(lambda seconds: time.sleep(seconds), [0.0, 0.0, 60.0, 60.0], Processes(2)):
        print("one", flush=True)
"""
BACKENDS: Final = (Serial(), Processes(1), Processes(3))


def slow_first(number: int) -> int:
    """Later jobs are done sooner."""
    time.sleep(0.02 * (5 - number % 5))
    return number * number


def die_once(number: int, flags: Path, deadly: int, times: int) -> int:
    """A job that kills its worker the first times."""
    flag = flags / f"{number}.{len(list(flags.glob(f'{number}.*')))}"
    flag.touch()
    if number == deadly and len(list(flags.glob(f"{number}.*"))) <= times:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


@pytest.mark.parametrize("backend", BACKENDS)
def test_results_in_order_are_those_of_the_jobs(backend: Backend) -> None:
    assert list(run(slow_first, range(12), backend, in_order=True)) == [n * n for n in range(12)]


@pytest.mark.parametrize("backend", BACKENDS)
def test_results_as_they_come_are_all_there_once(backend: Backend) -> None:
    assert sorted(run(slow_first, range(12), backend)) == [n * n for n in range(12)]


def test_results_come_as_soon_as_they_are_there() -> None:
    assert next(run(time.sleep, [0.0, 0.0], Processes(2))) is None
    first = next(run(slow_first, [0, 4], Processes(2)))
    assert first == 16


@pytest.mark.parametrize("backend", BACKENDS)
def test_jobs_may_be_endless(backend: Backend) -> None:
    """They are taken as workers are free."""
    results = run(abs, itertools.count(), backend, in_order=True)
    assert list(itertools.islice(results, 40)) == list(range(40))
    results.close()


@pytest.mark.parametrize("backend", BACKENDS)
def test_no_jobs_have_no_results(backend: Backend) -> None:
    assert list(run(abs, [], backend)) == []


def test_a_lost_worker_has_its_job_done_again_and_the_others_once(tmp_path: Path) -> None:
    one = partial(die_once, flags=tmp_path, deadly=5, times=ATTEMPTS - 1)
    assert list(run(one, range(12), Processes(3), in_order=True)) == list(range(12))
    done = [len(list(tmp_path.glob(f"{number}.*"))) for number in range(12)]
    assert done == [ATTEMPTS if number == 5 else 1 for number in range(12)]


def test_a_job_that_kills_every_worker_is_given_up_and_named(tmp_path: Path) -> None:
    one = partial(die_once, flags=tmp_path, deadly=5, times=ATTEMPTS)
    with pytest.raises(JobError, match=r"^job 5: given up after 3 workers .* by SIGKILL: run it"):
        list(run(one, range(12), Processes(3)))


def test_a_worker_that_exits_is_lost_too() -> None:
    with pytest.raises(JobError, match=r"the last with exit code 7: "):
        list(run(os._exit, [7], Processes(1)))


@pytest.mark.parametrize("backend", BACKENDS)
def test_what_a_job_raises_names_it(backend: Backend) -> None:
    with pytest.raises(JobError, match=r"^job 0: ZeroDivisionError: division by zero$") as told:
        list(run(lambda number: 1 / number, [2, 1, 0], backend))
    assert isinstance(told.value.__cause__, ZeroDivisionError)
    if not isinstance(backend, Serial):
        assert "test_engine_processes.py" in told.value.__cause__.__notes__[0]


def test_a_job_has_the_name_it_is_given() -> None:
    with pytest.raises(JobError, match=r"^job number 0: "):
        list(run(lambda n: 1 / n, [0], Serial(), name=lambda n: f"number {n}"))
    long = "x" * 1000
    with pytest.raises(JobError, match=r"^job 'x{116}\.\.\.: "):
        list(run(int, [long], Serial()))


class StubbornError(PlantError):
    """It cannot be read after it was pickled."""

    def __init__(self, one: str, two: str) -> None:
        super().__init__(f"{one} {two}")


def stubborn(_: object) -> None:
    raise StubbornError("cannot", "be read")


@pytest.mark.parametrize(
    ("one", "job", "says"),
    [
        (stubborn, 1, "StubbornError: cannot be read"),
        (lambda _: lambda: 1, 1, "pickle"),
        (abs, lambda: 1, "pickle"),
    ],
)
def test_what_cannot_be_pickled_is_told(
    one: Callable[[object], object], job: object, says: str
) -> None:
    with pytest.raises(JobError, match=says):
        list(run(one, [job], Processes(1)))


def test_ctrl_c_is_for_the_parent() -> None:
    def one(_: int) -> int:
        os.kill(os.getpid(), signal.SIGINT)
        return os.getpid()

    assert len(set(run(one, range(3), Processes(1)))) == 1
    assert os.getpgid(0) not in set(run(lambda _: os.getpgid(0), [0], Processes(1)))


def test_the_parent_hears_signals_that_come_meanwhile() -> None:
    def tick() -> None:
        if interrupt():
            raise KeyboardInterrupt

    with signals_noted() as interrupt, pytest.raises(KeyboardInterrupt):
        results = run(time.sleep, [0.0, 60.0], Processes(1), tick=tick)
        next(results)
        os.kill(os.getpid(), signal.SIGTERM)
        next(results)
    assert interrupt.signal is signal.SIGTERM


def test_processes_that_have_only_just_begun_end_too() -> None:
    """They have their parent's handlers for a moment, which note signals and go on."""
    ended = subprocess.run(
        [sys.executable, "-c", HASTY], capture_output=True, text=True, timeout=60, check=True
    )
    assert ended.stdout == "done\n"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_signals_end_the_workers(number: signal.Signals) -> None:
    """At once; a parent that was killed cannot: they end with the jobs that they have."""
    code = LONG.replace("60.0", "1.0") if number == signal.SIGKILL else LONG
    process = subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        start_new_session=True,
    )
    assert process.stdout is not None
    assert [process.stdout.readline() for _ in range(2)] == ["one\n", "one\n"]
    process.send_signal(number)
    assert process.wait(10.0) != 0
    assert_none_left(process.pid)


def test_the_flags_choose_the_backend() -> None:
    assert isinstance(backend_of(1, None), Serial)
    assert isinstance(backend_of(None, None), Serial)
    several = backend_of(None, None, default=4)
    assert isinstance(several, Processes) and several.count == 4
    with pytest.raises(EngineError, match=r"^workers 0: give one or more$"):
        backend_of(0, None)
    with pytest.raises(EngineError, match="give one of the two"):
        backend_of(2, "tcp://127.0.0.1:8786")

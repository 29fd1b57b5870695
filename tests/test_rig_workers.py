"""Processes that share work end with their block, even where they have only just begun."""

import os
import signal
import subprocess
import sys
import time

import pytest

from rfms_can.rig.interrupt import signals_noted
from rfms_can.rig.workers import workers

HASTY = """
from rfms_can.rig.interrupt import signals_noted
from rfms_can.rig.workers import workers

for _ in range(30):
    with signals_noted(), workers(8):
        pass  # ended before they have begun
print("done")
"""


def test_processes_that_have_only_just_begun_end_too() -> None:
    """They have their parent's handlers for a moment, which note signals and go on."""
    ended = subprocess.run(
        [sys.executable, "-c", HASTY], capture_output=True, text=True, timeout=120, check=True
    )
    assert ended.stdout == "done\n"


def test_work_is_shared_and_comes_back() -> None:
    with workers(2) as pool:
        assert pool.map(abs, [-3, -1, 2]) == [3, 1, 2]


def test_ctrl_c_is_for_the_parent() -> None:
    with workers(1) as pool:
        (child,) = pool.map(_pid, [None])
        os.kill(child, signal.SIGINT)
        assert pool.map(_pid, [None]) == [child]


def test_the_parent_hears_signals_that_come_meanwhile() -> None:
    with signals_noted() as interrupt, workers(1):
        os.kill(os.getpid(), signal.SIGTERM)
        until = time.monotonic() + 10.0
        while not interrupt() and time.monotonic() < until:
            time.sleep(0.01)
        assert interrupt()
    assert interrupt.signal is signal.SIGTERM


def test_what_goes_wrong_in_a_process_is_told_here() -> None:
    with workers(1) as pool, pytest.raises(ZeroDivisionError):
        pool.map(_inverse, [0])


def _pid(_: object) -> int:
    return os.getpid()


def _inverse(number: int) -> float:
    return 1 / number

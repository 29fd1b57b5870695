"""Nothing is left behind, whatever ends us: a second process cleans up when the first is gone."""

import ctypes
import os
import shutil
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import NoReturn

PR_SET_CHILD_SUBREAPER = 36


@contextmanager
def guarding(directory: str) -> Iterator[Callable[[int], None]]:
    """On leaving, remove a directory and end a group of processes, even if we are killed.

    The guard holds one end of a pipe; the system closes our end however we end.

    Yields:
        A function to tell the guard the number of the process group.
    """
    # The kernel's helper processes outlive it and would be process 1's to reap: they become ours.
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    watched, alive = os.pipe()
    if os.fork() == 0:
        os.close(alive)
        stand_guard(watched, directory)
    os.close(watched)

    def watch(group: int) -> None:
        os.write(alive, b"%d" % group)

    try:
        yield watch
    finally:
        os.close(alive)
        with suppress(ChildProcessError):
            while True:
                os.wait()


def stand_guard(watched: int, directory: str) -> NoReturn:
    """Be the guard: learn the group, wait until the other end of the pipe is gone, clean up."""
    os.setsid()  # the terminal's signals are not for us
    group = b"".join(iter(lambda: os.read(watched, 64), b""))
    if group:
        with suppress(ProcessLookupError):
            os.killpg(int(group), signal.SIGKILL)
    shutil.rmtree(directory, ignore_errors=True)
    os._exit(0)

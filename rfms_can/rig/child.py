"""Child processes that end with their parent, whatever ends it: no orphan survives."""

import contextlib
import ctypes
import os
import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterable
from tempfile import TemporaryFile
from types import FrameType
from typing import Final, NoReturn

from rfms_can.errors import RfmsError

_PR_SET_PDEATHSIG: Final = 1
PATIENCE_S: Final = 5.0
"""How long a child may take to end by itself before it is killed."""
LOOK_FOR_PARENT_S: Final = 0.5

Stop = Callable[[], bool]
"""Given to a child's body: whether it shall end."""


class Child:
    """A forked process that runs ``body`` until it ends, fails or is told to stop.

    The parent has imported what the child needs: a fork starts at once and shares the memory.

    Args:
        name: used in messages.
        body: called in the child with a function that says when to stop.
        quiet: its error is left to the parent to tell (``describe``).

    Attributes:
        name: as given.
        pid: process id.
        exit_code: None while it runs.
    """

    def __init__(self, name: str, body: Callable[[Stop], None], *, quiet: bool = False) -> None:
        self.name = name
        self.exit_code: int | None = None
        self._error = TemporaryFile()  # noqa: SIM115  # shared with the child, closed with us
        parent = os.getpid()
        sys.stdout.flush()
        sys.stderr.flush()
        # a signal between the fork and the child's own handlers would run the parent's handler
        before = signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGTERM, signal.SIGINT))
        self.pid = os.fork()
        if self.pid == 0:
            _run(name, body, parent, before, self._error.fileno(), quiet)
        signal.pthread_sigmask(signal.SIG_SETMASK, before)

    @property
    def alive(self) -> bool:
        """Whether it still runs."""
        if self.exit_code is None:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            if pid:
                self.exit_code = os.waitstatus_to_exitcode(status)
        return self.exit_code is None

    @property
    def error(self) -> str:
        """What ended it, in one line, once it has ended; empty if it ended well or was killed."""
        self._error.seek(0)
        return self._error.read().decode()

    def signal(self) -> None:
        """Tell it to stop, also if it has been suspended."""
        if self.alive:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self.pid, signal.SIGTERM)
                os.kill(self.pid, signal.SIGCONT)

    def join(self) -> int:
        """Wait until it has ended; kill it if it takes too long. Its exit code."""
        until = time.monotonic() + PATIENCE_S
        while self.alive:
            if time.monotonic() > until:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(self.pid, signal.SIGKILL)
            time.sleep(0.005)
        return self.exit_code or 0


def describe(child: Child) -> str:
    """How a child has ended, and by which error of its own, for messages."""
    why = f": {child.error}" if child.error else ""
    return f"{child.name} (pid {child.pid}) has ended with exit code {child.exit_code}{why}"


def _run(
    name: str,
    body: Callable[[Stop], None],
    parent: int,
    unblocked: Iterable[int],
    told: int,
    quiet: bool,
) -> NoReturn:
    """In the child: run, report an error in one line, exit without the parent's clean-up."""
    stopping = False

    def stop(_signal: int, _frame: FrameType | None) -> None:
        nonlocal stopping
        stopping = True

    code = 1
    try:
        signal.signal(signal.SIGTERM, stop)
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's to handle
        signal.pthread_sigmask(signal.SIG_SETMASK, unblocked)
        die_with_parent(parent)
        body(lambda: stopping)
        code = 0
    except RfmsError as error:
        os.write(told, str(error).encode())
        if not quiet:
            print(f"{name}: {error}", file=sys.stderr)
    except BaseException as bug:
        os.write(told, f"a bug: {type(bug).__name__}".encode())
        print(f"{name}: a bug ended it", file=sys.stderr)
        traceback.print_exc()
    finally:
        with contextlib.suppress(Exception):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(code)


def die_with_parent(parent: int) -> None:
    """End this process when its parent dies: by the kernel, or by a thread where it cannot.

    Args:
        parent: process id that this process was forked by; if it has gone already, this ends too.

    Not in the node's loop: checking the parent on every frame costs as much as the frame.
    """
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    else:
        threading.Thread(target=_watch_parent, args=(parent,), daemon=True).start()
    if os.getppid() != parent:
        os._exit(1)


def _watch_parent(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(LOOK_FOR_PARENT_S)
    os._exit(1)

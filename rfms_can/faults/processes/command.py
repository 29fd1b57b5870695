"""``rfms`` as a process of its own: forked from this warm one, ended with it, its output in files.

A fork has the heavy libraries already: a command starts at once, also where imports are slow.
"""

import contextlib
import os
import signal
import sys
import time
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final, NoReturn

from rfms_can.rig.child import die_with_parent

Main = Callable[[], None]
"""Runs ``rfms`` with the arguments in ``sys.argv``; ends by ``SystemExit``."""
SEAM_SIGNAL: Final = signal.SIGUSR1
"""Has a process do what was arranged for it before its command began."""
PATIENCE_S: Final = 15.0
"""How long a command may take to end that was told to."""
_LOOK_S: Final = 0.02


class Command:
    """A running ``rfms`` command, in a session of its own.

    Args:
        main: the command line.
        arguments: of the command.
        directory: of the files of its output.
        seam: what ``SEAM_SIGNAL`` does to it and to each process it starts.

    Attributes:
        pid: its process id.
        out, err: files of what it printed.
        exit_code: negative for a signal; None while it runs.
    """

    def __init__(
        self,
        main: Main,
        arguments: Sequence[str],
        directory: Path,
        seam: Callable[[], None] | None = None,
    ) -> None:
        name = "-".join(word for word in arguments[:2] if word.isalnum())
        self.out, self.err = (directory / f"{name}.{kind}" for kind in ("out", "err"))
        self.exit_code: int | None = None
        parent = os.getpid()
        sys.stdout.flush()
        sys.stderr.flush()
        numbers = (signal.SIGINT, signal.SIGTERM, SEAM_SIGNAL)
        before = signal.pthread_sigmask(signal.SIG_BLOCK, numbers)
        self.pid = os.fork()
        if self.pid == 0:
            _become(main, arguments, (self.out, self.err), parent, seam)
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
    def complaint(self) -> str:
        """The last line it printed to the standard error; empty if there is none."""
        lines = self.err.read_text(errors="replace").split("\n")
        told = [line for line in lines if line.startswith("rfms: ")]
        return told[-1].removeprefix("rfms: ") if told else ""

    def signal(self, number: signal.Signals) -> None:
        """Send it a signal, if it still runs."""
        if self.alive:
            os.kill(self.pid, number)

    def end(self) -> list[int]:
        """Tell it to end, as Ctrl-C does, and wait; then kill what is left of its session.

        Returns:
            Process ids of what it left behind.
        """
        self.signal(signal.SIGINT)
        until = time.monotonic() + PATIENCE_S
        while self.alive and time.monotonic() < until:
            time.sleep(_LOOK_S)
        left = processes_of(self.pid)
        self.kill()
        return left

    def kill(self) -> None:
        """Kill it and every process of its session, at once."""
        while pids := processes_of(self.pid):
            for pid in pids:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
            _ = self.alive  # a zombie of ours is buried
            time.sleep(_LOOK_S)
        if self.exit_code is None:
            self.exit_code = os.waitstatus_to_exitcode(os.waitpid(self.pid, 0)[1])


def _become(
    main: Main,
    arguments: Sequence[str],
    files: tuple[Path, Path],
    parent: int,
    seam: Callable[[], None] | None,
) -> NoReturn:
    """In the fork: be the command, as a shell would have started it."""
    code: object = 1
    try:
        os.setsid()
        for number, path in enumerate(files, start=1):
            os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND), number)
        sys.stdout = open(1, "w", buffering=1, closefd=False)  # noqa: SIM115  # for its life
        sys.stderr = open(2, "w", buffering=1, closefd=False)  # noqa: SIM115
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        signal.signal(SEAM_SIGNAL, signal.SIG_IGN if seam is None else lambda *_: seam())
        signal.pthread_sigmask(signal.SIG_SETMASK, ())
        die_with_parent(parent)
        sys.argv = ["rfms", *arguments]
        main()
        code = 0
    except SystemExit as end:
        code = end.code or 0
    except BaseException:
        traceback.print_exc()
    finally:
        with contextlib.suppress(Exception):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(code if isinstance(code, int) else 1)


def _fields(pid: str) -> list[str]:
    """State, parent, group, session and so on of a process; empty if it has gone."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return []


def _found(place: int, number: int) -> list[int]:
    everything = {path.name: _fields(path.name) for path in Path("/proc").glob("[0-9]*")}
    return sorted(
        int(pid)
        for pid, fields in everything.items()
        if fields and int(fields[place]) == number and fields[0] != "Z"
    )


def processes_of(session: int) -> list[int]:
    """Ids of the processes of a session, zombies excepted."""
    return _found(3, session)


def runs(pid: int) -> bool:
    """Whether a process is there, and no zombie."""
    fields = _fields(str(pid))
    return bool(fields) and fields[0] != "Z"


def children_of(parent: int) -> list[int]:
    """Ids of the processes that one has started, zombies excepted."""
    return _found(1, parent)

"""``rfms`` as a user types it: in this process for speed, in one of its own for signals."""

import os
import pty
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

import pytest

from rfms_can.cli.app import main

MAIN = "from rfms_can.cli.app import main; main()"


class Ended(NamedTuple):
    """How a command ended."""

    code: int
    out: str
    err: str

    @property
    def complaint(self) -> str:
        """The one line of a command that failed."""
        assert self.code != 0, self.out
        lines = self.err.splitlines()
        assert len(lines) == 1, self.err
        assert lines[0].startswith("rfms: ")
        return lines[0]


Rfms = Callable[..., Ended]


def run_here(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, *arguments: str | Path
) -> Ended:
    """The command in this process; what it prints is what a pipe would get."""
    monkeypatch.setattr(sys, "argv", ["rfms", *map(str, arguments)])
    monkeypatch.setenv("COLUMNS", "100")
    capsys.readouterr()
    code: object = 0
    try:
        main()
    except SystemExit as end:
        code = end.code or 0
    captured = capsys.readouterr()
    assert isinstance(code, int)
    return Ended(code, captured.out, captured.err)


def start(
    *arguments: str | Path, environment: Mapping[str, str] | None = None
) -> subprocess.Popen[str]:
    """The command as a process in a group of its own, as a terminal would start it."""
    return subprocess.Popen(
        [sys.executable, "-c", MAIN, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, **(environment or {})},
        start_new_session=True,
    )


def at_a_terminal(answer: str, *arguments: str | Path, timeout_s: float = 30.0) -> Ended:
    """The command at a terminal, where a person types an answer; its prompts are in ``out``."""
    person, terminal = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-c", MAIN, *map(str, arguments)],
        stdin=terminal,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    os.close(terminal)
    try:
        os.write(person, answer.encode())
        return end(process, timeout_s)._replace(err="")
    finally:
        os.close(person)


def end(process: subprocess.Popen[str], timeout_s: float = 30.0) -> Ended:
    """Wait for its end."""
    try:
        out, err = process.communicate(timeout=timeout_s)
    except subprocess.TimeoutExpired:
        process.kill()
        raise
    return Ended(process.returncode, out, err)


def kill(process: subprocess.Popen[str]) -> None:
    """Kill a command started here, with all processes of its session."""
    for pid in processes_of(process.pid):
        os.kill(pid, signal.SIGKILL)


def processes_of(session: int) -> list[int]:
    """Processes that run in a session, zombies excepted: what a command has left behind."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[3]) == session and fields[0] != "Z":
            found.append(int(stat.parent.name))
    return found


def assert_none_left(session: int, within_s: float = 5.0) -> None:
    """All processes of a session end within a time."""
    until = time.monotonic() + within_s
    while processes_of(session) and time.monotonic() < until:
        time.sleep(0.02)
    assert processes_of(session) == []

"""Progress of a campaign, with the time that is left: a bar on a terminal, now and then a line."""

import sys
import time
from collections.abc import Callable
from types import TracebackType
from typing import Final, Self, TextIO

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
from rich.progress import Progress as Bar

EVERY_S: Final = 30.0
"""Time between two lines where there is no terminal, s."""


def left_in_words(seconds: float) -> str:
    """A time that is left, to two digits or so."""
    if seconds < 90.0:
        return f"{seconds:.0f} s left"
    if seconds < 90.0 * 60.0:
        return f"{seconds / 60.0:.0f} min left"
    return f"{seconds / 3600.0:.1f} h left"


class Progress:
    """How far a campaign is, on the standard error output.

    It has no thread of its own, since workers are forked meanwhile: it is drawn as results come.

    Args:
        what: is counted, in one or two words, e.g. ``programs``.
        total: how many there are.
        kept: how many of them there are from earlier; they say nothing about the time.
        clock: seconds, monotonic.
        file: where to, the standard error output by default.
    """

    def __init__(
        self,
        what: str,
        total: int,
        kept: int = 0,
        *,
        clock: Callable[[], float] = time.monotonic,
        file: TextIO | None = None,
    ) -> None:
        self._what: Final = what
        self._total: Final = total
        self._kept: Final = kept
        self._made = 0
        self._clock: Final = clock
        self._file: Final = file or sys.stderr
        self._began = self._said = clock()
        console = Console(file=self._file, soft_wrap=True, highlight=False)
        self._bar: Bar | None = None
        if console.is_terminal:
            columns = (BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
            self._bar = Bar(
                TextColumn("{task.description}"),
                *columns,
                console=console,
                auto_refresh=False,
                redirect_stdout=False,
                redirect_stderr=False,
                get_time=clock,
            )
            self._task = self._bar.add_task(what, total=total, completed=kept)

    def __enter__(self) -> Self:
        if self._bar is not None:
            self._bar.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

    def advance(self, count: int = 1) -> None:
        """Some more are done."""
        self._made += count
        if self._bar is not None:
            self._bar.advance(self._task, count)
            self._bar.refresh()
            return
        now = self._clock()
        if now - self._said >= EVERY_S:
            self._said = now
            done = self._kept + self._made
            left = (now - self._began) / self._made * max(0, self._total - done)
            self.say(f"{done} of {self._total} {self._what}, {left_in_words(left)}")

    def say(self, line: str) -> None:
        """Print a line; above the bar where there is one."""
        if self._bar is not None:
            self._bar.console.print(line, markup=False)
        else:
            print(line, file=self._file, flush=True)

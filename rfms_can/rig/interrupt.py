"""Ctrl-C and SIGTERM while a program runs: at once in its own code, else between two events."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Final

SIGNALS: Final = (signal.SIGINT, signal.SIGTERM)
EXIT_CODE_BASE: Final = 128


class Interrupt:
    """Whether a signal has asked the run to end.

    Attributes:
        signal: the first one received, or None.
    """

    def __init__(self) -> None:
        self.signal: signal.Signals | None = None
        self._raises = False

    def __call__(self) -> bool:
        """Whether a signal has come."""
        return self.signal is not None

    def program_runs(self, runs: bool) -> None:
        """Whether the main thread, which receives signals, now runs a program's own code."""
        if threading.current_thread() is threading.main_thread():
            self._raises = runs

    def note(self, number: int) -> None:
        """A signal has come.

        Raises:
            KeyboardInterrupt: it is the second one; or no event of the bus is interrupted by it.
        """
        again, self.signal = self.signal is not None, self.signal or signal.Signals(number)
        if again or self._raises:
            self._raises = False
            raise KeyboardInterrupt

    @property
    def exit_code(self) -> int:
        """The exit code shells expect of a process ended by a signal."""
        return EXIT_CODE_BASE + (self.signal or signal.SIGINT)


@contextmanager
def signals_noted() -> Iterator[Interrupt]:
    """Note the first signal; it raises where a program's own code runs, a second one anywhere."""
    interrupt = Interrupt()

    def note(number: int, _frame: FrameType | None) -> None:
        interrupt.note(number)

    previous = {number: signal.signal(number, note) for number in SIGNALS}
    try:
        yield interrupt
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)

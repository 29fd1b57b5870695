"""Ctrl-C and SIGTERM while a program runs: handled between two events, never within one."""

import signal
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

    def __call__(self) -> bool:
        """Whether a signal has come."""
        return self.signal is not None

    @property
    def exit_code(self) -> int:
        """The exit code shells expect of a process ended by a signal."""
        return EXIT_CODE_BASE + (self.signal or signal.SIGINT)


@contextmanager
def signals_noted() -> Iterator[Interrupt]:
    """Note the first signal instead of dying of it; a second one raises immediately."""
    interrupt = Interrupt()

    def note(number: int, _frame: FrameType | None) -> None:
        if interrupt.signal is not None:
            raise KeyboardInterrupt
        interrupt.signal = signal.Signals(number)

    previous = {number: signal.signal(number, note) for number in SIGNALS}
    try:
        yield interrupt
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)

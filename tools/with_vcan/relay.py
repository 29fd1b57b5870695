"""Relaying what a command prints, until it ends or a signal ends us."""

import os
import selectors
import signal
from collections.abc import Iterator
from contextlib import contextmanager

ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class Ended(Exception):  # noqa: N818
    """Termination by a signal, or by a closed output (SIGPIPE)."""

    def __init__(self, number: int) -> None:
        super().__init__(signal.Signals(number).name)
        self.signal = number


@contextmanager
def ending_signals() -> Iterator[int]:
    """Turn the signals that end a program into bytes, each a signal's number.

    They interrupt nothing then: neither starting the kernel nor cleaning up after it.

    Yields:
        The end of a pipe to read them from.
    """
    received, sender = os.pipe()
    os.set_blocking(sender, False)
    signal.set_wakeup_fd(sender)
    previous = {number: signal.signal(number, lambda *_: None) for number in ENDING}
    try:
        yield received
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
        signal.set_wakeup_fd(-1)
        os.close(sender)
        os.close(received)


def relay(targets: dict[int, int], signals: int) -> None:
    """Copy each pipe (key) to its target file until all pipes are closed at the other end.

    Raises:
        Ended: a signal's number came, or a target is a pipe whose reader has gone.
    """
    with selectors.DefaultSelector() as selector:
        selector.register(signals, selectors.EVENT_READ)
        for source, target in targets.items():
            selector.register(source, selectors.EVENT_READ, target)
        while len(selector.get_map()) > 1:
            for key, _ in selector.select():
                data = os.read(key.fd, 65536)
                if key.fd == signals:
                    raise Ended(data[0])
                if data:
                    write_all(key.data, data)
                else:
                    selector.unregister(key.fd)
                    os.close(key.fd)


def write_all(file: int, data: bytes) -> None:
    """Write all of the data."""
    try:
        while data:
            data = data[os.write(file, data) :]
    except BrokenPipeError:
        raise Ended(signal.SIGPIPE) from None

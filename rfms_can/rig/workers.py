"""Processes that share work: ended with the block that has them, whatever signals come when."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import get_context
from multiprocessing.pool import Pool

from rfms_can.rig.interrupt import SIGNALS


@contextmanager
def workers(count: int) -> Iterator[Pool]:
    """A pool of so many processes.

    Leaving the block ends them by SIGTERM. A process that has just been forked still has the
    handlers of its parent, which notes signals instead of dying of them: it would live on, and the
    parent wait for it for ever. So signals wait until it is deaf to Ctrl-C and mortal again.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
    try:
        pool = get_context("fork").Pool(count, _mortal)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    with pool:
        yield pool


def _mortal() -> None:
    """Ctrl-C is for the parent, which then ends its workers."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)

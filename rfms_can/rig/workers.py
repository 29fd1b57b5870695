"""A pool of worker processes, ended with its ``with`` block whatever signals arrive."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import get_context
from multiprocessing.pool import Pool

from rfms_can.rig.interrupt import SIGNALS


@contextmanager
def workers(count: int) -> Iterator[Pool]:
    """A pool of ``count`` processes.

    Leaving the block ends them by SIGTERM. A process that has just been forked still has the
    handlers of its parent, which note signals instead of dying of them: it would live on, and the
    parent would wait for it for ever. So signals are blocked until the handlers are reset.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
    try:
        pool = get_context("fork").Pool(count, _reset_handlers)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    with pool:
        yield pool


def _reset_handlers() -> None:
    """Reset the handlers: Ctrl-C is for the parent, which then ends its workers."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)

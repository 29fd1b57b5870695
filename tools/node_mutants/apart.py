"""A call in a process of its own, which may hang, raise, or take all memory."""

import gc
import os
import pickle
import resource
import signal
from collections.abc import Callable
from typing import Final, TypeVar

WAITS: Final = 10
"""Wall-clock time after which a call is ended that waits for ever, over its processor time."""

Answer = TypeVar("Answer")


def apart(call: Callable[[], Answer], cpu_s: int) -> Answer | None:
    """``call`` in a process of its own; None if it has used up ``cpu_s`` of processor time,
    or has waited for ``WAITS`` times as long.

    By ``os.fork``: the workers of a cluster are daemons, which multiprocessing gives no children.
    """
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.close(reader)
            _answer(writer, call, cpu_s)
        finally:
            os._exit(1)
    os.close(writer)
    with os.fdopen(reader, "rb") as pipe:
        answer = pipe.read()
    os.waitpid(child, 0)
    try:
        made: Answer = pickle.loads(answer)
    except (EOFError, pickle.UnpicklingError):
        return None
    return made


def _answer(writer: int, call: Callable[[], Answer], cpu_s: int) -> None:
    gc.disable()  # the parent's objects are not to be copied
    resource.setrlimit(resource.RLIMIT_CPU, (cpu_s, cpu_s + 5))
    signal.signal(signal.SIGXCPU, lambda *_: os._exit(1))
    signal.signal(signal.SIGALRM, lambda *_: os._exit(1))
    signal.alarm(WAITS * cpu_s)
    memory = 4 << 30
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    with os.fdopen(writer, "wb") as pipe:
        pipe.write(pickle.dumps(call()))

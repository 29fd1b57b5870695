"""A program beside a real-time bus, which does not wait: the driver has a thread of its own.

Also Linux' real-time options: SCHED_FIFO, CPU affinity, locked memory.
"""

import ctypes
import os
import queue
import threading
from collections.abc import Callable
from typing import Final, TypeVar

from rfms_can.errors import RfmsError

Result = TypeVar("Result")
_MCL_CURRENT_AND_FUTURE: Final = 3


class ThreadedPump:
    """Runs a pump in a thread of its own; conditions and requests are served between its steps.

    Args:
        pump: runs the bus until a condition holds; evaluates it after every event.
    """

    def __init__(self, pump: Callable[[Callable[[], bool]], None]) -> None:
        self._pump = pump
        self._jobs: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._condition: Callable[[], bool] | None = None
        self._reached = threading.Event()
        self._failure: BaseException | None = None
        self._closing = False
        self._thread = threading.Thread(target=self._run, name="bus", daemon=True)
        self._thread.start()

    def __call__(self, condition: Callable[[], bool]) -> None:
        """Wait until a condition holds; a failure of the bus is raised here."""
        self._reached.clear()
        self._condition = condition
        while not self._reached.wait(0.1):
            if self._failure is not None:
                break
        if self._failure is not None:
            raise self._failure

    def do(self, action: Callable[[], Result]) -> Result:
        """Call a function in the bus' thread between two steps; its result or error."""
        results: queue.SimpleQueue[Result | BaseException] = queue.SimpleQueue()

        def job() -> None:
            try:
                results.put(action())
            except BaseException as error:
                results.put(error)

        self._jobs.put(job)
        while True:
            try:
                result = results.get(timeout=0.1)
            except queue.Empty:
                if self._failure is not None:
                    raise self._failure from None
                continue
            if isinstance(result, BaseException):
                raise result
            return result

    def close(self) -> None:
        """End the thread."""
        self._closing = True
        self._thread.join(timeout=2.0)

    def _run(self) -> None:
        try:
            self._pump(self._between_steps)
        except BaseException as error:
            self._failure = error
            self._reached.set()

    def _between_steps(self) -> bool:
        while not self._jobs.empty():
            self._jobs.get()()
        condition = self._condition
        if condition is not None and condition():
            self._condition = None
            self._reached.set()
        return self._closing


def set_real_time(priority: int | None, cpu: int | None, lock_memory: bool) -> None:
    """Ask Linux for real-time scheduling, one CPU, and memory that is never paged out.

    Raises:
        RfmsError: not permitted here; the message says how to permit it.
    """
    if cpu is not None:
        try:
            os.sched_setaffinity(0, {cpu})
        except (OSError, ValueError) as error:
            allowed = ", ".join(map(str, sorted(os.sched_getaffinity(0))))
            raise RfmsError(f"--cpu {cpu}: {error}; allowed here: {allowed}") from error
    if lock_memory and ctypes.CDLL(None, use_errno=True).mlockall(_MCL_CURRENT_AND_FUTURE):
        reason = os.strerror(ctypes.get_errno())
        raise RfmsError(f"--mlockall: {reason}; raise 'ulimit -l' or give CAP_IPC_LOCK")
    if priority is not None:
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
        except (OSError, ValueError) as error:
            raise RfmsError(
                f"--fifo {priority}: {error}; needs CAP_SYS_NICE or an rtprio limit, 1 to 99"
            ) from error

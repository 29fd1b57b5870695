"""A lock whose waiters are served in the order in which they came."""

import threading
from collections import deque
from types import TracebackType


class Turns:
    """A lock for the threads of a program.

    ``threading.Lock`` is not fair: a thread that releases it and takes it again at once, as a loop
    of short waits does, may keep another one out for ever.
    """

    __slots__ = ("_guard", "_queue", "_taken")

    def __init__(self) -> None:
        self._guard = threading.Lock()
        self._queue: deque[threading.Lock] = deque()
        self._taken = False

    def __enter__(self) -> None:
        with self._guard:
            if not self._taken:
                self._taken = True
                return
            ticket = threading.Lock()
            ticket.acquire()
            self._queue.append(ticket)
        try:
            ticket.acquire()
        except BaseException:  # a signal: the turn is given up, or passed on if it has come
            with self._guard:
                waiting = ticket in self._queue
                if waiting:
                    self._queue.remove(ticket)
            if not waiting:
                self._next()
            raise

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._next()

    def _next(self) -> None:
        with self._guard:
            if self._queue:
                self._queue.popleft().release()
            else:
                self._taken = False

"""Concurrent parts of one program: when time advances, and which part a reply wakes.

In virtual time and lockstep a program is part of the clock, so time may advance only when all its
parts wait: their conditions are then sent to the server as one wait. In real time they are sent
immediately. The server keeps one wait of a session; a later one replaces it, and has to contain all
conditions that are still waited for.
"""

import asyncio
from collections.abc import Callable, Coroutine, Sequence
from typing import Any

from rfms_can.messages import AnyCondition


class Waiting:
    """A part that waits until one of its conditions holds."""

    __slots__ = ("any_of", "future")

    def __init__(self, any_of: Sequence[AnyCondition]) -> None:
        self.any_of = any_of
        self.future: asyncio.Future[None] = asyncio.get_running_loop().create_future()

    def wake(self, error: Exception | None = None) -> None:
        """Let it continue, or fail with an error."""
        if self.future.done():
            return
        if error is None:
            self.future.set_result(None)
        else:
            self.future.set_exception(error)


class Parts:
    """The live parts of a program, and those that wait.

    Args:
        begin: sends a wait for the conditions of these parts to the server.

    Attributes:
        at_once: whether a wait is sent as soon as one part waits: in real time.
    """

    def __init__(self, begin: Callable[[Sequence[Waiting]], None]) -> None:
        self._begin = begin
        self._live = 1
        self._waiting: list[Waiting] = []
        self._asked: Sequence[Waiting] = ()
        self._failure: Exception | None = None
        self.at_once = False

    async def wait(self, any_of: Sequence[AnyCondition]) -> None:
        """Wait until one of the conditions holds.

        Raises:
            RfmsError: the server answers no waits any more.
        """
        if self._failure is not None:
            raise self._failure
        waiting = Waiting(any_of)
        self._waiting.append(waiting)
        try:
            self.look()
            await waiting.future
        finally:
            if waiting in self._waiting:  # cancelled
                self._waiting.remove(waiting)

    def woken(self, asked: Sequence[Waiting], held: Sequence[int]) -> None:
        """Handle the server's answer to a wait.

        Args:
            asked: the parts whose conditions it had, in their order.
            held: indices of the conditions that hold; empty if another wait has replaced it.
        """
        owners = [waiting for waiting in asked for _ in waiting.any_of]
        for index in held:
            owner = owners[index]
            if owner in self._waiting:
                self._waiting.remove(owner)
                owner.wake()
        if held:
            if asked is self._asked:
                self._asked = ()
            self.look()

    def refused(self, asked: Sequence[Waiting], error: Exception) -> None:
        """A wait was refused: the parts that are in it fail; they may wait for something else."""
        if asked is self._asked:
            self._asked = ()
        for one in asked:
            if one in self._waiting:
                self._waiting.remove(one)
                one.wake(error)

    def fail(self, error: Exception) -> None:
        """Fail all waiting parts: no wait will be answered any more."""
        self._failure = error
        waiting, self._waiting = self._waiting, []
        for one in waiting:
            one.wake(error)

    def look(self) -> None:
        """Send a wait if all parts wait, or in real time if any of them does."""
        waiting = tuple(self._waiting)
        if not waiting or waiting == self._asked:
            return
        if self.at_once or len(waiting) >= self._live:
            self._asked = waiting
            self._begin(waiting)

    async def run(self, coroutines: Sequence[Coroutine[Any, Any, Any]]) -> list[Any]:
        """Run coroutines as concurrent parts, in place of the calling part.

        Returns:
            Their results, in order.

        Raises:
            BaseException: of one of them; the others have been cancelled.
        """
        group = _Group(len(coroutines))
        self._live += group.live - 1
        tasks = [asyncio.create_task(self._part(one, group)) for one in coroutines]
        group.tasks.extend(tasks)
        try:
            if tasks:
                await asyncio.wait(tasks, return_when=asyncio.FIRST_EXCEPTION)
        finally:
            group.cancel()
            ended = await asyncio.gather(*tasks, return_exceptions=True)
            self._live -= group.live - 1
            for one in coroutines:
                one.close()  # those that never began
        errors = [one for one in ended if isinstance(one, BaseException)]
        errors.sort(key=lambda error: isinstance(error, asyncio.CancelledError))
        if errors:
            raise errors[0]
        return list(ended)

    async def _part(self, coroutine: Coroutine[Any, Any, Any], group: "_Group") -> Any:
        """One part; the last one to end is replaced by the part that ran them all."""
        try:
            result = await coroutine
        except BaseException:
            group.cancel()
            raise
        if group.live > 1:
            group.live -= 1
            self._live -= 1
            self.look()
        return result


class _Group:
    """Parts that were started together."""

    __slots__ = ("live", "tasks")

    def __init__(self, live: int) -> None:
        self.live = live
        self.tasks: list[asyncio.Task[Any]] = []

    def cancel(self) -> None:
        """Cancel the parts that are still running."""
        for task in self.tasks:
            if task is not asyncio.current_task():
                task.cancel()

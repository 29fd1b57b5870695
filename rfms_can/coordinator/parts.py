"""Parts of one program that run side by side: when time goes on, and whom a reply wakes.

In virtual time and lockstep a program is part of the clock, so time may go on only when all its
parts wait: what they wait for goes to the server as one wait then. In real time it goes at once.
The server keeps one wait of a session; a later one takes its place, and has to name all that is
still waited for.
"""

import asyncio
from collections.abc import Callable, Coroutine, Sequence
from typing import Any

from rfms_can.messages import AnyCondition


class Waiting:
    """A part that waits until one of some conditions holds."""

    __slots__ = ("any_of", "future")

    def __init__(self, any_of: Sequence[AnyCondition]) -> None:
        self.any_of = any_of
        self.future: asyncio.Future[None] = asyncio.get_running_loop().create_future()

    def wake(self, error: Exception | None = None) -> None:
        """Let it go on, or fail."""
        if self.future.done():
            return
        if error is None:
            self.future.set_result(None)
        else:
            self.future.set_exception(error)


class Parts:
    """The live parts of a program, and those of them that wait.

    Args:
        begin: asks the server to answer when a condition of any of these holds.

    Attributes:
        at_once: whether the server is asked as soon as one part waits: in real time.
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
            RfmsError: no wait is answered any more.
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
        """The server has answered a wait.

        Args:
            asked: whose conditions it had, in their order.
            held: indices of those that hold; none if another wait has taken its place.
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

    def fail(self, error: Exception) -> None:
        """No wait will be answered any more: all parts that wait are told why."""
        self._failure = error
        waiting, self._waiting = self._waiting, []
        for one in waiting:
            one.wake(error)

    def look(self) -> None:
        """Ask the server if it is time to: all parts wait, or in real time any of them."""
        waiting = tuple(self._waiting)
        if not waiting or waiting == self._asked:
            return
        if self.at_once or len(waiting) >= self._live:
            self._asked = waiting
            self._begin(waiting)

    async def run(self, coroutines: Sequence[Coroutine[Any, Any, Any]]) -> list[Any]:
        """Run coroutines as parts beside one another, in place of the part that asks for it.

        Returns:
            Their results, in order.

        Raises:
            BaseException: the error of one of them; the others have been cancelled.
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
        """One part; the last to end leaves its place to the part that ran them all."""
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
    """Parts that were begun together."""

    __slots__ = ("live", "tasks")

    def __init__(self, live: int) -> None:
        self.live = live
        self.tasks: list[asyncio.Task[Any]] = []

    def cancel(self) -> None:
        """End those that go on yet."""
        for task in self.tasks:
            if task is not asyncio.current_task():
                task.cancel()

"""What a program uses of a link, and for how long: between the API and the link of either kind.

One thread at a time speaks to the link; a program that polls while time stands still is told so; a
signal ends the program at once where its own code runs, and between two events where the link
works; after the end of the program, or of the block of ``connect``, every use is one clear error.
"""

import time
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Any, Final, Self

from rfms_can.coordinator.conversation import REALTIME
from rfms_can.coordinator.link import AsyncLink, Link
from rfms_can.coordinator.turns import Turns
from rfms_can.errors import ProgramError
from rfms_can.messages import (
    Answer,
    AnyCondition,
    ArmRequest,
    MoveOutcome,
    Status,
    TransformMessage,
)

STANDSTILL_S: Final = 5.0
"""Wall time for which a program may poll the arm while no cycle closes, s."""
POLL_S: Final = 2.0
"""Longest wall time between two polls of one loop, s; a person at a prompt takes longer."""
POLLS: Final = 5
"""Polls that make a loop."""


class StandstillWatch:
    """Notices a program that polls an arm for which time stands still, because nothing waits.

    Args:
        remedy: what the program should call, for the error.
        now: wall time, s, monotonic.
    """

    def __init__(self, remedy: str, now: Callable[[], float] = time.monotonic) -> None:
        self._remedy = remedy
        self._now = now
        self._cycle: int | None = None
        self._polls = 0
        self._since = self._last = 0.0

    def progress(self) -> None:
        """The program does something else than polling."""
        self._polls = 0

    def poll(self, status: Status) -> None:
        """The program reads the arm's state, or sends an observation.

        Raises:
            ProgramError: it has polled for ``STANDSTILL_S`` and no cycle has closed.
        """
        if status.clock == REALTIME:
            return
        now = self._now()
        if not self._polls or status.cycle != self._cycle or now - self._last > POLL_S:
            self._cycle, self._since, self._polls = status.cycle, now, 0
        self._last = now
        self._polls += 1
        stood = now - self._since
        if stood >= STANDSTILL_S and self._polls >= POLLS:
            raise ProgramError(
                f"the program has polled the arm for {stood:.0f} s of wall time and no cycle has "
                f"closed: on clock '{status.clock}' time passes only while the program waits; call "
                f"{self._remedy} in the loop instead of time.sleep()"
            )


class ProgramLink:
    """``Link`` of a program, for all its threads; a context manager around the program.

    Args:
        link: used by one thread at a time; while it waits the others wait for their turn.
        interrupted: whether the program is to end.
        program_runs: told True where the program's own code runs, and a signal may raise at once;
            False where the link works.
        now: wall time, s, monotonic.

    Attributes:
        ending: whether the program ends and another thread's wait is to be cut short.
    """

    def __init__(
        self,
        link: Link,
        *,
        interrupted: Callable[[], bool] = lambda: False,
        program_runs: Callable[[bool], None] = lambda _: None,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self.ending = self._ended = False
        self._link = link
        self._interrupted = interrupted
        self._program_runs = program_runs
        self._turns = Turns()
        self._watch = StandstillWatch("arm.sleep(seconds) or arm.wait(move)", now)

    def __enter__(self) -> Self:
        self._program_runs(True)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._program_runs(False)
        self.ending = self._ended = True
        with self._turns:  # until no other thread uses the link
            self.ending = False

    def request(self, message: ArmRequest) -> Answer:
        """See ``Link.request``; also ``ProgramError`` after the end, or while time stands still."""
        with self._turn():
            if _is_observation(message):
                self._watch.poll(self._link.status())
                return self._link.request(message)
            answer = self._link.request(message)
            self._watch.progress()
            return answer

    def wait(self, *any_of: AnyCondition) -> None:
        """See ``Link.wait``; also ``ProgramError`` after the end.

        Raises:
            KeyboardInterrupt: the program was interrupted.
        """
        with self._turn():
            try:
                self._link.wait(*any_of)
            except KeyboardInterrupt:
                self._check()
                raise

    def outcomes(self, first: int, last: int) -> list[MoveOutcome]:
        """See ``Link.outcomes``; raises as ``status`` does, since a loop may poll it."""
        with self._turn():
            self._polled()
            return self._link.outcomes(first, last)

    def status(self) -> Status:
        """The arm's state; raises as ``request`` does, and ``KeyboardInterrupt``."""
        with self._turn():
            return self._polled()

    def time(self) -> float:
        """The server's time, s; raises as ``status`` does."""
        with self._turn():
            self._polled()
            return self._link.time()

    def _polled(self) -> Status:
        if self._interrupted():
            raise KeyboardInterrupt
        status = self._link.status()
        self._watch.poll(status)
        return status

    def _check(self) -> None:
        if self._ended:
            raise _over()

    @contextmanager
    def _turn(self) -> Iterator[None]:
        """The link is this thread's; a signal that comes meanwhile raises afterwards."""
        before = self._interrupted()
        self._program_runs(False)
        try:
            with self._turns:
                self._check()
                yield
        finally:
            self._program_runs(not self._ended)
        if not before and self._interrupted():
            raise KeyboardInterrupt


class AsyncProgramLink:
    """``AsyncLink`` of a program, as ``ProgramLink``: signals are the event loop's.

    Args:
        link: of the program.
        now: wall time, s, monotonic.
    """

    def __init__(self, link: AsyncLink, now: Callable[[], float] = time.monotonic) -> None:
        self._link = link
        self._ended = False
        remedy = "await arm.sleep(seconds) or await arm.wait(move)"
        self._watch = StandstillWatch(remedy, now)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._ended = True

    async def request(self, message: ArmRequest) -> Answer:
        """See ``ProgramLink.request``."""
        self._check()
        if _is_observation(message):
            self._watch.poll(self._link.status())
            return await self._link.request(message)
        answer = await self._link.request(message)
        self._watch.progress()
        return answer

    async def wait(self, *any_of: AnyCondition) -> None:
        """See ``AsyncLink.wait``; also ``ProgramError`` after the end."""
        self._check()
        await self._link.wait(*any_of)

    async def outcomes(self, first: int, last: int) -> list[MoveOutcome]:
        """See ``ProgramLink.outcomes``."""
        self.status()
        return await self._link.outcomes(first, last)

    async def run(self, *parts: Coroutine[Any, Any, Any]) -> list[Any]:
        """See ``AsyncLink.run``; also ``ProgramError`` after the end."""
        if self._ended:
            for part in parts:
                part.close()
        self._check()
        return await self._link.run(*parts)

    def status(self) -> Status:
        """See ``ProgramLink.status``."""
        self._check()
        status = self._link.status()
        self._watch.poll(status)
        return status

    def time(self) -> float:
        """See ``ProgramLink.time``."""
        self.status()
        return self._link.time()

    def _check(self) -> None:
        if self._ended:
            raise _over()


def _is_observation(message: ArmRequest) -> bool:
    return isinstance(message, TransformMessage) and message.kind == "reference"


def _over() -> ProgramError:
    return ProgramError(
        "the arm was used after its program, or its block of connect(), had ended: move the call "
        "into the block, or connect again"
    )

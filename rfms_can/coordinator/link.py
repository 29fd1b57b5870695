"""Interface of a program to the server: requests, answers, the arm's state, and waiting."""

from collections.abc import Coroutine
from typing import Any, Protocol

from rfms_can.messages import Answer, AnyCondition, ArmRequest, MoveOutcome, Status


class State(Protocol):
    """The arm's state that is available without a request."""

    def status(self) -> Status:
        """The arm's state, as of the last closed cycle."""

    def time(self) -> float:
        """The server's time, s; in real time it may lag behind by less than a period."""


class Link(State, Protocol):
    """Connection to the server: in the same process, or over a network."""

    def request(self, message: ArmRequest) -> Answer:
        """Send a request.

        Raises:
            ProgramError: the server refuses it; nothing has changed.
            FaultError: the run was halted.
            LinkError: the server does not answer.
        """

    def wait(self, *any_of: AnyCondition) -> None:
        """Let time advance until one of the conditions holds.

        Raises:
            FaultError: the run was halted.
            LeaseError: the lease has lapsed; the arm is brought to rest.
            LinkError: the server does not answer.
        """

    def outcomes(self, first: int, last: int) -> list[MoveOutcome]:
        """How the moves of these numbers ended; also after a fault, or when the lease was lost.

        Raises:
            ProgramError: there are no such moves, or they are too long ago.
            LinkError: the server does not answer.
        """


class AsyncLink(State, Protocol):
    """``Link`` for coroutines, several of which may wait concurrently."""

    async def request(self, message: ArmRequest) -> Answer:
        """As ``Link.request``."""

    async def wait(self, *any_of: AnyCondition) -> None:
        """As ``Link.wait``."""

    async def outcomes(self, first: int, last: int) -> list[MoveOutcome]:
        """As ``Link.outcomes``."""

    async def run(self, *parts: Coroutine[Any, Any, Any]) -> list[Any]:
        """Run coroutines as concurrent parts of one program; their results."""

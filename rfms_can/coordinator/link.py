"""What a program needs of the server: requests in, answers and state out, time in between."""

from collections.abc import Coroutine
from typing import Any, Protocol

from rfms_can.messages import Answer, AnyCondition, ArmRequest, Status


class State(Protocol):
    """What is known of the arm without asking."""

    def status(self) -> Status:
        """The arm's state, as of the last closed cycle."""

    def time(self) -> float:
        """The server's time, s; in real time it may lag behind by less than a period."""


class Link(State, Protocol):
    """A way to the server: in the same process, or over a network."""

    def request(self, message: ArmRequest) -> Answer:
        """Hand a message over.

        Raises:
            ProgramError: the server refuses it; nothing has changed.
            FaultError: the run was halted.
            LinkError: the server does not answer.
        """

    def wait(self, *any_of: AnyCondition) -> None:
        """Let time go on until one of some conditions holds.

        Raises:
            FaultError: the run was halted.
            LeaseError: the lease has lapsed; the arm is brought to rest.
            LinkError: the server does not answer.
        """


class AsyncLink(State, Protocol):
    """``Link`` for coroutines, several of which may wait side by side."""

    async def request(self, message: ArmRequest) -> Answer:
        """As ``Link.request``."""

    async def wait(self, *any_of: AnyCondition) -> None:
        """As ``Link.wait``."""

    async def run(self, *parts: Coroutine[Any, Any, Any]) -> list[Any]:
        """Run coroutines as parts of one program; their results."""

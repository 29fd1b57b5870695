"""Steps of a task: each is data, says itself in the words of the program API, and does that.

A step does not call the arm: it yields its requests, and is sent the answers. So one description
serves ``Arm`` and ``AsyncArm``, and what is printed stands beside what is done.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Generator
from dataclasses import dataclass, field
from typing import Any, Final

from rfms_can.coordinator import MoveOutcome, ProgramError
from rfms_can.task.frames import Parts, Scope, unknown
from rfms_can.task.words import Words

LONGEST_NAME: Final = 64
"""Characters of a name on the server."""

Request = Callable[[Any], Any]
"""A call of the program API: of ``Arm`` it gives the answer, of ``AsyncArm`` an awaitable of it."""

Doing = Generator[Request, Any, None]
"""Requests, each answered before the next."""


@dataclass
class Run:
    """A task being run.

    Attributes:
        scope: names and values of the task.
        moves: numbers of its moves, in order.
        outcomes: how they ended.
        travelled: distance of the last guarded approach, m.
        depth: of the last insertion, m.
    """

    scope: Scope
    moves: list[int] = field(default_factory=list)
    outcomes: list[MoveOutcome] = field(default_factory=list)
    travelled: float | None = None
    depth: float | None = None

    def move(self, position: str, mode: str) -> Generator[Request, Any, int]:
        """Request a move; its number."""
        to, with_mode = self.scope.full(position), self.scope.full(mode)
        number: int = yield lambda arm: arm.move(to, with_mode)
        self.moves.append(number)
        return number

    def wait(self, number: int) -> Doing:
        """Wait for a move."""
        yield lambda arm: arm.wait(number)

    def outcome(self, number: int) -> Generator[Request, Any, MoveOutcome]:
        """How a move ended."""
        told: MoveOutcome = yield lambda arm: arm.outcome(number)
        return told


class Step(ABC):
    """One step."""

    @abstractmethod
    def lines(self, words: Words) -> list[str]:
        """The step as lines of a program."""

    @abstractmethod
    def calls(self, run: Run) -> Doing:
        """What it requests of the arm."""

    @abstractmethod
    def check(self, names: "TaskNames") -> None:
        """Refuse what cannot be, before anything is requested.

        Raises:
            ProgramError: or the class of it that the program API would raise.
        """


@dataclass(frozen=True)
class TaskNames:
    """What the definitions of a task have made: what its steps may use.

    Attributes:
        scope: of the task.
        positions, modes: names within the task.
    """

    scope: Scope
    positions: tuple[str, ...]
    modes: tuple[str, ...]

    def length(self, name: str) -> None:
        """Refuse a name that with the task's is too long for the server."""
        full = self.scope.full(name)
        if len(full) > LONGEST_NAME:
            raise ProgramError(
                f"{full!r} has {len(full)} characters, {LONGEST_NAME} are the most: give the "
                f"motion a shorter name=, or the task, named()"
            )

    def parts(self, what: str, parts: Parts) -> None:
        """Refuse a product with a transform that the task does not define."""
        for part in parts:
            if part.ours and part.name not in self.scope.values:
                unknown(f"{what}: transform", part.name, tuple(self.scope.values))

    def move(self, position: str, mode: str) -> None:
        """Refuse a move to or with what the task does not define."""
        if position not in self.positions:
            unknown(f"move to {position!r} with {mode!r}: position", position, self.positions)
        if mode not in self.modes:
            unknown(f"move to {position!r} with {mode!r}: mode", mode, self.modes)

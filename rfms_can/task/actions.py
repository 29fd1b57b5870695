"""Steps that move the arm, and what belongs to moves: compliance, gripper, tare, time."""

from dataclasses import dataclass
from typing import Final

from rfms_can.coordinator import definitions
from rfms_can.task.checks import number
from rfms_can.task.steps import Doing, Run, Step, TaskNames
from rfms_can.task.words import Words, quoted

LONGEST_S: Final = 1e6
"""Longest sleep, s: that of the program API."""


@dataclass(frozen=True)
class Move(Step):
    """``arm.move``.

    Attributes:
        position, mode: names within the task.
        wait: whether to wait for it; otherwise it blends into the next move.
    """

    position: str
    mode: str
    wait: bool = True

    def lines(self, words: Words) -> list[str]:
        """See :class:`Step`."""
        move = words.move(self.position, self.mode)
        return [f"arm.wait({move})" if self.wait else f"number = {move}"]

    def calls(self, run: Run) -> Doing:
        """See :class:`Step`."""
        made = yield from run.move(self.position, self.mode)
        if self.wait:
            yield from run.wait(made)

    def check(self, names: TaskNames) -> None:
        """See :class:`Step`."""
        names.move(self.position, self.mode)


@dataclass(frozen=True)
class Comply(Step):
    """``arm.comply``, from the next move on; it outlasts the task unless a ``Lock`` follows.

    Attributes:
        bias: compliant directions, each with its bias force or moment, N or N m.
    """

    bias: dict[str, float]

    def lines(self, words: Words) -> list[str]:
        """See :class:`Step`."""
        values = "".join(f", {float(value)!r}" for value in self.bias.values())
        return [f"arm.comply({quoted(' '.join(self.bias))}{values})"]

    def calls(self, run: Run) -> Doing:
        """See :class:`Step`."""
        word, values = " ".join(self.bias), [float(value) for value in self.bias.values()]
        yield lambda arm: arm.comply(word, *values)

    def check(self, names: TaskNames) -> None:
        """See :class:`Step`."""
        definitions.comply(" ".join(self.bias), tuple(self.bias.values()))


@dataclass(frozen=True)
class Lock(Step):
    """``arm.lock``, from the next move on.

    Attributes:
        word: directions that comply no longer.
    """

    word: str

    def lines(self, words: Words) -> list[str]:
        """See :class:`Step`."""
        return [f"arm.lock({quoted(self.word)})"]

    def calls(self, run: Run) -> Doing:
        """See :class:`Step`."""
        yield lambda arm: arm.lock(self.word)

    def check(self, names: TaskNames) -> None:
        """See :class:`Step`."""
        definitions.lock(self.word)


@dataclass(frozen=True)
class Grip(Step):
    """``arm.gripper``.

    Attributes:
        opens: whether it opens.
        force: fraction of the full force, more than 0, up to 1.
    """

    opens: bool
    force: float = 1.0

    def lines(self, words: Words) -> list[str]:
        """See :class:`Step`."""
        return [f"arm.gripper.{'open' if self.opens else 'close'}({float(self.force)!r})"]

    def calls(self, run: Run) -> Doing:
        """See :class:`Step`."""
        if self.opens:
            yield lambda arm: arm.gripper.open(self.force)
        else:
            yield lambda arm: arm.gripper.close(self.force)

    def check(self, names: TaskNames) -> None:
        """See :class:`Step`."""
        definitions.gripper(self.opens, self.force)


@dataclass(frozen=True)
class Tare(Step):
    """``arm.tare``: the wrist sensor's bias, at rest and without contact."""

    def lines(self, words: Words) -> list[str]:
        """See :class:`Step`."""
        return ["arm.tare()"]

    def calls(self, run: Run) -> Doing:
        """See :class:`Step`."""
        yield lambda arm: arm.tare()

    def check(self, names: TaskNames) -> None:
        """See :class:`Step`: nothing can be wrong with it."""


@dataclass(frozen=True)
class Sleep(Step):
    """``arm.sleep``.

    Attributes:
        seconds: 0 to a million.
    """

    seconds: float

    def lines(self, words: Words) -> list[str]:
        """See :class:`Step`."""
        return [f"arm.sleep({float(self.seconds)!r})"]

    def calls(self, run: Run) -> Doing:
        """See :class:`Step`."""
        yield lambda arm: arm.sleep(self.seconds)

    def check(self, names: TaskNames) -> None:
        """See :class:`Step`."""
        number("sleep", "seconds", self.seconds, 0.0, LONGEST_S, "s")

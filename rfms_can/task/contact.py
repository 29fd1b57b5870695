"""Steps that end on what they meet: a guarded approach, an insertion; and following a frame."""

import math
from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import Any, Final

from rfms_can.coordinator import Outcome, ProgramError, Transform
from rfms_can.task.frames import Part, Parts
from rfms_can.task.steps import Doing, Request, Run, Step, TaskNames
from rfms_can.task.words import Words, call, escaped, quoted

_NO_CONTACT: Final = (
    "{}: no contact after {{:.1f}} mm, the end of its guarded move: is the part there? "
    "give a larger at_most, or a smaller force"
)
_STUCK: Final = "{}: {{:.1f}} of {:g} mm deep: {{}}"
_SHORT: Final = "it goes no further"


@dataclass(frozen=True)
class Touch(Step):
    """A guarded move that has to end on contact.

    Attributes:
        label: what it is called in the error.
        position, mode: names within the task; the mode has ``stop_on_force``.
    """

    label: str
    position: str
    mode: str

    @property
    def _no_contact(self) -> str:
        return _NO_CONTACT.format(escaped(self.label))

    def lines(self, words: Words) -> list[str]:
        """See :class:`Step`."""
        return [
            "here = arm.pose",
            f"number = {words.move(self.position, self.mode)}",
            "arm.wait(number)",
            "travelled = math.hypot(*(here.inverse() @ arm.pose).apply((0.0, 0.0, 0.0)))",
            "if arm.outcome(number).how is not Outcome.GUARDED:",
            *_raising(self._no_contact, "1e3 * travelled", indent=1),
        ]

    def calls(self, run: Run) -> Doing:
        """See :class:`Step`."""
        here: Transform = yield lambda arm: arm.pose
        number = yield from run.move(self.position, self.mode)
        yield from run.wait(number)
        outcome = yield from run.outcome(number)
        there: Transform = yield lambda arm: arm.pose
        run.travelled = math.hypot(*(here.inverse() @ there).apply((0.0, 0.0, 0.0)))
        if outcome.how is not Outcome.GUARDED:
            raise ProgramError(self._no_contact.format(1e3 * run.travelled))

    def check(self, names: TaskNames) -> None:
        """See :class:`Step`."""
        names.move(self.position, self.mode)


@dataclass(frozen=True)
class Insertion(Step):
    """Moves down a hole, one after the other, none of which its guard may end.

    Attributes:
        label: what it is called in the error.
        peg, hole: the end of the peg in T6, and the mouth, z into it; frames of the task.
        legs: positions and modes of the moves.
        depth: of the last of them, m.
        tolerance: how much short of it the peg may end, m.
    """

    label: str
    peg: Parts
    hole: Parts
    legs: tuple[tuple[str, str], ...]
    depth: float
    tolerance: float

    @property
    def _stuck(self) -> str:
        return _STUCK.format(escaped(self.label), 1e3 * self.depth)

    def lines(self, words: Words) -> list[str]:
        """See :class:`Step`."""
        legs = (
            f"    ({words.variable('position', to)}, {words.variable('mode', mode)}),"
            for to, mode in self.legs
        )
        return [
            f"mouth = {words.value(self.hole)}",
            f"end = {words.value(self.peg)}",
            "for goal, mode in (",
            *legs,
            "):",
            "    number = arm.move(goal, mode)",
            "    arm.wait(number)",
            "    depth = (mouth.inverse() @ arm.pose @ end).pz",
            "    if arm.outcome(number).how is not Outcome.MADE:",
            *_raising(self._stuck, "1e3 * depth", "arm.outcome(number).reason", indent=2),
            f"if depth < {self.depth - self.tolerance!r}:",
            *_raising(self._stuck, "1e3 * depth", quoted(_SHORT), indent=1),
        ]

    def calls(self, run: Run) -> Doing:
        """See :class:`Step`."""
        hole, peg = (run.scope.value(self.label, parts) for parts in (self.hole, self.peg))
        outward, depth = hole.inverse(), 0.0
        for position, mode in self.legs:
            number = yield from run.move(position, mode)
            yield from run.wait(number)
            outcome = yield from run.outcome(number)
            pose: Transform = yield lambda arm: arm.pose
            depth = run.depth = (outward @ pose @ peg).pz
            if outcome.how is not Outcome.MADE:
                raise ProgramError(self._stuck.format(1e3 * depth, outcome.reason))
        if depth < self.depth - self.tolerance:
            raise ProgramError(self._stuck.format(1e3 * depth, _SHORT))

    def check(self, names: TaskNames) -> None:
        """See :class:`Step`."""
        for parts in (self.hole, self.peg):
            names.parts(self.label, parts)
            names.scope.value(self.label, parts)
        for position, mode in self.legs:
            names.move(position, mode)


Look = Callable[[Any], Any]
"""Called with the arm; of an ``AsyncArm`` it may be a coroutine function."""


@dataclass(frozen=True)
class Follow(Step):
    """A move to a frame that moves, and staying there.

    Attributes:
        position, mode: names within the task.
        duration: how long to stay there, s; None: until ``until`` is true.
        until: asked every so often, once it is there, whether to end.
        look: called every so often, from the beginning on: sends an observation, say.
        every: time between two looks, s.
        rest: what the arm lets go of the frame with, as it would follow where it rests: a
            transform, which becomes the place it has been stopped at, a position there, and a mode.
            None: it goes on following.
    """

    position: str
    mode: str
    duration: float | None = None
    until: Look | None = None
    look: Look | None = None
    every: float = 0.02
    rest: tuple[str, str, str] | None = None

    def lines(self, words: Words) -> list[str]:
        """See :class:`Step`."""
        pause = [
            f"    arm.sleep({self.every!r})",
            *([] if self.look is None else ["    look(arm)"]),
        ]
        goes_on = [] if self.duration is None else ["arm.time < ends"]
        goes_on += [] if self.until is None else ["not until(arm)"]
        return [
            *(f"{name} = {_name(given)}" for name, given in self._callables()),
            f"number = {words.move(self.position, self.mode)}",
            "while arm.status.completed < number:",
            *pause,
            "arm.wait(number)",
            *([] if self.duration is None else [f"ends = arm.time + {self.duration!r}"]),
            f"while {' and '.join(goes_on)}:",
            *pause,
            *self._rest_lines(words),
        ]

    def calls(self, run: Run) -> Doing:
        """See :class:`Step`."""
        number = yield from run.move(self.position, self.mode)
        while (yield lambda arm: arm.status.completed) < number:
            yield from self._pause()
        yield from run.wait(number)
        ends = None
        if self.duration is not None:
            ends = (yield lambda arm: arm.time) + self.duration
        while not (yield from self._over(ends)):
            yield from self._pause()
        if self.rest is not None:
            here, position, mode = self.rest
            name = run.scope.full(here)
            yield lambda arm: arm.stop()
            yield lambda arm: arm.transform(name, arm.pose)
            yield from run.wait((yield from run.move(position, mode)))

    def check(self, names: TaskNames) -> None:
        """See :class:`Step`."""
        names.move(self.position, self.mode)
        if self.rest is not None:
            here, position, mode = self.rest
            names.parts("rest", (Part(here, True),))
            names.move(position, mode)

    def _rest_lines(self, words: Words) -> list[str]:
        if self.rest is None:
            return []
        here, position, mode = self.rest
        return [
            "arm.stop()",
            f"arm.transform({words.full(here)}, arm.pose)",
            f"arm.wait({words.move(position, mode)})",
        ]

    def _pause(self) -> Doing:
        yield lambda arm: arm.sleep(self.every)
        if self.look is not None:
            yield self.look

    def _over(self, ends: float | None) -> Generator[Request, Any, bool]:
        if ends is not None and (yield lambda arm: arm.time) >= ends:
            return True
        return self.until is not None and bool((yield self.until))

    def _callables(self) -> list[tuple[str, Look]]:
        given = (("until", self.until), ("look", self.look))
        return [(name, one) for name, one in given if one is not None]


def _raising(message: str, *values: str, indent: int) -> list[str]:
    """The error of a step, as lines of a program."""
    lines = call("raise ProgramError", [f"{quoted(message)}.format({', '.join(values)})"])
    return [f"{'    ' * indent}{line}" for line in lines]


def _name(given: Look) -> str:
    """What the program calls it; its own business if it has no name."""
    name = getattr(given, "__name__", "")
    return name if name.isidentifier() else "..."

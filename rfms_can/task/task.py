"""A task: steps as data, printed as a program, changed, and run by the program API."""

from collections.abc import Generator, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any, TypeVar

from rfms_can.coordinator import Arm, AsyncArm, MoveOutcome, ProgramError
from rfms_can.task.actions import Move
from rfms_can.task.contact import Follow, Insertion, Touch
from rfms_can.task.definitions import DefineMode, DefinePosition, DefineTransform, Definition
from rfms_can.task.frames import Part, Scope, unknown
from rfms_can.task.running import doing_of, drive, drive_async
from rfms_can.task.steps import Request, Run, Step, TaskNames
from rfms_can.task.words import Words

Defined = TypeVar("Defined", bound=Definition)


@dataclass(frozen=True)
class Report:
    """How a task went.

    Attributes:
        outcomes: of its moves, in order.
        travelled: distance of the last guarded approach from its start to contact, m; None
            without one.
        depth: of the last insertion, m; None without one.
    """

    outcomes: tuple[MoveOutcome, ...]
    travelled: float | None = None
    depth: float | None = None


@dataclass(frozen=True)
class Task:
    """Steps that relate frames by motions: a value, of which changes make others.

    ``print(task)`` says it in the words of the program API. ``a + b`` is both, one after the other,
    with the name of the first; definitions come first, those they share once.

    Attributes:
        name: of the task, and of all it defines on the server: ``name/...``.
        steps: definitions, then what is done.
    """

    name: str
    steps: tuple[Step, ...]

    def __post_init__(self) -> None:
        """Put definitions first, and refuse what cannot be.

        Raises:
            ProgramError: or the class of it that the program API would raise: a definition or a
                step is invalid, uses what the task does not define, or is made twice, differently.
        """
        if not isinstance(self.name, str) or not self.name:
            raise ProgramError(f"task {self.name!r}: its name is a text, not empty")
        made = _unique(self.steps)
        others = [step for step in self.steps if not isinstance(step, Definition)]
        object.__setattr__(self, "steps", (*made, *others))
        names = TaskNames(
            self.scope,
            tuple(step.name for step in made if isinstance(step, DefinePosition)),
            tuple(step.name for step in made if isinstance(step, DefineMode)),
        )
        for definition in made:
            names.length(definition.name)
        for step in self.steps:
            step.check(names)

    @property
    def scope(self) -> Scope:
        """Its names on the server, and the values of its transforms."""
        values = {s.name: s.value for s in self.steps if isinstance(s, DefineTransform)}
        return Scope(self.name, values)

    def __add__(self, other: "Task") -> "Task":
        if not isinstance(other, Task):
            return NotImplemented
        return Task(self.name, self.steps + other.steps)

    def __str__(self) -> str:
        words = Words(self.scope)
        lines = [words.foreign(part) for part in self._foreign()]
        for step in self.steps:
            lines += step.lines(words)
        motions = [
            step for step in self.steps if isinstance(step, Move | Touch | Insertion | Follow)
        ]
        if motions and isinstance(motions[-1], Move) and not motions[-1].wait:
            lines.append("arm.wait(number)")
        return "\n".join(lines)

    # --- to look at, and to change ------------------------------------------------------------

    def named(self, name: str) -> "Task":
        """The same task by another name."""
        return replace(self, name=name)

    def transform(self, name: str) -> DefineTransform:
        """The definition of a transform.

        Args:
            name: within the task; what stands behind the last ``": "`` if only one has that.

        Raises:
            ProgramError: the task does not define it, or several such.
        """
        return self._one(
            [s for s in self.steps if isinstance(s, DefineTransform)], "transform", name
        )

    def position(self, name: str) -> DefinePosition:
        """The definition of a position; name and errors as of :meth:`transform`."""
        return self._one([s for s in self.steps if isinstance(s, DefinePosition)], "position", name)

    def mode(self, name: str) -> DefineMode:
        """The definition of a mode; name and errors as of :meth:`transform`."""
        return self._one([s for s in self.steps if isinstance(s, DefineMode)], "mode", name)

    def change(self, name: str, **changes: Any) -> "Task":
        """A task in which one definition is another.

        Args:
            name: of a transform, a position or a mode, as of :meth:`transform`.
            **changes: ``value`` of a transform, ``tool``, ``at`` or ``config`` of a position,
                settings of a mode: a time or speeds take the place of those there were, and None
                takes a setting away.

        Raises:
            ProgramError: there is no such definition or attribute, or the task would be invalid.
        """
        step = self._one([s for s in self.steps if isinstance(s, Definition)], "definition", name)
        return self.replace(step, step.changed(**changes))

    def replace(self, step: Step, *others: Step) -> "Task":
        """A task with others in the place of one step; without others it is left out.

        Raises:
            ProgramError: it is not a step of this task, or the task would be invalid.
        """
        if step not in self.steps:
            raise ProgramError(
                f"task {self.name!r}: {step!r} is not a step of it; task.steps has its "
                f"{len(self.steps)}"
            )
        i = self.steps.index(step)
        return Task(self.name, (*self.steps[:i], *others, *self.steps[i + 1 :]))

    # --- to run -------------------------------------------------------------------------------

    def run(self, arm: Arm, *, keep: bool = False) -> Report:
        """Run it: define, move, and wait until its last move is over.

        What it has defined is removed at the end, unless it is kept; after an error as well, and
        then its moves are stopped. Compliance of its last mode acts until the next move.

        Args:
            arm: of the program.
            keep: whether its definitions stay on the server.

        Raises:
            ProgramError: or the class of it that the program API raises: no contact came, an
                insertion got stuck, a request was refused.
            FaultError: a fault halted the arm; the definitions stay.
        """
        if isinstance(arm, AsyncArm):
            raise ProgramError(
                f"task {self.name!r}: run() is for an Arm: await task.run_async(arm) of an AsyncArm"
            )
        return drive(self._doing(keep), arm)

    async def run_async(self, arm: AsyncArm, *, keep: bool = False) -> Report:
        """:meth:`run` for a program of coroutines; one that is cancelled leaves all as it is."""
        return await drive_async(self._doing(keep), arm)

    def _doing(self, keep: bool) -> Generator[Request, Any, Report]:
        run = Run(self.scope)
        yield from doing_of(self.steps, run, keep=keep)
        return Report(tuple(run.outcomes), run.travelled, run.depth)

    def _one(self, made: Sequence[Defined], what: str, name: str) -> Defined:
        """The one definition with a name, or with an end of a name."""
        found = [step for step in made if step.name == name] or [
            step for step in made if step.name.rpartition(": ")[2] == name
        ]
        if not found:
            unknown(f"task {self.name!r}: {what}", name, tuple(step.name for step in made))
        if len(found) > 1:
            raise ProgramError(
                f"task {self.name!r}: {what} {name!r} may be any of "
                f"{', '.join(repr(step.name) for step in found)}: give the whole name, or the "
                f"definition itself to replace()"
            )
        return found[0]

    def _foreign(self) -> Iterator[Part]:
        """Transforms of the program that it uses, each once."""
        sides = (s.tool + s.at for s in self.steps if isinstance(s, DefinePosition))
        return (part for part in dict.fromkeys(chain.from_iterable(sides)) if not part.ours)


def _unique(steps: Iterable[Step]) -> list[Definition]:
    """Definitions, each once.

    Raises:
        ProgramError: one name is defined in two ways.
    """
    made: dict[tuple[type[Definition], str], Definition] = {}
    for step in steps:
        if isinstance(step, Definition):
            known = made.setdefault((type(step), step.name), step)
            if known != step:
                raise ProgramError(
                    f"{step.name!r} is defined twice, as {known} and as {step}: give one frame "
                    f"another name, or one of the motions another name="
                )
    return [*made.values()]

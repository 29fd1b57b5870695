"""Steps that define transforms, positions and modes, and how each is changed."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, Final, Self, cast

from rfms_can.coordinator import Expression, ModeError, ModeSettings, Transform, definitions
from rfms_can.task.frames import T6, Parts, unknown
from rfms_can.task.steps import Doing, Run, Step, TaskNames
from rfms_can.task.words import Words, call, quoted, settings_words, transform_words

_TIMES: Final = frozenset(("segment_time", "speed", "angular_speed", "joint_speed"))
"""Settings of a mode of which those given take the place of all others."""


@dataclass(frozen=True)
class Definition(Step):
    """A step that gives a name a meaning.

    Attributes:
        name: within the task; on the server the task's name stands before it.
    """

    name: str

    def changed(self, **changes: Any) -> Self:
        """The same definition with other attributes.

        Raises:
            ProgramError: it has no such attribute.
        """
        known = tuple(field.name for field in fields(self))[1:]
        for name in changes.keys() - {*known}:
            unknown(f"change of {self.name!r}: attribute", name, known)
        return replace(self, **changes)


@dataclass(frozen=True)
class DefineTransform(Definition):
    """``arm.transform``.

    Attributes:
        value: rigid, metres.
    """

    value: Transform

    def lines(self, words: Words) -> list[str]:
        """See :class:`Step`."""
        name = words.variable("transform", self.name)
        arguments = [words.full(self.name), transform_words(self.value)]
        return call(f"{name} = arm.transform", arguments)

    def calls(self, run: Run) -> Doing:
        """See :class:`Step`."""
        name = run.scope.full(self.name)
        yield lambda arm: arm.transform(name, self.value)

    def check(self, names: TaskNames) -> None:
        """See :class:`Step`."""
        definitions.value(names.scope.full(self.name), self.value)


@dataclass(frozen=True)
class DefinePosition(Definition):
    """``arm.position``: the tool's frame at another, ``arm.t6 @ tool == at``.

    Attributes:
        tool: right of T6; empty: T6 itself.
        at: where it gets.
        config: branch of the inverse kinematics; None: the arm's own when enabled.
    """

    tool: Parts
    at: Parts
    config: str | None = None

    def lines(self, words: Words) -> list[str]:
        """See :class:`Step`."""
        name = words.variable("position", self.name)
        config = [] if self.config is None else [f"config={quoted(self.config)}"]
        arguments = [words.full(self.name), words.equation(self.tool, self.at), *config]
        return call(f"{name} = arm.position", arguments)

    def calls(self, run: Run) -> Doing:
        """See :class:`Step`."""
        name, scope = run.scope.full(self.name), run.scope
        tool, at, config = scope.expression(self.tool), scope.expression(self.at), self.config
        yield lambda arm: arm.position(name, arm.t6 @ tool == at, config=config)

    def check(self, names: TaskNames) -> None:
        """See :class:`Step`."""
        what, scope = f"position {self.name!r}", names.scope
        names.parts(what, self.tool + self.at)
        tool, at = scope.expression(self.tool), scope.expression(self.at)
        definitions.position(
            scope.full(self.name), Expression(T6) @ tool == at, None, None, self.config
        )


@dataclass(frozen=True)
class DefineMode(Definition):
    """``arm.mode``.

    Attributes:
        settings: of :class:`ModeSettings`.
    """

    settings: ModeSettings

    def lines(self, words: Words) -> list[str]:
        """See :class:`Step`."""
        name = words.variable("mode", self.name)
        arguments = [words.full(self.name), *settings_words(self.settings)]
        return call(f"{name} = arm.mode", arguments)

    def calls(self, run: Run) -> Doing:
        """See :class:`Step`."""
        name = run.scope.full(self.name)
        yield lambda arm: arm.mode(name, **self.settings)

    def check(self, names: TaskNames) -> None:
        """See :class:`Step`."""
        definitions.mode(names.scope.full(self.name), self.settings)

    def changed(self, **changes: Any) -> Self:
        """The same mode with other settings; None takes a setting away.

        Raises:
            ModeError: there is no such setting.
        """
        return replace(self, settings=merged(f"change of {self.name!r}", self.settings, changes))


def merged(what: str, settings: ModeSettings, given: Mapping[str, Any] | None) -> ModeSettings:
    """Settings of a mode, some of them others: a time or speeds take the place of all such.

    Args:
        what: call that they are for, for the error.
        settings: as they are.
        given: others; None takes a setting away.

    Raises:
        ModeError: not a mapping, or a setting that does not exist.
    """
    others = {} if given is None else given
    if not isinstance(others, Mapping):
        raise ModeError(f"{what}: {given!r}: give settings of a mode, as in {{'speed': 0.05}}")
    for name in others.keys() - ModeSettings.__annotations__.keys():
        raise ModeError(
            f"{what}: there is no setting {name!r}; there are: "
            f"{', '.join(ModeSettings.__annotations__)}"
        )
    gone = _TIMES if any(others.get(name) is not None for name in _TIMES) else frozenset[str]()
    kept = {name: value for name, value in settings.items() if name not in gone}
    made = {name: value for name, value in {**kept, **others}.items() if value is not None}
    return cast("ModeSettings", made)

"""A task in the words of the program API: values as Python that makes the same ones again."""

import json
import keyword
import math
import unicodedata
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from rfms_can.coordinator import Transform
from rfms_can.task.frames import T6, Part, Parts, Scope

_AXES: Final[tuple[tuple[tuple[float, float, float], Callable[[Transform], float]], ...]] = (
    ((1.0, 0.0, 0.0), lambda t: math.atan2(t.oz, t.oy)),
    ((0.0, 1.0, 0.0), lambda t: math.atan2(t.ax, t.az)),
    ((0.0, 0.0, 1.0), lambda t: math.atan2(t.ny, t.nx)),
)
"""Axes of simple rotations, and the angle about each that a rotation would have."""

_ANGLES: Final = {
    math.pi: "math.pi",
    -math.pi: "-math.pi",
    0.5 * math.pi: "math.pi / 2",
    -0.5 * math.pi: "-math.pi / 2",
}
"""Angles that have a name."""

_TAKEN: Final = {
    *("arm", "depth", "end", "ends", "goal", "here", "look", "math", "mode", "mouth", "number"),
    *("travelled", "until", "Expression", "Outcome", "ProgramError", "Transform"),
}
"""Names that a printed task has for other things."""

WIDTH: Final = 100
"""Longest line of a call that is not broken."""


def transform_words(value: Transform) -> str:
    """A transform as Python that makes exactly this one: a rotation about an axis where it is."""
    place = Transform.translation(value.px, value.py, value.pz)
    moved = f"Transform.translation({', '.join(map(number, (value.px, value.py, value.pz)))})"
    if place == value:
        return moved
    for axis, angle_of in _AXES:
        angle = angle_of(value)
        rotation = Transform.rotation(axis, angle)
        turned = f"Transform.rotation({axis}, {_ANGLES.get(angle, repr(angle))})"
        if rotation == value:
            return turned
        if place @ rotation == value:
            return f"{moved} @ {turned}"
    return f"Transform({', '.join(map(number, value))})"


def number(value: float) -> str:
    """A number as Python; one of numpy as Python's own."""
    return repr(float(value))


def quoted(text: str) -> str:
    """A text as Python."""
    return json.dumps(text, ensure_ascii=False)


def call(head: str, arguments: Sequence[str]) -> list[str]:
    """A call as lines: one, or one for each argument."""
    line = f"{head}({', '.join(arguments)})"
    if len(line) <= WIDTH:
        return [line]
    return [f"{head}(", *(f"    {argument}," for argument in arguments), ")"]


def settings_words(settings: Mapping[str, Any]) -> list[str]:
    """Settings as arguments of a call."""
    return [f"{name}={_plain(value)}" for name, value in settings.items()]


def escaped(text: str) -> str:
    """A text that ``str.format`` leaves as it is."""
    return text.replace("{", "{{").replace("}", "}}")


def _plain(value: Any) -> str:
    """A number, a text, or a table of numbers; numpy's numbers as Python's own."""
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, Mapping):
        entries = (f"{quoted(name)}: {_plain(one)}" for name, one in value.items())
        return "{" + ", ".join(entries) + "}"
    if isinstance(value, tuple | list):
        return "(" + "".join(f"{_plain(one)}, " for one in value).removesuffix(" ") + ")"
    return repr(value.item() if hasattr(value, "item") else value)


class Words:
    """Variables of a printed task.

    Attributes:
        scope: of the task.
    """

    def __init__(self, scope: Scope) -> None:
        self.scope = scope
        self._variables: dict[tuple[str, str], str] = {}

    def full(self, name: str) -> str:
        """A name on the server, quoted."""
        return quoted(self.scope.full(name))

    def variable(self, kind: str, name: str) -> str:
        """The variable of a transform, a position or a mode of the task; ``foreign`` if not its."""
        key = (kind, name)
        if key not in self._variables:
            self._variables[key] = self._new(name.rpartition(": ")[2])
        return self._variables[key]

    def foreign(self, part: Part) -> str:
        """A line for a transform that the program has defined."""
        return f"{self._of(part)} = Expression({quoted(part.name)})"

    def product(self, parts: Parts) -> str:
        """A product of transforms."""
        return " @ ".join(map(self._of, parts))

    def equation(self, tool: Parts, at: Parts) -> str:
        """A position equation: the tool's frame, or T6 itself, at another."""
        return f"{' @ '.join([f'arm.{T6}', *map(self._of, tool)])} == {self.product(at)}"

    def move(self, position: str, mode: str) -> str:
        """A call of ``arm.move``."""
        return f"arm.move({self.variable('position', position)}, {self.variable('mode', mode)})"

    def value(self, parts: Parts) -> str:
        """The value of a product."""
        return transform_words(self.scope.value("print", parts))

    def _of(self, part: Part) -> str:
        return self.variable("transform" if part.ours else "foreign", part.name)

    def _new(self, name: str) -> str:
        """An identifier like a name, that is still free."""
        plain = unicodedata.normalize("NFKC", name)
        word = "".join(c if f"a{c}".isidentifier() else "_" for c in plain)
        if not word.isidentifier() or keyword.iskeyword(word) or word in _TAKEN:
            word = f"the_{word}"
        taken = {*self._variables.values()}
        count, free = 2, word
        while free in taken:
            count, free = count + 1, f"{word}_{count}"
        return free

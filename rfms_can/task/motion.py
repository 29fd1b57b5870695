"""What a primitive is made of: definitions named after it, and the task they make."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

from rfms_can.coordinator import Expression, ModeSettings, ProgramError, Transform
from rfms_can.task.checks import offset, positive
from rfms_can.task.definitions import DefineMode, DefinePosition, DefineTransform, merged
from rfms_can.task.frames import Frame, Part, frame_of
from rfms_can.task.steps import Step
from rfms_can.task.task import Task

Place = Frame | Expression
"""What is related: a frame of the task, or transforms of the program."""

NAME: Final = "task"
"""Of a task that was not given one."""


class Motion:
    """What a primitive relates, and what it defines on the way.

    Attributes:
        label: what its definitions are named after.
        tool, frame: what is related.
    """

    def __init__(
        self,
        verb: str,
        tool: Place,
        frame: Place,
        config: str | None,
        name: str | None,
        roles: tuple[str, str] = ("tool", "frame"),
    ) -> None:
        self.tool = frame_of(f"{verb}: {roles[0]}", tool)
        self.frame = frame_of(f"{verb}: {roles[1]}", frame)
        if name is not None and (not isinstance(name, str) or not name):
            raise ProgramError(f"{verb}: name {name!r}: give a text, not empty, or None")
        self.label = name or f"{verb} {self.frame!r}"
        self._config = config
        self._steps: list[Step] = [
            DefineTransform(name, value)
            for frames in (self.tool, self.frame)
            for name, value in frames.values.items()
        ]

    def off(self, what: str, by: Sequence[float]) -> Frame:
        """A point off the frame."""
        return self.shifted(what, *offset(self.label, by))

    def shifted(self, what: str, x: float, y: float, z: float) -> Frame:
        """A frame beside the frame, m along its axes."""
        value = Transform.translation(x + 0.0, y + 0.0, z + 0.0)  # no -0.0
        beside = Frame(f"{self.label}: {what}", value)
        self._steps.append(DefineTransform(beside.names[0], value))
        return self.frame @ beside

    def at(self, what: str, place: Frame) -> str:
        """A position of the tool; its name."""
        name = f"{self.label}: {what}"
        self._steps.append(DefinePosition(name, self.tool.parts, place.parts, self._config))
        return name

    def rest(self, settings: ModeSettings) -> tuple[str, str, str]:
        """A transform for where the arm will have stopped, a position there, and a mode."""
        here = f"{self.label}: stopped"
        self._steps.append(DefineTransform(here, Transform.identity()))
        there = f"{self.label}: rest"
        self._steps.append(DefinePosition(there, (), (Part(here, True),), self._config))
        return here, there, self.mode("halt", settings)

    def mode(
        self, what: str, settings: ModeSettings, given: Mapping[str, Any] | None = None
    ) -> str:
        """A mode; its name."""
        name = f"{self.label}: {what}"
        self._steps.append(DefineMode(name, merged(self.label, settings, given)))
        return name

    def straight(self, what: str, speed: float, **more: Any) -> str:
        """A mode of straight motions; its name."""
        settings: ModeSettings = {
            "speed": positive(self.label, "speed", speed, 1e6, "m/s"),
            "acceleration_time": 0.1,
            "interpolation": "cartesian",
        }
        return self.mode(what, settings, more)

    def task(self, *steps: Step) -> Task:
        """The task that defines all this and makes these steps."""
        return Task(NAME, (*self._steps, *steps))

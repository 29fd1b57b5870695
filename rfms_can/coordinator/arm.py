"""The program API: a robot coordinator's view of the arm (thesis VI.3.1), in one process.

A program is a function that is given an :class:`Arm`::

    def program(arm):
        tool = arm.transform("tool", Transform.translation(0.0, 0.0, 0.1))
        part = arm.transform("part", Transform.translation(0.3, 0.1, 0.0))
        at_part = arm.position("at part", arm.t6 @ tool == part)
        slow = arm.mode("slow", segment_time=1.0, acceleration_time=0.2, interpolation="cartesian")
        arm.wait(arm.move(at_part, slow))
        arm.gripper.close()

Time waits while the program runs between two waits; a request takes effect at the next cycle.
"""

from typing import Literal

import msgspec

from rfms_can.coordinator.equation import Equation, Expression
from rfms_can.coordinator.link import Link
from rfms_can.errors import EquationError, ProgramError
from rfms_can.messages import (
    T6,
    Answer,
    ArmRequest,
    AtRest,
    CycleReached,
    GripperRequest,
    JawAtRest,
    ModeMessage,
    MoveOver,
    MoveRequest,
    PositionMessage,
    StopRequest,
    TransformMessage,
)
from rfms_can.transform import Transform


class Gripper:
    """The gripper: both calls return when the jaw rests, at its stop or on a part."""

    __slots__ = ("_link",)

    def __init__(self, link: Link) -> None:
        self._link = link

    def open(self, force: float = 1.0) -> None:
        """Open with a part (0 to 1) of the full force, and wait."""
        self._command(True, force)

    def close(self, force: float = 1.0) -> None:
        """Close with a part (0 to 1) of the full force, and wait."""
        self._command(False, force)

    def _command(self, opens: bool, force: float) -> None:
        if not 0.0 < force <= 1.0:
            raise ProgramError(f"gripper force {force} is outside 0..1 (a part of the full force)")
        self._link.request(GripperRequest(opens, force))
        self._link.wait(JawAtRest())


class Arm:
    """What a user program moves.

    Attributes:
        t6: the arm itself, in position equations.
        gripper: opens and closes.
    """

    def __init__(self, link: Link) -> None:
        self._link = link
        self.t6 = Expression(T6)
        self.gripper = Gripper(link)
        self._moves = 0

    def transform(self, name: str, value: Transform) -> Expression:
        """Define a transform of the world model; later definitions replace earlier ones.

        Raises:
            ProgramError: it is no transform, or the server refuses it.
        """
        if not isinstance(value, Transform):
            raise EquationError(f"transform {name!r}: a Transform is needed, not {value!r}")
        self._request(TransformMessage(name, value))
        return Expression(name)

    def position(
        self,
        name: str,
        equation: Equation,
        *,
        tool: Expression | None = None,
        configuration: str | None = None,
    ) -> str:
        """Define a position by an equation with ``t6`` in it once.

        Args:
            name: its name; a position is defined once.
            equation: e.g. ``arm.t6 @ tool == part @ above``.
            tool: whose frame runs along straight lines; all that stands right of T6 if not given.
            configuration: e.g. ``"left up noflip"``; the arm's own when enabled if not given.

        Raises:
            EquationError: it cannot be solved for T6.
        """
        if not isinstance(equation, Equation):
            raise EquationError(f"position {name!r}: give an equation like t6 @ tool == part")
        if tool is not None and not (isinstance(tool, Expression) and len(tool.names) == 1):
            raise EquationError(
                f"position {name!r}: tool {tool!r} must be one transform; leave it out to have "
                f"all that stands right of {T6}"
            )
        self._request(
            PositionMessage(
                name,
                list(equation.left),
                list(equation.right),
                tool.names[0] if tool is not None else None,
                configuration=configuration,
            )
        )
        return name

    def mode(
        self,
        name: str,
        *,
        segment_time: float,
        acceleration_time: float,
        interpolation: Literal["joint", "cartesian"] = "joint",
    ) -> str:
        """Define how a segment is moved.

        Args:
            name: its name; a mode is defined once.
            segment_time: t_seg, s, from goal to goal.
            acceleration_time: t_acc, s: a transition takes twice that.
            interpolation: ``"joint"`` or ``"cartesian"``.
        """
        self._request(ModeMessage(name, interpolation, acceleration_time, segment_time))
        return name

    def move(self, position: str, mode: str) -> int:
        """Move to a position; returns the move's sequence number at once.

        Raises:
            MoveError: the move breaks a rule, or the arm cannot make it.
        """
        self._moves = self._request(MoveRequest(position, mode)).sequence
        return self._moves

    def wait(self, sequence: int | None = None) -> None:
        """Wait until a move is complete, or, without a number, until the arm is at rest.

        A move is complete when the arm is at rest at its goal, or has handed over to the next;
        one that :meth:`stop` has dropped, when the arm is at rest.

        Raises:
            ProgramError: no move has that number.
            FaultError: the run was halted.
        """
        link = self._link
        if sequence is not None and not 0 < sequence <= self._moves:
            raise ProgramError(
                f"wait for move {sequence}: {self._moves} moves have been asked for; "
                f"give a number that move() returned"
            )
        link.wait(AtRest() if sequence is None else MoveOver(sequence))

    def sleep(self, seconds: float) -> None:
        """Let the arm go on for a time of its own clock."""
        status = self._link.status()
        self._link.wait(CycleReached(status.cycle + round(seconds / status.period)))

    def stop(self) -> None:
        """Bring the arm to rest on its path, forget the moves that wait, and wait for rest."""
        self._request(StopRequest())
        self.wait()

    @property
    def joints(self) -> tuple[float, ...]:
        """Measured joint angles, rad (6)."""
        return self._link.status().joints

    @property
    def pose(self) -> Transform:
        """Measured T6."""
        return Transform(*self._link.status().t6)

    def _request(self, message: ArmRequest) -> Answer:
        """Check a message as if it had come over a link, and hand it over."""
        try:
            checked = msgspec.convert(msgspec.to_builtins(message), type=type(message))
        except msgspec.ValidationError as error:
            raise ProgramError(f"{type(message).__name__}: {error}") from error
        return self._link.request(checked)

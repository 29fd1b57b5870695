"""Common part of both variants of the program API: everything that does not wait."""

from collections.abc import Sequence
from typing import Final

from rfms_can.coordinator import definitions
from rfms_can.coordinator.equation import Expression
from rfms_can.coordinator.link import State
from rfms_can.coordinator.moves import MovePlan, Moves
from rfms_can.errors import ProgramError
from rfms_can.messages import (
    T6,
    CycleReached,
    RemoveRequest,
    Status,
    TransformMessage,
    Vector6,
)
from rfms_can.messages.world import Predict
from rfms_can.transform import Transform

LONGEST_S: Final = 1e6
"""Longest sleep, s: eleven days."""


class ArmView:
    """A program's view of the arm.

    Attributes:
        t6: the arm itself, in position equations.
    """

    def __init__(self, state: State, moves: Moves | None = None) -> None:
        self.t6 = Expression(T6)
        self._state = state
        self._moves = moves or Moves()
        self._references: dict[str, Predict] = {}

    @property
    def status(self) -> Status:
        """The arm's state at the last closed cycle that is known here."""
        return self._state.status()

    @property
    def time(self) -> float:
        """The server's time, s, for time stamps of observations.

        In virtual time and lockstep it stands still between two waits and is exact; in real time
        it runs on, and may lag behind the server's by less than a period.
        """
        return self._state.time()

    @property
    def joints(self) -> tuple[float, ...]:
        """Measured joint angles, rad (6)."""
        return self.status.joints

    @property
    def pose(self) -> Transform:
        """Measured T6."""
        return Transform(*self.status.t6)

    @property
    def force(self) -> tuple[float, ...]:
        """Wrench of the hand on the environment, in the compliance frame, N and N m (6).

        From the wrist sensor; without one estimated from the motors, in guarded moves only.
        """
        return self.status.force

    @property
    def complied(self) -> tuple[float, ...]:
        """Compliant displacement of the compliance frame, m and rad along its axes (6)."""
        return self.status.complied

    @property
    def guard(self) -> str | None:
        """Why the last guarded move was stopped before its goal; None if it was not."""
        return self.status.guard

    def plan(self, sequence: int) -> MovePlan:
        """The server's plan of a move: its time, and its deviation from the goal before it.

        Raises:
            ProgramError: no move has that number, or it was too long ago.
        """
        return self._moves.plan(sequence)

    def _reference(
        self, name: str, pose: Transform, predict: Predict, rest_after: float
    ) -> TransformMessage:
        message = definitions.reference(name, pose, predict, rest_after)
        self._references[name] = predict
        return message

    def _removed(self, request: RemoveRequest) -> None:
        """Forget a reference that the server has removed."""
        if request.what in (None, "transform"):
            self._references.pop(request.name, None)

    def _observation(
        self, of: str | Expression, pose: Transform, at: float | None, twist: Sequence[float] | None
    ) -> TransformMessage:
        exact: Vector6 | None = None if twist is None else tuple(twist)  # type: ignore[assignment]
        return definitions.observation(of, pose, at, exact, self._references)

    def _after(self, seconds: float) -> CycleReached:
        """The cycle ``seconds`` ahead; a positive time is at least one period."""
        return cycle_after(self.status, seconds)


def cycle_after(status: Status, seconds: float) -> CycleReached:
    """The cycle ``seconds`` after that of a status; a positive time is at least one period.

    Raises:
        ProgramError: the time is negative, too long or not a number.
    """
    if not isinstance(seconds, float | int) or not 0.0 <= seconds <= LONGEST_S:  # also NaN
        raise ProgramError(f"sleep of {seconds!r} s: give a time, 0 to {LONGEST_S:g}")
    periods = round(seconds / status.period)
    return CycleReached(status.cycle + (periods or seconds > 0.0))

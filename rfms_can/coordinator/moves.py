"""The moves a program has requested: their numbers, and the server's plans for them."""

from collections import OrderedDict
from typing import Final, NamedTuple

from rfms_can.errors import ProgramError
from rfms_can.messages import Answer, AnyCondition, AtRest, MoveOver, PlannedMove

PLANS_KEPT: Final = 256


class MovePlan(NamedTuple):
    """The server's plan of a move.

    Attributes:
        sequence: the move's number.
        segment_time: t_seg, s: as the mode gave it, lengthened, or from its speeds.
        via_deviation, via_rotation: smallest distance of the tool from the goal before this one if
            this move begins without rest, m and rad; None if the arm rests between.
    """

    sequence: int
    segment_time: float | None
    via_deviation: float | None
    via_rotation: float | None


class Moves:
    """The moves of one program; the server's sequence numbers need not begin at 1."""

    __slots__ = ("_count", "_last", "_plans")

    def __init__(self) -> None:
        self._plans: OrderedDict[int, MovePlan] = OrderedDict()
        self._count = self._last = 0

    def took(self, answer: Answer) -> int:
        """Store an accepted move; its number."""
        sequence = answer.sequence
        self._keep(sequence, answer)
        if len(self._plans) > PLANS_KEPT:
            self._plans.popitem(last=False)
        self._count += 1
        self._last = sequence
        return sequence

    def redefined(self, answer: Answer) -> None:
        """Store what a redefinition has made of the plans of moves that have not begun."""
        for move in answer.replanned:
            if move.sequence in self._plans:
                self._keep(move.sequence, move)

    def _keep(self, sequence: int, planned: Answer | PlannedMove) -> None:
        self._plans[sequence] = MovePlan(
            sequence, planned.segment_time, planned.via_deviation, planned.via_rotation
        )

    def plan(self, sequence: int) -> MovePlan:
        """The plan of a move; the last ``PLANS_KEPT`` are kept.

        Raises:
            ProgramError: no move has that number, or it was too long ago.
        """
        self._check(sequence, "plan of")
        if sequence not in self._plans:
            raise ProgramError(
                f"plan of move {sequence}: it was too long ago, those of the last {PLANS_KEPT} "
                f"moves are kept"
            )
        return self._plans[sequence]

    def over(self, sequence: int | None) -> AnyCondition:
        """Condition that a move is complete, or, without a number, that the arm rests.

        Raises:
            ProgramError: no move has that number.
        """
        if sequence is None:
            return AtRest()
        self._check(sequence, "wait for")
        return MoveOver(sequence)

    def _check(self, sequence: int, what: str) -> None:
        if not isinstance(sequence, int):
            raise ProgramError(f"{what} move {sequence!r}: give a number that move() returned")
        if not self._last - self._count < sequence <= self._last:
            raise ProgramError(
                f"{what} move {sequence}: {self._count} moves have been asked for; "
                f"give a number that move() returned"
            )

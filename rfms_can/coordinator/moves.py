"""The moves a program has requested: their numbers, the server's plans, and how they ended."""

from collections import OrderedDict
from collections.abc import Iterable
from typing import Final, NamedTuple

from rfms_can.errors import ProgramError
from rfms_can.messages import (
    Answer,
    AnyCondition,
    AtRest,
    MoveOutcome,
    MoveOver,
    PlannedMove,
)
from rfms_can.messages.outcomes import MAX_ASKED, OUTCOMES

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

    __slots__ = ("_count", "_last", "_plans", "_told")

    def __init__(self) -> None:
        self._plans: OrderedDict[int, MovePlan] = OrderedDict()
        self._count = self._last = 0
        self._told = 0  # the last move whose end the program has been told

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

    def number(self, sequence: int) -> int:
        """The number of a move of this program.

        Raises:
            ProgramError: no move has that number.
        """
        self._check(sequence, "outcome of")
        return sequence

    def asked(self, sequence: int | None) -> tuple[int, int] | None:
        """First and last of the moves whose end matters to who waits for one, or for rest.

        Without a number these are the moves whose end the program has not been told, if any.
        """
        if sequence is not None:
            return sequence, sequence
        first = max(self._told, self._last - min(self._count, MAX_ASKED)) + 1
        return (first, self._last) if first <= self._last else None

    def tell(self) -> None:
        """The program knows how all its moves so far ended."""
        self._told = self._last

    def judge(self, outcomes: Iterable[MoveOutcome], *, at_rest: bool = False) -> None:
        """Raise what happened to moves that are waited for, once.

        Args:
            outcomes: how they ended, in order.
            at_rest: whether the program waits for rest, not for the moves: that it has stopped
                them itself is then no error.

        Raises:
            RfmsError: of the class that ``OUTCOMES`` has for the first that was not made.
        """
        for outcome in outcomes:
            rule = OUTCOMES[outcome.how]
            if rule.error is not None and not (at_rest and rule.requested):
                self._told = self._last  # what was asked for after it has met the same
                raise rule.error(
                    f"move {outcome.sequence} did not reach its goal ({outcome.how.value}): "
                    f"{outcome.reason}"
                )
            if at_rest and rule.over:
                self._told = max(self._told, outcome.sequence)

    def _check(self, sequence: int, what: str) -> None:
        if not isinstance(sequence, int):
            raise ProgramError(f"{what} move {sequence!r}: give a number that move() returned")
        if not self._last - self._count < sequence <= self._last:
            raise ProgramError(
                f"{what} move {sequence}: {self._count} moves have been asked for; "
                f"give a number that move() returned"
            )

"""How the moves of the trajectory generator ended, by their numbers; bounded in number."""

from collections.abc import Iterable
from typing import Final

from rfms_can.errors import ProgramError
from rfms_can.messages.outcomes import MAX_ASKED, MoveOutcome, Outcome

HISTORY: Final = 1024
"""Moves whose outcome is kept."""


class MoveOutcomes:
    """Moves end in the order of their numbers, each in one way.

    Attributes:
        completed: the highest number such that all moves up to it are over; 0 before the first.
        accepted: number of the last move that was accepted; 0 before the first.
    """

    __slots__ = ("_ending", "_over", "accepted", "completed")

    def __init__(self) -> None:
        self.completed = self.accepted = 0
        self._ending: dict[int, MoveOutcome] = {}  # over as soon as the arm rests
        self._over: dict[int, MoveOutcome] = {}

    def accept(self, sequence: int) -> None:
        """A move has been queued."""
        self.accepted = sequence

    def arrived(self, sequence: int) -> None:
        """The arm is at the goal of a move, or hands it over to the next.

        A guard that tripped too late to stop it has tripped all the same; a stop that came too
        late has not stopped it.
        """
        if sequence <= self.completed:
            return
        ending = self._ending.pop(sequence, None)
        guarded = ending is not None and ending.how is Outcome.GUARDED
        self._record(ending if ending and guarded else MoveOutcome(sequence, Outcome.MADE))

    def ends(self, sequences: Iterable[int], how: Outcome, reason: str) -> None:
        """Moves will not be completed: they are over when the arm rests.

        What ended a move first stays.
        """
        for sequence in sequences:
            if sequence > self.completed:
                self._ending.setdefault(sequence, MoveOutcome(sequence, how, reason))

    def rests(self) -> None:
        """The arm rests: what was stopped or dropped is over."""
        if self._ending:
            for sequence in sorted(self._ending):
                self._record(self._ending[sequence])
            self._ending.clear()

    def abandon(self, how: Outcome, reason: str) -> None:
        """All moves are over now, those that were ending as they were."""
        for sequence in range(self.completed + 1, self.accepted + 1):
            ending = self._ending.get(sequence)
            self._record(ending or MoveOutcome(sequence, how, reason))
        self._ending.clear()

    def of(self, first: int, last: int) -> list[MoveOutcome]:
        """The outcomes of moves ``first`` to ``last``.

        Raises:
            ProgramError: they are no moves, too many, or too long ago.
        """
        asked = f"outcome of move {first}" if first == last else f"outcomes of {first} to {last}"
        if not 1 <= first <= last:
            raise ProgramError(f"{asked}: moves count from 1, and the first comes first")
        if last - first >= MAX_ASKED:
            raise ProgramError(
                f"{asked}: {last - first + 1} moves, {MAX_ASKED} at a time: ask for fewer"
            )
        if last > self.accepted:
            raise ProgramError(
                f"{asked}: the last move has number {self.accepted}; give a number that move() "
                "returned"
            )
        if first <= self.completed and first not in self._over:
            kept = next(iter(self._over))
            raise ProgramError(
                f"{asked}: too long ago, those of the last {HISTORY} moves are kept, from {kept} on"
            )
        return [
            self._over.get(number) or MoveOutcome(number, Outcome.UNDER_WAY)
            for number in range(first, last + 1)
        ]

    def _record(self, outcome: MoveOutcome) -> None:
        self._over[outcome.sequence] = outcome
        self.completed = max(self.completed, outcome.sequence)
        if len(self._over) > HISTORY:
            del self._over[next(iter(self._over))]

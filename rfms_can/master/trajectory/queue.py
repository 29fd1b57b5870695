"""The queue of moves, and what a move must satisfy to be taken into it."""

from collections import deque
from collections.abc import Mapping
from typing import Final

from rfms_can.errors import MoveError
from rfms_can.master.trajectory.admission import (
    check_feed,
    check_path,
    check_succession,
    check_times,
    check_transition,
)
from rfms_can.master.trajectory.segment import Move, Segment

MAX_QUEUE: Final = 256
"""Parts of moves that may wait; a program that asks for more is waiting for nothing."""


class MoveQueue(deque[Move]):
    """Moves that wait, in parts, oldest first."""

    def __init__(self, period_s: float) -> None:
        super().__init__()
        self._period: Final = period_s
        self._last_sequence = 0

    def take(self, parts: tuple[Move, ...], before: Segment, tick: int, feed_rate: float) -> None:
        """Queue the parts of one move, all or none, to follow ``before``.

        Raises:
            MoveError: a part breaks a rule; the message names numbers and remedy.
        """
        if not parts:
            raise MoveError("a move needs at least one part")
        sequence = parts[0].sequence
        name = f"move {sequence}"
        if any(part.sequence != sequence for part in parts):
            numbers = ", ".join(str(part.sequence) for part in parts)
            raise MoveError(f"{name}: all its parts must have its number, not {numbers}")
        if [part.last for part in parts] != [False] * (len(parts) - 1) + [True]:
            raise MoveError(f"{name}: its last part, and no other, must be marked as the last")
        if sequence <= self._last_sequence:
            raise MoveError(f"{name}: numbers must grow, the last was {self._last_sequence}")
        if len(self) + len(parts) > MAX_QUEUE:
            raise MoveError(
                f"{name}: {len(self)} moves wait already and {MAX_QUEUE} may: "
                f"wait until one is complete"
            )
        for part in parts:
            self._check(before, part, tick, feed_rate)
            before = Segment(part)
        self.extend(parts)
        self._last_sequence = sequence

    def replace(
        self, moves: Mapping[int, tuple[Move, ...]], before: Segment, tick: int, feed_rate: float
    ) -> None:
        """Put other parts in the place of those of moves that wait, all or none.

        Args:
            moves: the parts by the number of their move; these follow one another.
            before: what the first of them is to follow.
            tick: of the generator.
            feed_rate: requested.

        Raises:
            MoveError: a part breaks a rule; the message names numbers and remedy.
        """
        queue: list[Move] = []
        left = dict(moves)
        for old in self:
            if old.sequence not in moves:
                queue.append(old)
            for part in left.pop(old.sequence, ()):
                self._check(before, part, tick, feed_rate)
                queue.append(part)
                before = Segment(part)
        if len(queue) > MAX_QUEUE:
            raise MoveError(
                f"move {max(moves)}: {len(queue)} moves would wait and {MAX_QUEUE} may: "
                f"wait until one is complete"
            )
        self.clear()
        self.extend(queue)

    def _check(self, before: Segment, move: Move, tick: int, feed_rate: float) -> None:
        check_times(move, self._period)
        check_feed(move, feed_rate, self._period)
        if not before.rests:
            check_succession(before.move, move, self._period)
        check_transition(before, move)
        check_path(before.move, move, tick, self._period)

"""Moves that wait, bound to what their names stand for: again after each redefinition.

The thesis passes a value transform "to the motion process with its present values, which will not
change once a motion is commenced" (III.3.2). Here a move is planned before it is accepted, with
the definitions of that time. One that is defined again acts in the moves that have not begun: they
are planned again, in their order, and take the place of those that were accepted; or, if one of
them could not be made, nothing changes.
"""

from collections.abc import Callable
from typing import Final

from rfms_can.errors import KinematicsError, MoveError
from rfms_can.master.accepted_moves import AcceptedMove, AcceptedMoves
from rfms_can.master.trajectory.generator import TrajectoryGenerator
from rfms_can.master.trajectory.planning import MovePlanner, Plan
from rfms_can.master.trajectory.segment import Entry, Segment
from rfms_can.master.world import WorldModel
from rfms_can.messages import PlannedMove

Refusal = Callable[[int, AcceptedMove], str | None]
"""Why force control refuses a move of that number, or None."""


class WaitingMoves:
    """Binds moves that have not begun.

    Args:
        generator: has them in its queue.
        planner: has planned them.
        accepted: the same, as they were accepted.
        refusal: of force control.
        most: that may be planned in one cycle.
    """

    def __init__(
        self,
        generator: TrajectoryGenerator,
        planner: MovePlanner,
        accepted: AcceptedMoves,
        refusal: Refusal,
        most: int,
    ) -> None:
        self._generator: Final = generator
        self._planner: Final = planner
        self._accepted: Final = accepted
        self._refusal: Final = refusal
        self._most: Final = most

    def bind(self, world: WorldModel) -> list[PlannedMove]:
        """Bind the moves that have not begun to the names as they are now.

        Planning begins with the first move that this changes, and ends where what follows cannot
        tell the difference.

        Returns:
            The moves that were planned again.

        Raises:
            MoveError: one of them could not be made: which and why. No move has changed.
        """
        moves = self._bound(world)
        if not moves:
            return []
        memory = self._planner.memory
        try:
            plans = self._plans(moves)
            self._generator.replace({k: plan.moves for k, plan in plans.items()})
        except (MoveError, KinematicsError):
            self._planner.recall(memory)
            raise
        self._accepted.replace({k: moves[k] for k in plans})
        tick = self._generator.tick_count
        for k in plans:
            world.note_levers(moves[k].position, tick)
        return [
            PlannedMove(k, plan.segment_time, plan.via_deviation, plan.via_rotation)
            for k, plan in plans.items()
        ]

    def _bound(self, world: WorldModel) -> dict[int, AcceptedMove]:
        """The moves from the first one on that has changed; none if none has.

        Raises:
            MoveError: force control refuses one that has, or one would wait behind a guarded one.
        """
        tick = self._generator.tick_count
        moves: dict[int, AcceptedMove] = {}
        guarded = 0
        for k in self._generator.not_begun:
            old = self._accepted.get(k)
            if old is None:
                continue
            move = old.bound_again(world, tick)
            if guarded:
                raise _refused(
                    *(k, move),
                    f"it waits behind move {guarded}, which would be guarded, so that its end is "
                    f"not known in advance",
                )
            if move is not old:
                reason = self._refusal(k, move)
                if reason:
                    raise _refused(k, move, reason)
            if moves or move is not old:
                moves[k] = move
            if move.specification.guard.active:
                guarded = k
        return moves

    def _plans(self, moves: dict[int, AcceptedMove]) -> dict[int, Plan]:
        """Plan them after one another, up to where the rest is as it was."""
        planner, generator = self._planner, self._generator
        queued, memory = generator.not_begun, planner.memory
        changed = [k for k, move in moves.items() if move is not self._accepted.get(k)]
        entry = generator.entry_of(min(moves))
        plans: dict[int, Plan] = {}
        for k, move in moves.items():
            if len(plans) == self._most:
                raise _refused(
                    *(k, move),
                    f"it is one more than the {self._most} that can be planned again in one cycle "
                    f"of real time",
                )
            try:
                plan = planner.plan(entry, move.position, move.mode, k)
            except (MoveError, KinematicsError) as error:
                raise _refused(k, move, str(error)) from error
            plans[k] = plan
            if k >= changed[-1] and plan.moves == queued[k] and planner.as_in(memory, k):
                break
            entry = Entry(Segment(plan.moves[-1]), entry.tick, feed_rate=entry.feed_rate)
        return plans


def _refused(sequence: int, move: AcceptedMove, why: str) -> MoveError:
    """The error that names an accepted move; the planner may have named it already."""
    why = why.removeprefix(f"move {sequence}: ")
    return MoveError(f"move {sequence}, {move.words}: {why}")

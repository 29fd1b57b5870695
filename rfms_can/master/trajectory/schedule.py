"""What follows the segment under way, when, and at which pace until then."""

from collections.abc import Callable
from typing import Final

from rfms_can.master.trajectory.pace import NO_HAND_OVER, HandOver, Pace
from rfms_can.master.trajectory.queue import MoveQueue
from rfms_can.master.trajectory.runner import SegmentRunner
from rfms_can.master.trajectory.segment import TOLD_TICKS, Move, Transition
from rfms_can.master.trajectory.states import Event, Stage
from rfms_can.tables import complete
from rfms_can.wire.vocabulary import Blend

LATEST: Final = 7
"""A transition may start late by t_acc over this without passing the goal it leaves."""


class Schedule:
    """Looks from the segment under way to the queue, and sets the pace."""

    __slots__ = ("_blend", "_pace", "_queue", "_run")

    def __init__(self, run: SegmentRunner, queue: MoveQueue, pace: Pace, blend: Blend) -> None:
        self._run: Final = run
        self._queue: Final = queue
        self._pace: Final = pace
        self._blend: Final = blend

    def set_pace(self, stage: Stage, *, stopping: bool) -> None:
        """The step of the next cycle, after one in ``stage``."""
        run, pace = self._run, self._pace
        if not pace.is_as_wanted:
            segment = run.segment
            if stage is Stage.IDLE and segment.move.target.constant:
                pace.jump()
            elif stage is not Stage.PRE:
                free = stopping or segment.rests or stage is Stage.STOP
                ahead = NO_HAND_OVER if free else self._earliest_hand_over()
                pace.change(run.n, segment.move.rest_ticks, ahead)
        run.step = pace.advance()

    def unsettle(self, stage: Stage) -> None:
        """The pace is to change: a move that waits at rest for its moving goal is planned again."""
        run = self._run
        if stage is Stage.IDLE and run.next is not None:
            self._queue.appendleft(run.next.move)
            run.next = None

    def may_depart(self, transition: Transition) -> bool:
        """Whether a move with ``transition`` may leave the rest the arm is in."""
        if not self._queue or self._pace.paused:
            return False
        move = self._queue[0].from_rest()
        return move.transition is transition and self._until_steady(move) == 0.0

    def event(self, stage: Stage, *, stopping: bool) -> Event:
        """What happens between the last cycle, in ``stage``, and the next."""
        return _EVENTS[stage](self, stopping)

    def _event_never(self, stopping: bool) -> Event:
        """Stages that last one tick, and those that others end."""
        return Event.STAY

    def _event_at_rest(self, stopping: bool) -> Event:
        """Whether what waits for its watch, or for a Cartesian transition, departs."""
        run = self._run
        if run.next is not None:
            watched = run.watched >= run.watch_ticks(run.next.move)
            return Event.DEPART if watched and run.is_known_at_rest(run.next.move) else Event.STAY
        if run.rested and self.may_depart(Transition.CARTESIAN):
            return Event.BEND
        return Event.STAY

    def _event_in_transition(self, stopping: bool) -> Event:
        """Whether the transition is over, and what follows it."""
        run = self._run
        if run.n + run.step <= run.segment.move.acceleration_ticks:
            return Event.STAY
        if run.segment.rests:
            return Event.ARRIVED
        if run.segment.line is not None:
            return Event.REJOIN
        return self._event_after_transition(stopping)

    def _event_after_transition(self, stopping: bool) -> Event:
        """What follows a transition that does not end at rest."""
        event = self._event_along(stopping)
        return Event.BLENDED if event is Event.STAY else event

    def _event_rejoined(self, stopping: bool) -> Event:
        """Whether the joints have been told their line for long enough."""
        if self._run.told < TOLD_TICKS:
            return Event.STAY
        return self._event_after_transition(stopping)

    def _event_before_hand_over(self, stopping: bool) -> Event:
        """Whether the settled segment takes over."""
        if stopping:
            return Event.HALT
        run = self._run
        return Event.DEPART if run.n + run.step >= run.hand_over else Event.STAY

    def _event_along(self, stopping: bool) -> Event:
        """Whether the straight part of the segment goes on."""
        if stopping:
            return Event.HALT
        run = self._run
        upcoming, hand_over = self._upcoming()
        move = upcoming or run.resting
        if move.transition is Transition.CARTESIAN:
            return Event.BEND if run.n + run.step > hand_over else Event.STAY
        if self._pace.changes or not run.step:  # PRE keeps its pace: a ramp ends first
            return Event.STAY
        due = run.n + run.step >= hand_over - run.watch_ticks(move) * run.step
        return Event.PREPARE if due else Event.STAY

    def take(self, stage: Stage) -> tuple[Move | None, float]:
        """Take what follows from the queue, and the local time of its hand-over; None is rest."""
        run = self._run
        if stage is Stage.IDLE or run.rested:
            return self._queue.popleft().from_rest(), run.n
        move, hand_over = self._upcoming()
        if move is not None:
            self._queue.popleft()
        return move, hand_over

    def _upcoming(self) -> tuple[Move | None, float]:
        """The move that follows without rest, and when; None without one, or if it is too late.

        One settled too late for its due time takes over as soon as can be: on the tick after next,
        once its start has been sent, and the pace is steady.
        """
        run = self._run
        own = run.segment.move
        if self._queue:
            move = self._queue[0]
            due = own.segment_ticks - move.acceleration_ticks
            soonest = run.n + self._until_steady(move)
            start = run.n + 2.0 * run.step
            if move.transition is Transition.JOINT and start - due >= run.step:
                soonest = max(soonest, start)
            if (soonest - due) * LATEST <= move.acceleration_ticks:
                return move, max(due, soonest)
        due = own.segment_ticks - own.rest_ticks
        wait = self._until_steady(run.resting)
        return None, max(due, run.n + wait) if wait else due

    def _until_steady(self, move: Move) -> float:
        own = self._run.segment.move
        return self._pace.until_steady(own.rest_ticks, self._hand_over(move))

    def _hand_over(self, move: Move) -> HandOver:
        """Of the hand-over to ``move``, which may be the transition to rest."""
        segment = self._run.segment
        own = segment.move
        still = segment.drive is None and own.target.constant and move.target.constant
        asks = move.transition is Transition.JOINT and self._blend is not Blend.THESIS
        due = own.segment_ticks - move.acceleration_ticks
        return HandOver(due, move.acceleration_ticks, asks and not still)

    def _earliest_hand_over(self) -> HandOver:
        """To rest or to the next move, whichever asks for more."""
        rest = self._hand_over(self._run.resting)
        if not self._queue:
            return rest
        following = self._hand_over(self._queue[0])
        return HandOver(
            min(rest.n, following.n),
            max(rest.acceleration_ticks, following.acceleration_ticks),
            rest.estimated or following.estimated,
        )


_EVENTS: Final[dict[Stage, Callable[[Schedule, bool], Event]]] = complete(
    {
        Stage.OFF: Schedule._event_never,
        Stage.IDLE: Schedule._event_at_rest,
        Stage.START: Schedule._event_never,
        Stage.BLEND: Schedule._event_in_transition,
        Stage.CURVE: Schedule._event_in_transition,
        Stage.REJOIN: Schedule._event_never,
        Stage.REJOINED: Schedule._event_rejoined,
        Stage.LINEAR: Schedule._event_along,
        Stage.PRE: Schedule._event_before_hand_over,
        Stage.STOP: Schedule._event_never,
        Stage.BRAKE: Schedule._event_never,
    },
    Stage,
)
"""What ends each stage, from the segment under way and whether a stop was asked for."""

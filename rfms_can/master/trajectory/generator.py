"""The supervisor's half of the trajectory generator (section 3.4, Table 3.3, Appendix C).

Each tick yields the Cartesian set-point of one cycle; what the joints make of it is
:mod:`rfms_can.setpoint`. Time is counted in integer ticks, so that p ends at exactly 1 and no
set-point is skipped or sent twice.

A move takes over at t_seg - t_acc, its own t_acc before the goal under way. One requested too late
for that starts its transition on the tick after next: late, with no set-point repeated. It is then
nearer to the goal than its matching polynomial needs, and beyond a seventh of t_acc (where -5 t_acc
+ 35 late, the two terms of (3.18) that are left at p -> 1, change sign) would swing past that goal:
a move later than that starts from rest.
"""

from collections import deque
from collections.abc import Callable
from typing import Final

from rfms_can.errors import MoveError
from rfms_can.kinematics import Configuration
from rfms_can.master.trajectory.admission import check_path, check_succession, check_times
from rfms_can.master.trajectory.runner import SegmentRunner
from rfms_can.master.trajectory.segment import Move, Segment
from rfms_can.master.trajectory.states import Event, Stage, following
from rfms_can.setpoint import CartesianSetpoint
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Blend

LATEST: Final = 7
"""A transition may start late by t_acc over this without passing the goal it leaves."""

MAX_QUEUE: Final = 256
"""Moves that may wait; a program that asks for more is waiting for nothing."""


Admit = Callable[[Move, Move, int], None]
"""Raises where the arm cannot run from the first move's goal to the second's, at a tick."""


def _admit_all(before: Move, move: Move, tick: int) -> None:
    """What a generator without an arm knows of it."""


class TrajectoryGenerator:
    """Turns moves into one Cartesian set-point a cycle.

    Attributes:
        stage: where it is in :mod:`rfms_can.master.trajectory.states`.
        completed: sequence number of the last move that is over: at rest at its goal, or handed
            over to the next. 0 before the first.
        tick_count: ticks since construction; goals that move are evaluated at it.
    """

    def __init__(
        self,
        period_s: float,
        blend: Blend = Blend.CONTINUOUS,
        admit: Admit = _admit_all,
    ) -> None:
        """A generator that is off.

        Args:
            period_s: tau, s.
            blend: which matching polynomial the joints are to use.
            admit: what the arm has to say to a move; called at its request, after our own rules.
        """
        self.period_s: Final = period_s
        self.stage = Stage.OFF
        self.completed = 0
        self.tick_count = 0
        self._admit: Final = admit
        self._queue: deque[Move] = deque()
        self._last_sequence = 0
        self._stopping = False
        run = self._run = SegmentRunner(period_s, blend)
        self._rows: Final = {
            Stage.IDLE: run.idle,
            Stage.START: run.start,
            Stage.BLEND: run.blend,
            Stage.LINEAR: run.linear,
            Stage.PRE: run.pre,
            Stage.STOP: run.stop,
        }

    def enable(self, pose: Transform, configuration: Configuration) -> None:
        """Hold ``pose`` = T6: before the first move, or after a controlled stop.

        ``pose`` and ``configuration`` are those of the joint angles the arm has: measured, or
        commanded where it stopped. The numbers of moves that were dropped stay used.

        Raises:
            RfmsError: in motion.
        """
        self.stage = following(self.stage, Event.ENABLE)
        self._queue.clear()
        self._stopping = False
        self._run.hold(Segment.hold(pose, configuration))

    def disable(self) -> None:
        """No set-points any more, whatever the stage; all moves are dropped."""
        self.stage = following(self.stage, Event.DISABLE)
        self._queue.clear()

    def request(self, move: Move) -> None:
        """Queue ``move``.

        Raises:
            MoveError: it breaks a rule; the message names numbers and remedy. Nothing changes.
            KinematicsError: ``admit`` refuses it.
        """
        name = f"move {move.sequence}"
        if self.stage is Stage.OFF or self._stopping:
            doing = "stopping" if self._stopping else "off"
            raise MoveError(f"{name}: the trajectory generator is {doing}: enable it first")
        if move.sequence <= self._last_sequence:
            raise MoveError(f"{name}: numbers must grow, the last was {self._last_sequence}")
        if len(self._queue) >= MAX_QUEUE:
            raise MoveError(f"{name}: {MAX_QUEUE} moves wait already: wait until one is complete")
        check_times(move, self.period_s)
        before = self._last_accepted()
        if not before.rests:
            check_succession(before.move, move, self.period_s)
        check_path(before.move, move, self.tick_count)
        self._admit(before.move, move, self.tick_count)
        self._queue.append(move)
        self._last_sequence = move.sequence

    def stop(self) -> tuple[int, ...]:
        """Stop along the path and drop all moves.

        A transition under way is finished first: what it blends out would otherwise be left. Then
        h slows down within 2 t_acc (:func:`rfms_can.setpoint.blend.stop_parameter`), and the arm
        stays on its path throughout; ``stopped`` tells when it rests, and ``enable`` what to hold
        there.
        At rest, or on the way to it, there is nothing to stop.

        Returns:
            Sequence numbers of the moves that will not be completed.
        """
        run = self._run
        dropped = [move.sequence for move in self._queue]
        self._queue.clear()
        if run.next is not None and not run.next.rests:
            dropped.insert(0, run.next.move.sequence)
        if self.stage is Stage.IDLE:
            run.next = None
        elif self.stage is not Stage.OFF and not self._stopping and not self._ends_at_rest():
            self._stopping = True
            dropped.insert(0, run.segment.move.sequence)
        return tuple(dropped)

    @property
    def at_rest(self) -> bool:
        """Whether the arm stands at its goal (or follows one that moves) with no move waiting."""
        return self.stage is Stage.IDLE and not self._queue and self._run.next is None

    @property
    def stopped(self) -> bool:
        """Whether a controlled stop is over and ``enable`` is due."""
        return self.stage is Stage.STOP and self._run.has_stopped

    @property
    def waiting(self) -> int:
        """Moves in the queue."""
        return len(self._queue)

    @property
    def sequence(self) -> int:
        """Number of the move under way; 0 before the first."""
        return self._run.segment.move.sequence

    @property
    def feed(self) -> float:
        """Part of the modes' speed it runs at."""
        return 1.0

    def tick(self) -> CartesianSetpoint:
        """The set-point of the next cycle.

        Raises:
            RfmsError: the generator is off.
        """
        run, tick = self._run, self.tick_count
        left = run.segment
        stage = self.stage = following(self.stage, self._event())
        if stage is Stage.IDLE:
            self.completed = max(self.completed, left.move.sequence)
            if self._queue and run.next is None:
                run.settle(self._queue.popleft(), tick)
        elif stage is Stage.PRE and run.next is None:
            run.settle(self._queue.popleft() if self._taking_over() else None, tick)
        setpoint = self._rows[stage](tick)
        if stage is Stage.START and not run.segment.rests:
            self.completed = left.move.sequence
        self.tick_count = tick + 1
        return setpoint

    def _event(self) -> Event:
        """What happens between the last tick and this one."""
        run, stage = self._run, self.stage
        if stage is Stage.LINEAR:
            return self._event_along()
        event = Event.STAY
        if stage is Stage.BLEND:
            if run.n >= run.segment.move.acceleration_ticks:
                event = Event.ARRIVED if run.segment.rests else self._event_along()
                event = Event.BLENDED if event is Event.STAY else event
        elif stage is Stage.IDLE:
            if run.next is not None and run.watched >= run.watch_ticks(run.next.move):
                event = Event.DEPART
        elif stage is Stage.PRE:
            if self._stopping:
                event = Event.HALT
            elif run.n + 1 >= run.hand_over:
                event = Event.DEPART
        return event

    def _event_along(self) -> Event:
        """Whether the straight part of the segment goes on."""
        if self._stopping:
            return Event.HALT
        run = self._run
        move = self._taking_over() or run.segment.move
        lead = move.acceleration_ticks + run.watch_ticks(move)
        due = run.n + 1 >= run.segment.move.segment_ticks - lead
        return Event.PREPARE if due else Event.STAY

    def _taking_over(self) -> Move | None:
        """The move that follows without rest; None if there is none, or it came too late."""
        if not self._queue:
            return None
        run, move = self._run, self._queue[0]
        late = run.n + 2 - (run.segment.move.segment_ticks - move.acceleration_ticks)
        return move if late * LATEST <= move.acceleration_ticks else None

    def _ends_at_rest(self) -> bool:
        """Whether the transition to rest is settled or under way."""
        run = self._run
        return run.segment.rests or (run.next is not None and run.next.rests)

    def _last_accepted(self) -> Segment:
        """What a new move would follow; it ``rests`` where that leaves all the time there is."""
        if self._queue:
            return Segment(self._queue[-1])
        return self._run.segment if self._run.next is None else self._run.next

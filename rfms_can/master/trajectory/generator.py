"""The master's half of the trajectory generator (section 3.4, Table 3.3, Appendix C).

Each tick yields the Cartesian set-point of one cycle; what the joints make of it is
:mod:`rfms_can.setpoint`. Time is counted in integer ticks, so that p ends at exactly 1 and no
set-point is skipped or sent twice.

A move takes over at t_seg - t_acc, its own t_acc before the goal under way. One requested too late
for that starts its transition on the tick after next: late, with no set-point repeated. It is then
nearer to the goal than its matching polynomial needs, and beyond a seventh of t_acc (where -5 t_acc
+ 35 late, the two terms of (3.18) that are left at p -> 1, change sign) would swing past that goal:
a move later than that starts from rest.
"""

from collections.abc import Mapping
from typing import Final

from rfms_can.errors import MoveError
from rfms_can.kinematics import Configuration, Joints
from rfms_can.master.trajectory.admission import check_feed
from rfms_can.master.trajectory.goal import Goal
from rfms_can.master.trajectory.outcomes import MoveOutcomes
from rfms_can.master.trajectory.pace import MIN_FEED, Pace
from rfms_can.master.trajectory.queue import MoveQueue
from rfms_can.master.trajectory.runner import SegmentRunner
from rfms_can.master.trajectory.schedule import Schedule
from rfms_can.master.trajectory.segment import Entry, Move, Rest, Segment, Transition
from rfms_can.master.trajectory.states import Event, Stage, following
from rfms_can.messages import Outcome
from rfms_can.setpoint import CartesianSetpoint
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Blend


class TrajectoryGenerator:
    """Turns moves into one Cartesian set-point a cycle.

    Attributes:
        stage: where it is in :mod:`rfms_can.master.trajectory.states`.
        outcomes: which moves are over, and how.
        tick_count: ticks since construction; goals that move are evaluated at it.
    """

    def __init__(
        self,
        period_s: float,
        blend: Blend = Blend.CONTINUOUS,
    ) -> None:
        """A generator that is off.

        Args:
            period_s: tau, s.
            blend: which matching polynomial the joints are to use.
        """
        self.period_s: Final = period_s
        self.stage = Stage.OFF
        self.outcomes: Final = MoveOutcomes()
        self.tick_count = 0
        self._queue: Final = MoveQueue(period_s)
        self._stopping = False
        self._pace: Final = Pace(period_s)
        run = self._run = SegmentRunner(period_s, blend)
        self._schedule: Final = Schedule(run, self._queue, self._pace, blend)
        self._rows: Final = {
            Stage.IDLE: run.idle,
            Stage.START: run.start,
            Stage.BLEND: run.blend,
            Stage.CURVE: run.curve,
            Stage.REJOIN: run.rejoin,
            Stage.REJOINED: run.rejoined,
            Stage.LINEAR: run.linear,
            Stage.PRE: run.pre,
            Stage.STOP: run.stop,
        }

    def enable(
        self, pose: Transform, configuration: Configuration, angles: Joints | None = None
    ) -> None:
        """Hold ``pose`` = T6: before the first move, or after a controlled stop.

        ``pose`` and ``configuration`` are those of the joint angles the arm has: measured, or
        commanded where it stopped. The numbers of moves that were dropped stay used; feed rate
        and pause stay as they are.

        Raises:
            RfmsError: in motion.
        """
        self.stage = following(self.stage, Event.ENABLE)
        self._queue.clear()
        self._stopping = False
        self.outcomes.rests()
        self._pace.jump()
        self._run.hold(Segment.hold(pose, configuration, angles))

    def disable(self, reason: str = "the drives were switched off") -> None:
        """No set-points any more, whatever the stage; ``reason`` has faulted all moves."""
        self.stage = following(self.stage, Event.DISABLE)
        self._queue.clear()
        self.outcomes.abandon(Outcome.FAULTED, reason)

    def request(self, *parts: Move) -> None:
        """Queue the parts of one move.

        Raises:
            MoveError: one breaks a rule; the message names numbers and remedy. Nothing changes.
        """
        if self.stage is Stage.OFF or self._stopping:
            name = f"move {parts[0].sequence}" if parts else "a move"
            if self.stage is Stage.OFF:
                raise MoveError(f"{name}: the trajectory generator is off: enable it first")
            raise MoveError(f"{name}: the arm is stopping: wait until it rests")
        self._queue.take(parts, self.last_accepted, self.tick_count, self._pace.rate)
        self.outcomes.accept(parts[0].sequence)

    def replace(self, moves: Mapping[int, tuple[Move, ...]]) -> None:
        """Other parts of moves that have not begun; their numbers, and their order, stay.

        Args:
            moves: parts by number; of ``not_begun``, without a gap.

        Raises:
            MoveError: one breaks a rule; the message names numbers and remedy. Nothing changes.
        """
        before = self.before(min(moves))
        self._queue.replace(moves, before, self.tick_count, self._pace.rate)

    def before(self, sequence: int) -> Segment:
        """What a move that has not begun is to follow, as ``last_accepted`` was for it."""
        earlier = [move for move in self._queue if move.sequence < sequence]
        if earlier:
            return Segment(earlier[-1])
        return self._run.segment if self._run.next is None else self._run.next

    def departs_from_rest(self, sequence: int) -> bool:
        """Whether nothing lies between the rest the arm is in and a move that has not begun."""
        first = not self._queue or self._queue[0].sequence >= sequence
        return self.stage is Stage.IDLE and self._run.next is None and first

    @property
    def not_begun(self) -> dict[int, tuple[Move, ...]]:
        """The parts, by number, of the moves that wait: neither under way nor settled."""
        run = self._run
        begun = (run.next or run.segment).move.sequence
        waiting: dict[int, tuple[Move, ...]] = {}
        for move in self._queue:
            if move.sequence > begun:
                waiting[move.sequence] = (*waiting.get(move.sequence, ()), move)
        return waiting

    def pause(self) -> None:
        """Slow down on the path to a standstill, and stay until ``resume``.

        It takes 2 t_acc, as a controlled stop does. Where a hand-over is too near for that, the
        arm slows down after it: in all within 4 t_acc of the segments concerned, or so, in local
        time. Goals that move by themselves go on, and the arm with them. At rest no move departs.
        """
        self._pace.paused = True
        self._schedule.unsettle(self.stage)

    def resume(self) -> None:
        """Go on at the feed rate; slower up to a hand-over that is near, and then faster."""
        self._pace.paused = False
        self._schedule.unsettle(self.stage)

    def set_feed(self, rate: float) -> None:
        """Run at ``rate`` of the moves' speed, on the same path. Takes as long as ``pause`` does.

        Raises:
            MoveError: not in 0.05 to 1, or too slow for a move that is accepted.
        """
        if not MIN_FEED <= rate <= 1.0:  # also NaN
            raise MoveError(
                f"a feed rate of {rate:g} is not in {MIN_FEED:g} to 1: to stand still, pause"
            )
        settled = () if self._run.next is None else (self._run.next.move,)
        for move in (self._run.segment.move, *settled, *self._queue):
            check_feed(move, rate, self.period_s)
        self._pace.rate = rate
        self._schedule.unsettle(self.stage)

    def stop(
        self, how: Outcome = Outcome.STOPPED, reason: str = "a stop was requested"
    ) -> tuple[int, ...]:
        """Stop along the path and drop all moves.

        A transition under way is finished first: what it blends out would otherwise be left. Then
        h slows down within 2 t_acc (:func:`rfms_can.setpoint.blend.stop_parameter`), and the arm
        stays on its path throughout; ``stopped`` tells when it rests, and ``enable`` what to hold
        there. It does so at the pace it has; in a pause it stays where it stands, or will.
        At rest, or coming to it, there is nothing to stop.

        Args:
            how: the outcome of the moves that will not be completed.
            reason: what ended them.

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
        elif (
            self.stage is not Stage.OFF
            and not self._stopping
            and (self._pace.paused or not self._ends_at_rest())
        ):
            self._stopping = True
            dropped.insert(0, run.segment.move.sequence)
        self.outcomes.ends(dropped, how, reason)
        return tuple(dict.fromkeys(dropped))

    def brake(self, reason: str) -> bool:
        """The joints cannot follow: drop all moves; set-points come from a brake until ``enable``.

        Returns:
            Whether a move was not over yet, so that its outcome tells ``reason``.
        """
        run = self._run
        self.stage = following(self.stage, Event.BRAKE)
        self._queue.clear()
        run.next = None
        self._stopping = True
        unfinished = range(self.outcomes.completed + 1, self.outcomes.accepted + 1)
        self.outcomes.ends(unfinished, Outcome.SHORT, reason)
        return bool(unfinished)

    def pass_tick(self) -> None:
        """A cycle whose set-point comes from elsewhere."""
        self.tick_count += 1

    @property
    def completed(self) -> int:
        """The highest number such that all moves up to it are over, in whatever way."""
        return self.outcomes.completed

    @property
    def at_rest(self) -> bool:
        """Whether the arm stands at its goal (or follows one that moves) with no move waiting."""
        return self.stage is Stage.IDLE and not self._queue and self._run.next is None

    @property
    def stopped(self) -> bool:
        """Whether a controlled stop is over, or held by a pause, and ``enable`` is due."""
        if self.stage is Stage.STOP:
            return self._run.has_stopped or self._pace.stands
        held = self._stopping and self._pace.stands
        return held and self.stage in (Stage.BLEND, Stage.CURVE)

    @property
    def waiting(self) -> int:
        """Moves in the queue, in parts."""
        return len(self._queue)

    @property
    def sequence(self) -> int:
        """Number of the move under way; 0 before the first."""
        return self._run.segment.move.sequence

    @property
    def feed(self) -> float:
        """Fraction of the moves' speed it runs at."""
        return self._pace.feed

    @property
    def paused(self) -> bool:
        """Whether a pause is requested; the arm stands as soon as ``feed`` is 0."""
        return self._pace.paused

    @property
    def last_accepted(self) -> Segment:
        """What a new move would follow; it ``rests`` where that leaves all the time there is."""
        if self._queue:
            return Segment(self._queue[-1])
        return self._run.segment if self._run.next is None else self._run.next

    @property
    def entry(self) -> Entry:
        """What a new move would enter from."""
        return self._entry(self.last_accepted)

    def entry_of(self, sequence: int) -> Entry:
        """What a move that has not begun enters from."""
        return self._entry(self.before(sequence))

    def _entry(self, before: Segment) -> Entry:
        run = self._run
        entry = Entry(before, self.tick_count, feed_rate=self._pace.rate)
        if run.next is None and before is run.segment:
            entry = entry._replace(left=before.move.segment_ticks - run.n)
        return entry._replace(rest=self._rest()) if before.rests else entry

    def _rest(self) -> Rest:
        """The rest the arm is in, or comes to."""
        run = self._run
        if run.next is not None:
            return Rest.after(run.segment)
        left = max(0.0, run.segment.move.acceleration_ticks - run.n)
        return Rest(run.clock + (0.0 if run.rested else left), run.rested)

    @property
    def active_goals(self) -> tuple[Goal, ...]:
        """Goals of the segment under way and of the one settled to follow."""
        run = self._run
        goal = run.segment.move.target
        return (goal,) if run.next is None else (goal, run.next.move.target)

    def tick(self) -> CartesianSetpoint:
        """The set-point of the next cycle.

        Raises:
            RfmsError: the generator is off.
        """
        run, tick = self._run, self.tick_count
        left = run.segment
        self._schedule.set_pace(self.stage, stopping=self._stopping)
        event = self._schedule.event(self.stage, stopping=self._stopping)
        stage = self.stage = following(self.stage, event)
        if stage is Stage.IDLE:
            self._stopping = False
            self._complete(left)
            self.outcomes.rests()
            if run.next is None and self._schedule.may_depart(Transition.JOINT):
                run.settle(*self._schedule.take(stage), tick)
        elif event is Event.BEND or (stage is Stage.PRE and run.next is None):
            enter = run.bend if event is Event.BEND else run.settle
            enter(*self._schedule.take(stage), tick)
        setpoint = self._rows[stage](tick)
        if (stage is Stage.START or event is Event.BEND) and not run.segment.rests:
            self._complete(left)
        self.tick_count = tick + 1
        return setpoint

    def _complete(self, left: Segment) -> None:
        if left.move.last:
            self.outcomes.arrived(left.move.sequence)

    def _ends_at_rest(self) -> bool:
        """Whether the transition to rest is settled or under way."""
        run = self._run
        return run.segment.rests or (run.next is not None and run.next.rests)

"""The rows of Table 3.3, seen from the master: where T6 is at each tick of a segment."""

from typing import Final

from rfms_can.kinematics import Configuration, Joints
from rfms_can.master.trajectory.correction import NO_CORRECTION, Leaving
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.trajectory.segment import Move, Segment, Transition
from rfms_can.master.trajectory.states import ON_THE_WIRE, Stage
from rfms_can.setpoint import CartesianSetpoint
from rfms_can.setpoint.blend import blend_parameter, stop_parameter
from rfms_can.setpoint.history import window_for
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Blend, Mode

_Second = tuple[Transform, Joints | None]
"""T6_2, and joint angles (rad) near it."""

_NOWHERE: Final = Segment.hold(Transform.identity(), Configuration(True, True, True))


class SegmentRunner:
    """Runs along one segment and on into the next; what comes when is decided by its owner.

    Attributes:
        segment: under way.
        resting: what follows it where no move does.
        next: settled to follow, or None. Its D(1) is fixed from then on, so that its start point
            B travels with its goal and the joints can see how fast.
        step: local time from the last tick to the one at hand, periods: the pace.
        n: local time, periods, -n_acc to n_seg; whole at full speed.
        h: segment parameter.
        clock: local time the goal is told. That of a transition to rest and of rest itself goes
            on from the segment they end.
        rested: ticks at rest.
        watched: ticks the start of ``next`` has been sent as T6_2.
        hand_over: local time at which ``next`` is to start.
        stop_ticks: local time into a controlled stop.
        told: ticks since the joints were told the line of a joint-mode segment at p = 1.
    """

    __slots__ = (
        "_acceleration_time",
        "_begun",
        "_blend",
        "_configuration",
        "_correction",
        "_period",
        "_watch",
        "clock",
        "h",
        "hand_over",
        "n",
        "next",
        "rested",
        "resting",
        "segment",
        "step",
        "stop_ticks",
        "told",
        "watched",
    )

    def __init__(self, period_s: float, blend: Blend) -> None:
        self._period: Final = period_s
        self._blend: Final = blend
        self._correction = NO_CORRECTION
        self.step = 1.0
        self.hold(_NOWHERE)

    def hold(self, segment: Segment) -> None:
        """Forget everything and rest in ``segment``."""
        self.segment = segment
        self.resting = segment.move.to_rest()
        self.next: Segment | None = None
        self.n: float = 0
        self.clock: float = 0
        self.h = 1.0
        self.rested = self.watched = self._watch = 0
        self.hand_over: float = 0
        self.stop_ticks: float = 0
        self.told = 0
        self._begun: tuple[Transform, Configuration, Transform] | None = None
        self._configuration = segment.move.configuration
        self._acceleration_time = segment.move.acceleration_ticks * self._period

    def watch_ticks(self, move: Move) -> int:
        """Ticks to look at where the segment of ``move`` starts before it does.

        One tells how fast it moves (3.17); the continuous blend wants to know more. A Cartesian
        transition asks the joints nothing.
        """
        if move.transition is Transition.CARTESIAN:
            return 0
        if move.target.constant or self._blend is Blend.THESIS or self.step == 0.0:
            return 1
        return window_for(round(move.acceleration_ticks / self.step)) - 1

    def is_known_at_rest(self, move: Move) -> bool:
        """Whether the joints know how the goal they rest at moves, to leave it for ``move``."""
        if self.segment.move.target.constant or self._blend is Blend.THESIS or self.step == 0.0:
            return True
        return self.rested >= window_for(round(move.acceleration_ticks / self.step))

    def settle(self, move: Move | None, hand_over: float, tick: int) -> None:
        """Fix what follows at ``hand_over``: ``move``, or the transition to rest at this goal."""
        if move is None:
            self.next = self.segment.to_rest()
        else:
            self.next = self._towards(move, tick, self.clock)
        self.watched = 0
        self._watch = self.watch_ticks(self.next.move)
        self.hand_over = hand_over

    def idle(self, tick: int) -> CartesianSetpoint:
        """At the goal; T6_2 as soon as there is a next segment."""
        self.n, self.h = 0, 1.0
        self.clock += self.step
        self.rested += 1
        ahead = (self._watch - self.watched) * self.step
        return self._along(Stage.IDLE, tick, 0.0, self._start_of_next(tick, ahead))

    def start(self, tick: int) -> CartesianSetpoint:
        """Row 3: the next segment becomes the one under way."""
        if self.next is None:
            raise AssertionError("START before the next segment is settled")
        left = self.segment.move
        self.clock += self.step
        at_goal = Moment(tick, 1.0, self.clock * self._period)
        past = 0 if self.rested else self.n + self.step - self.hand_over
        self._enter(self.next, past)
        segment, moment = self.segment, self._moment(tick)
        move = segment.move
        p = past / (2 * move.acceleration_ticks)
        if segment.drive is not None:
            pose = segment.pose(moment, 1.0)
            return self._setpoint(Stage.START, pose, left.configuration, None, p, move.start_angles)
        pose, near = left.target.pose(at_goal), left.goal_angles if left.target.constant else None
        goal = (move.target.pose(moment), self._near_second(segment))
        self._begun = (pose, left.configuration, goal[0])
        return self._setpoint(Stage.START, pose, left.configuration, goal, p, near)

    def bend(self, move: Move | None, hand_over: float, tick: int) -> None:
        """Enter the segment of ``move``, or the transition to rest, by a Cartesian transition."""
        left = self._lined()
        leaving = Leaving(left, tick - 1, self.n, self.clock, self.step, self._period)
        if move is None:
            segment = left.to_rest()
        else:
            segment = self._towards(move, tick - 1, self.clock + hand_over - self.n)
        self._correction = leaving.into(segment, hand_over)
        self._configuration = left.move.configuration
        self._enter(segment, self.n - hand_over)

    def _lined(self) -> Segment:
        """The segment under way; in joint mode with the line its joints run along."""
        segment, begun = self.segment, self._begun
        joints = segment.move.joints
        if segment.drive is not None or segment.line is not None or segment.rests:
            return segment
        if joints is None or begun is None:
            return segment
        return segment._replace(line=joints.line(*begun, segment.move.configuration))

    def curve(self, tick: int) -> CartesianSetpoint:
        """A Cartesian transition: row 4, but in space, and in the configuration it begins in.

        A joint-mode goal that moves is told in its second half as T6_2: the joints must know how
        it moves when they leave the segment.
        """
        p = self._blended()
        if self.segment.rests:
            self.h = 1.0
        segment, moment = self.segment, self._moment(tick)
        pose = self._correction.pose(segment, moment, 1.0 - self.h, p)
        stage: Stage = Stage.CURVE
        second: _Second | None = None
        if segment.line is not None and p >= 0.5 and not segment.move.target.constant:
            stage, second = Stage.PRE, (segment.pose(moment, 1.0), segment.first_angles)
        setpoint = self._setpoint(stage, pose, self._configuration, second, p, None)
        return setpoint if segment.line is None else setpoint._replace(mode=Mode.CARTESIAN)

    def rejoin(self, tick: int) -> CartesianSetpoint:
        """Row 3 at p = 1: what a joint-mode segment that is under way is measured from.

        The joints have followed T6 and do not know theta_BC. START tells it, by B and the goal, and
        p = 1 that the motion has joined the line already. That is all SETPOINT has to say: the
        other way, T6 of the whole segment, would end where a joint-mode path passes a singularity
        or changes its configuration.
        """
        self._advance()
        segment, moment = self.segment, self._moment(tick)
        if segment.line is None:
            raise AssertionError("REJOIN without a joint-mode segment")
        goal = segment.pose(moment, 1.0)
        start, configuration = segment.line.start(None if segment.move.target.constant else goal)
        self.told = 0
        near = segment.first_angles
        return self._setpoint(Stage.REJOIN, start, configuration, (goal, near), 1.0, None)

    def rejoined(self, tick: int) -> CartesianSetpoint:
        """Row 4 at p = 1, which is row 1."""
        self._advance()
        self.told += 1
        return self._along(Stage.REJOINED, tick, 1.0)

    def blend(self, tick: int) -> CartesianSetpoint:
        """Row 4."""
        return self._along(Stage.BLEND, tick, self._blended())

    def linear(self, tick: int) -> CartesianSetpoint:
        """Row 1."""
        self._advance()
        return self._along(Stage.LINEAR, tick, 0.0)

    def pre(self, tick: int) -> CartesianSetpoint:
        """Row 2, once or, ahead of a moving goal, for some ticks."""
        self._advance()
        second = self._start_of_next(tick, self.hand_over - self.n)
        return self._along(Stage.PRE, tick, 0.0, second)

    def stop(self, tick: int) -> CartesianSetpoint:
        """Row 1 with the h of a stop that began at the last tick of even motion."""
        self.next = None
        ticks = self._stop_acceleration
        span = 2 * ticks
        m = self.stop_ticks = min(self.stop_ticks + self.step, span)
        self.clock = self.n + ticks * stop_parameter(m / span)
        self.h = self.clock / self.segment.move.segment_ticks
        return self._along(Stage.STOP, tick, 0.0)

    @property
    def has_stopped(self) -> bool:
        """Whether the controlled stop is over."""
        return self.stop_ticks >= 2 * self._stop_acceleration

    @property
    def _stop_acceleration(self) -> float:
        """t_acc of a controlled stop: as to rest, or to the goal if the stop began near it.

        It begins no later than what follows would have taken over.
        """
        move = self.segment.move
        return max(1.0, min(move.rest_ticks, move.segment_ticks - self.n))

    def _towards(self, move: Move, tick: int, clock: float) -> Segment:
        """The segment of ``move`` from this goal, as both are at ``tick`` and at the hand-over."""
        origin = self.segment.move.target.pose(Moment(tick, 1.0, clock * self._period))
        start = Moment(tick, 0.0, -move.acceleration_ticks * self._period)
        segment = Segment.towards(move, origin, start)
        if not move.rejoins or move.joints is None:
            return segment
        ends = (origin, self.segment.move.configuration, move.target.pose(start))
        return segment._replace(line=move.joints.line(*ends, move.configuration))

    def _enter(self, segment: Segment, past: float) -> None:
        """``segment`` is under way, ``past`` its beginning."""
        ticks = segment.move.acceleration_ticks
        self.segment, self.next = segment, None
        self.resting = segment.move.to_rest()
        self.n, self.h = past - ticks, 0.0
        if not segment.rests:
            self.clock = self.n
        self.rested = 0
        self._acceleration_time = ticks * self._period / self.step

    def _advance(self) -> None:
        """One step along the straight part of the segment."""
        self.n += self.step
        self.clock += self.step
        self.h = self.n / self.segment.move.segment_ticks

    def _blended(self) -> float:
        """One step of a transition: p."""
        self._advance()
        ticks = self.segment.move.acceleration_ticks
        p = (self.n + ticks) / (2 * ticks)
        self.h = blend_parameter(p) * ticks / self.segment.move.segment_ticks
        return p

    def _moment(self, tick: int) -> Moment:
        """The motion parameters of the segment under way. A transition to rest is at its goal."""
        return Moment(tick, 1.0 if self.segment.rests else self.h, self.clock * self._period)

    def _start_of_next(self, tick: int, ahead: float) -> _Second | None:
        """Where the next segment is, ``ahead`` of its start: h = 0, and t counts up to -t_acc."""
        if self.next is None:
            return None
        self.watched += 1
        h, clock = 1.0, self.clock
        if not self.next.rests:
            h, clock = 0.0, -ahead - self.next.move.acceleration_ticks
        pose = self.next.pose(Moment(tick, h, clock * self._period), 1.0)
        return (pose, self._near_second(self.next))

    def _near_second(self, segment: Segment) -> Joints | None:
        """Angles near T6_2, rad: of what moves by itself only where it is told first, and not of
        the goal at which the arm is already."""
        if segment.move.target.constant or (self.watched <= 1 and not segment.rests):
            return segment.first_angles
        return None

    def _along(
        self, stage: Stage, tick: int, p: float, second: _Second | None = None
    ) -> CartesianSetpoint:
        """The set-point on this segment's path at h."""
        segment = self.segment
        pose = segment.pose(self._moment(tick), 1.0 - self.h)
        return self._setpoint(stage, pose, segment.move.configuration, second, p, segment.angles)

    def _setpoint(
        self,
        stage: Stage,
        pose: Transform,
        configuration: Configuration,
        second: _Second | None,
        p: float,
        near: Joints | None,
    ) -> CartesianSetpoint:
        move = self.segment.move
        upcoming = move if self.next is None else self.next.move
        t6_2, near_2 = second or (None, None)
        return CartesianSetpoint(
            ON_THE_WIRE[stage],
            move.mode,
            self._blend,
            1.0 - self.h,
            p,
            self._acceleration_time,
            pose,
            configuration,
            t6_2,
            upcoming.configuration,
            self.n,
            self.h,
            move.sequence,
            near,
            near_2,
        )

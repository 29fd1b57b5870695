"""The rows of Table 3.3, seen from the supervisor: where T6 is at each tick of a segment."""

from typing import Final

from rfms_can.kinematics import Configuration
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.trajectory.segment import Move, Segment
from rfms_can.master.trajectory.states import ON_THE_WIRE, Stage
from rfms_can.setpoint import CartesianSetpoint
from rfms_can.setpoint.blend import blend_parameter, stop_parameter
from rfms_can.setpoint.history import window_for
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Blend

_NOWHERE: Final = Segment.hold(Transform.identity(), Configuration(True, True, True))


class SegmentRunner:
    """Runs along one segment and on into the next; what comes when is decided by its owner.

    Attributes:
        segment: under way.
        next: settled to follow, or None. Its D(1) is fixed from then on, so that its start point
            B travels with its goal and the joints can see how fast.
        n: local tick, -n_acc to n_seg.
        h: segment parameter.
        watched: ticks the start of ``next`` has been sent as T6_2.
        hand_over: local tick at which ``next`` is to start.
        stop_ticks: ticks into a controlled stop.
    """

    __slots__ = (
        "_acceleration_time",
        "_blend",
        "_period",
        "h",
        "hand_over",
        "n",
        "next",
        "segment",
        "stop_ticks",
        "watched",
    )

    def __init__(self, period_s: float, blend: Blend) -> None:
        self._period: Final = period_s
        self._blend: Final = blend
        self.hold(_NOWHERE)

    def hold(self, segment: Segment) -> None:
        """Forget everything and rest in ``segment``."""
        self.segment = segment
        self.next: Segment | None = None
        self.n, self.h = 0, 1.0
        self.watched = self.hand_over = self.stop_ticks = 0
        self._acceleration_time = segment.move.acceleration_ticks * self._period

    def watch_ticks(self, move: Move) -> int:
        """Ticks to look at where the segment of ``move`` starts before it does.

        One tells how fast it moves (3.17); the continuous blend wants to know more.
        """
        if move.target.constant or self._blend is Blend.THESIS:
            return 1
        return window_for(move.acceleration_ticks) - 1

    def settle(self, move: Move | None, tick: int) -> None:
        """Fix what follows: ``move``, or the transition to rest at this segment's goal.

        The hand-over is at t_seg - t_acc of what follows; settled too late for that, it is on the
        tick after next, once its start has been sent.
        """
        left = self.segment.move
        if move is None:
            self.next = self.segment.to_rest()
        else:
            self.next = Segment.towards(move, left.target.pose(Moment(tick)), Moment(tick, 0.0))
        self.watched = 0
        self.hand_over = left.segment_ticks - self.next.move.acceleration_ticks

    def idle(self, tick: int) -> CartesianSetpoint:
        """At the goal; T6_2 as soon as there is a next segment."""
        self.n, self.h = 0, 1.0
        return self._along(Stage.IDLE, tick, 0.0, self._start_of_next(tick))

    def start(self, tick: int) -> CartesianSetpoint:
        """Row 3: the next segment becomes the one under way."""
        if self.next is None:
            raise AssertionError("START before the next segment is settled")
        left = self.segment.move
        segment, self.segment, self.next = self.next, self.next, None
        move = segment.move
        self.n, self.h = -move.acceleration_ticks, 0.0
        self._acceleration_time = move.acceleration_ticks * self._period
        if segment.drive is not None:
            pose, goal = segment.pose(Moment(tick, 0.0), 1.0), None
        else:
            pose, goal = left.target.pose(Moment(tick)), move.target.pose(Moment(tick, 0.0))
        return self._setpoint(Stage.START, pose, left.configuration, goal, 0.0)

    def blend(self, tick: int) -> CartesianSetpoint:
        """Row 4."""
        n = self.n = self.n + 1
        move = self.segment.move
        ticks = move.acceleration_ticks
        p = (n + ticks) / (2 * ticks)
        self.h = blend_parameter(p) * ticks / move.segment_ticks
        return self._along(Stage.BLEND, tick, p)

    def linear(self, tick: int) -> CartesianSetpoint:
        """Row 1."""
        n = self.n = self.n + 1
        self.h = n / self.segment.move.segment_ticks
        return self._along(Stage.LINEAR, tick, 0.0)

    def pre(self, tick: int) -> CartesianSetpoint:
        """Row 2, once or, ahead of a moving goal, for some ticks."""
        n = self.n = self.n + 1
        self.h = n / self.segment.move.segment_ticks
        return self._along(Stage.PRE, tick, 0.0, self._start_of_next(tick))

    def stop(self, tick: int) -> CartesianSetpoint:
        """Row 1 with the h of a stop that began at the last tick of even motion."""
        self.next = None
        move = self.segment.move
        span = 2 * move.acceleration_ticks
        m = self.stop_ticks = min(self.stop_ticks + 1, span)
        self.h = (self.n + move.acceleration_ticks * stop_parameter(m / span)) / move.segment_ticks
        return self._along(Stage.STOP, tick, 0.0)

    @property
    def has_stopped(self) -> bool:
        """Whether the controlled stop is over."""
        return self.stop_ticks >= 2 * self.segment.move.acceleration_ticks

    def _start_of_next(self, tick: int) -> Transform | None:
        if self.next is None:
            return None
        self.watched += 1
        return self.next.pose(Moment(tick, 0.0), 1.0)

    def _along(
        self, stage: Stage, tick: int, p: float, second: Transform | None = None
    ) -> CartesianSetpoint:
        """The set-point on this segment's path at h."""
        segment = self.segment
        pose = segment.pose(Moment(tick, self.h), 1.0 - self.h)
        return self._setpoint(stage, pose, segment.move.configuration, second, p)

    def _setpoint(
        self,
        stage: Stage,
        pose: Transform,
        configuration: Configuration,
        second: Transform | None,
        p: float,
    ) -> CartesianSetpoint:
        move = self.segment.move
        upcoming = move if self.next is None else self.next.move
        return CartesianSetpoint(
            ON_THE_WIRE[stage],
            move.mode,
            self._blend,
            1.0 - self.h,
            p,
            self._acceleration_time,
            pose,
            configuration,
            second,
            upcoming.configuration,
            self.n,
            self.h,
            move.sequence,
        )

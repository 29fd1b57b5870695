"""The base of a planned segment's set-points (3.12, 3.23) as functions of local time.

Goals are taken as they are at one tick. Where nothing moves by itself, the angles along a path are
a function of h alone, and stay when the segment's time changes.
"""

import math
from typing import Final, NamedTuple, Self

import numpy as np

from rfms_can.errors import KinematicsError, MoveError
from rfms_can.kinematics import (
    EXACT_WRIST_BOUND,
    WRIST_BOUND,
    InverseKinematics,
    Joints,
    nearest_singularity,
)
from rfms_can.master.trajectory.goal import Moment, joint_coordinates
from rfms_can.master.trajectory.planning.curve import Curve, Floats
from rfms_can.master.trajectory.segment import Segment, Transition
from rfms_can.setpoint.history import window_for
from rfms_can.wire.vocabulary import Mode

LEAP: Final = 1.0
"""Rad between two of the closest samples of a path that say: here it is not continuous."""

NEXT_TO: Final = tuple(1e-9 * 2.0**k for k in range(28))
"""How far, in h, from an end of a path with a straight wrist theta4 is looked at: the nearest place
where the path tells it, twice and three times as far. What it tends to follows by a parabola."""

WATCHED: Final = (0.25, 0.5, 0.75, 1.0)
"""Where in the time that joints watch a moving start it is looked at."""

TOLD: Final = 10.0 * EXACT_WRIST_BOUND
"""|S5| from which on a pose in double precision tells theta4, to 3e-10 rad."""


ROUNDING: Final = 1e-6
"""Rad that a pose next to a singularity may be off the angles it was made of."""


class Frame(NamedTuple):
    """What all bases of one plan share: inverse kinematics, goals' tick, tau in s."""

    kinematics: InverseKinematics
    tick: int
    period_s: float

    def at_goal(self, segment: Segment) -> Moment:
        """The moment at which ``segment`` would be at its goal."""
        return self.at(1.0, segment.move.segment_ticks)

    def at(self, h: float, ticks: float) -> Moment:
        """The moment at h and a local time in periods."""
        return Moment(self.tick, h, ticks * self.period_s)


class Base:
    """The base of one segment.

    A straight wrist leaves theta4 open. In joint mode a goal takes it as the arm has it; a straight
    line that begins or ends there takes the angle it tends to, which the path alone tells.

    Attributes:
        segment: with the times it is judged with, and theta4 where it is open.
        start: angles at B, where it begins, rad.
        goal: at its goal, on the turns the arm will have there, rad.
    """

    __slots__ = (
        *("_entry", "_frame", "_given", "_path", "_rest", "_theta_BC"),
        *("goal", "segment", "start"),
    )

    def __init__(
        self, frame: Frame, segment: Segment, start: Joints, path: Curve | None = None
    ) -> None:
        """``path`` is that of the same segment with other times.

        Raises:
            KinematicsError: the goal, or a pose on the path, has no solution.
            MoveError: the path is not continuous in joint angles.
        """
        self._frame: Final = frame
        self.segment = segment
        self.start: Final = start
        self._given: Final = (
            joint_coordinates(segment.move.target) if segment.drive is None else None
        )
        move, tau = segment.move, frame.period_s
        beginning, end = -move.acceleration_ticks * tau, move.segment_ticks * tau
        rest = move.rest_ticks * tau
        self._theta_BC: Floats | None = None
        self._entry: Curve | None = None
        self._rest: Curve | None = None
        self._path: Curve | None = path
        first: Joints | None = None
        if move.mode is Mode.JOINT:
            first = self.solve(0.0, beginning, start)
            self._theta_BC = np.subtract(start, first)
        if not move.target.constant:
            self._look_ahead(beginning)
            self._entry = Curve(self._blending, (beginning, -beginning), start)
            self._path = Curve(self._even, (-beginning, end), self._entry.last)
            self._rest = Curve(self._at_goal, (end - rest, end + rest), self._path.last)
        elif move.mode is Mode.CARTESIAN and path is None:
            self._path = Curve(self._along, (0.0, 1.0), start)
        self._refuse_leaps()
        path = self._path
        self.goal: Final[Joints] = (
            self.solve(1.0, end, start, start[3]) if path is None else path.last
        )
        fixed = move.target.constant
        begun = path.first if path is not None and fixed else None
        move = move._replace(start_angles=begun, goal_angles=self.goal if fixed else first)
        self.segment = segment._replace(move=move)

    def with_time(self, segment_ticks: int, acceleration_ticks: int) -> Self:
        """The same with other times."""
        move = self.segment.move._replace(
            segment_ticks=segment_ticks, acceleration_ticks=acceleration_ticks
        )
        path = self._path if move.target.constant else None
        return type(self)(self._frame, self.segment._replace(move=move), self.start, path)

    def from_rest(self) -> Self:
        """The same as it departs from rest."""
        move = self.segment.move
        rested = move.from_rest()
        if rested.acceleration_ticks == move.acceleration_ticks:
            return self
        return self.with_time(move.segment_ticks, rested.acceleration_ticks)

    @property
    def begins(self) -> Joints:
        """Angles the path begins with, rad: ``start``, but for what the wrist leaves open."""
        straight = self.segment.drive is not None and self._path is not None
        return self._path.first if straight and self._path else self.start

    @property
    def theta_BC(self) -> Joints:
        """(3.11), rad; zeros in Cartesian mode."""
        if self._theta_BC is None:
            return (0.0,) * 6
        j1, j2, j3, j4, j5, j6 = self._theta_BC.tolist()
        return (j1, j2, j3, j4, j5, j6)

    @property
    def degree(self) -> int:
        """How finely the path must be looked at: half as many intervals as that takes."""
        return self._fineness(self._path, self.segment.move.segment_ticks)

    @property
    def entry_degree(self) -> int:
        """The same of the transition into it."""
        entry = self._path if self._entry is None else self._entry
        return self._fineness(entry, 2 * self.segment.move.acceleration_ticks)

    @property
    def rest_degree(self) -> int:
        """The same of the goal in the transition to rest."""
        return self._fineness(self._rest, 2 * self.segment.move.rest_ticks)

    @property
    def whole(self) -> bool:
        """Whether each of its curves is one polynomial: none bends sharply."""
        curves = (self._entry, self._path, self._rest)
        return all(curve is None or curve.whole for curve in curves)

    @staticmethod
    def _fineness(curve: Curve | None, ticks: int) -> int:
        """The degree of a curve, and of one in pieces the periods of its time."""
        if curve is None:
            return 1
        return curve.degree if curve.whole else max(curve.degree, ticks)

    def derivatives(self, times: Floats) -> Floats:
        """Base and three time derivatives at local ``times``, s, all of the transition into the
        segment or all after it; shape (4, n, 6)."""
        h = self.parameter(times)
        if self.segment.move.target.constant:
            return self.along(h)
        curve = self._entry if times[-1] <= self.acceleration_time else self._path
        if curve is None:
            raise AssertionError("a goal that moves has curves of time")
        angles = curve.derivatives(times, self._frame.period_s)
        if self._theta_BC is not None:
            angles = angles + remaining(h) * self._theta_BC
        return angles

    def along(self, h: Floats) -> Floats:
        """The same of a path where nothing moves by itself, from h and its derivatives (4, n)."""
        if self._path is not None:
            return chained(self._path.derivatives(h[0], h[1] * self._frame.period_s), h)
        angles = remaining(h) * (np.zeros(6) if self._theta_BC is None else self._theta_BC)
        angles[0] += self.goal
        return np.asarray(angles)

    def at_rest(self, times: Floats) -> Floats:
        """The goal and its time derivatives in the transition to rest; shape (4, n, 6)."""
        if self._rest is not None:
            return self._rest.derivatives(times, self._frame.period_s)
        angles = np.zeros((4, len(times), 6))
        angles[0] = self.goal
        return angles

    @property
    def acceleration_time(self) -> float:
        """t_acc, s."""
        return self.segment.move.acceleration_ticks * self._frame.period_s

    @property
    def rest_time(self) -> float:
        """t_acc of the transition to rest, s."""
        return self.segment.move.rest_ticks * self._frame.period_s

    @property
    def segment_time(self) -> float:
        """t_seg, s."""
        return self.segment.move.segment_ticks * self._frame.period_s

    def parameter(self, times: Floats) -> Floats:
        """h and its time derivatives (3.15, 3.16); shape (4, n)."""
        t_acc, t_seg = self.acceleration_time, self.segment_time
        p = np.clip((times + t_acc) / (2.0 * t_acc), 0.0, 1.0)
        h = blend_derivatives(p, t_acc) * (t_acc / t_seg)
        late = times > t_acc
        h[0, late] = times[late] / t_seg
        return h

    def solve(self, h: float, t: float, previous: Joints, theta4: float | None = None) -> Joints:
        """Angles of T6_1 at h and t, rad; ``theta4`` where the pose leaves it open.

        They are those nearest to ``previous``; in joint mode to the ones the goal is given by.

        Raises:
            KinematicsError: they do not exist.
        """
        frame, segment = self._frame, self.segment
        pose = segment.pose(Moment(frame.tick, h, t), 1.0 - h)
        if self._given is not None:
            previous, theta4 = self._given, self._given[3]
        try:
            angles = frame.kinematics.solve(pose, segment.move.configuration, previous, theta4)
            return angles if self._given is None else _as_given(angles, self._given)
        except KinematicsError as error:
            straight = segment.drive is not None and h < 1.0
            where = f"the path at h = {h:.3f}" if straight else "the goal"
            raise type(error)(f"move {segment.move.sequence}: {where}: {error}") from error

    def _look_ahead(self, beginning: float) -> None:
        """See that the joints can watch where the segment begins, before it does.

        Raises:
            KinematicsError: it has no solution meanwhile.
        """
        watched = window_for(self.segment.move.acceleration_ticks) * self._frame.period_s
        for part in WATCHED:
            self.solve(0.0, beginning - part * watched, self.start)

    def _along(self, h: float, previous: Joints) -> Joints:
        theta4 = None if 0.0 < h < 1.0 else self._limit_of_theta4(h, previous)
        return self.solve(h, 0.0, previous, theta4)

    def _limit_of_theta4(self, end: float, previous: Joints) -> float | None:
        """What theta4 tends to at an end of a straight path, if it is open there, rad."""
        if not self._wrist_sine(end) < WRIST_BOUND:
            return None
        for near in NEXT_TO:
            if self._wrist_sine(abs(end - near)) > TOLD:
                by, further, furthest = (
                    self.solve(abs(end - k * near), 0.0, previous)[3] for k in (1.0, 2.0, 3.0)
                )
                last = math.remainder(by - further, math.tau)
                return by + 2.0 * last - math.remainder(further - furthest, math.tau)
        return previous[3]  # straight all the way

    def _wrist_sine(self, h: float) -> float:
        """|S5| at h of a straight path."""
        frame, segment = self._frame, self.segment
        pose = segment.pose(Moment(frame.tick, h, 0.0), 1.0 - h)
        return frame.kinematics.wrist_sine(pose, segment.move.configuration)

    def _blending(self, t: float, previous: Joints) -> Joints:
        return self.solve(float(self.parameter(np.array([t]))[0, 0]), t, previous)

    def _even(self, t: float, previous: Joints) -> Joints:
        return self.solve(t / self.segment_time, t, previous)

    def _at_goal(self, t: float, previous: Joints) -> Joints:
        return self.solve(1.0, t, previous)

    def _refuse_leaps(self) -> None:
        cartesian = self.segment.move.transition is Transition.CARTESIAN
        for curve in (None if cartesian else self._entry, self._path, self._rest):
            if curve is not None and not curve.resolved:
                self._refuse_leap(curve)

    def _refuse_leap(self, curve: Curve) -> None:
        joint = int(curve.largest_step.argmax())
        if curve.largest_step[joint] > LEAP:
            arm = self._frame.kinematics.arm
            near = nearest_singularity(arm, curve.steepest)
            where = near.text if near.is_near else "the end of its range"
            raise MoveError(
                f"move {self.segment.move.sequence}: joint {joint + 1} of {arm.name} would have to "
                f"turn {curve.largest_step[joint]:.3g} rad at once, where the path passes {where}"
            )


def _as_given(angles: Joints, given: Joints) -> Joints:
    """Angles that a goal is given by, where its pose says no more than rounding against them.

    At an end of a range it would make another turn of it.
    """
    same = all(
        abs(math.remainder(a - b, math.tau)) < ROUNDING for a, b in zip(angles, given, strict=True)
    )
    return given if same else angles


def blend_derivatives(p: Floats, t_acc: float) -> Floats:
    """h t_seg / t_acc of (3.15) and its time derivatives; shape (4, n)."""
    span = 2.0 * t_acc
    return np.stack(
        (
            ((2.0 * p - 6.0) * p + 5.0) * p**4,
            ((12.0 * p - 30.0) * p + 20.0) * p**3 / span,
            ((60.0 * p - 120.0) * p + 60.0) * p**2 / span**2,
            ((240.0 * p - 360.0) * p + 120.0) * p / span**3,
        )
    )


def chained(by_h: Floats, h: Floats) -> Floats:
    """Time derivatives (4, n, 6) of what has the derivatives ``by_h`` by h, itself (4, n)."""
    f, f1, f2, f3 = by_h
    h1, h2, h3 = (order[:, None] for order in h[1:])
    return np.stack((f, f1 * h1, f2 * h1**2 + f1 * h2, f3 * h1**3 + 3.0 * f2 * h1 * h2 + f1 * h3))


def remaining(h: Floats) -> Floats:
    """r = 1 - h and its derivatives, for a product with angles; shape (4, n, 1)."""
    r = -h
    r[0] += 1.0
    return np.asarray(r[:, :, None])

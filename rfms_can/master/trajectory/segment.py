"""Moves as they are requested, and the segments the arm then runs."""

import math
from enum import Enum, auto
from typing import Final, NamedTuple, Self

from rfms_can.errors import MoveError
from rfms_can.kinematics import Configuration, Joints
from rfms_can.master.trajectory.goal import FixedGoal, Goal, Moment
from rfms_can.master.trajectory.joint_line import JointLine, PlannedJoints
from rfms_can.transform import DriveTransform, Transform
from rfms_can.wire.vocabulary import Mode


class Transition(Enum):
    """How a segment is entered."""

    JOINT = auto()
    """Each joint blends on its own (3.18): cheap, and off the path in space."""
    CARTESIAN = auto()
    """T6 blends (:mod:`rfms_can.master.trajectory.correction`), and comes to rest on the line.

    Into a joint-mode segment from rest, and from one to rest, the joints blend: that is its line.
    """


TOLD_TICKS: Final = 3
"""Cycles in which the joints are told p = 1 after they are told a joint-mode segment that a
Cartesian transition has led into. Should START be lost, they stop for want of a set-point before
one comes that they would misread."""


class Move(NamedTuple):
    """A request to move, or a part of one: where to, how, and how fast.

    Attributes:
        sequence: the request's number, growing from 1.
        target: where to.
        mode: straight in joint angles or in space.
        segment_ticks: t_seg in periods, from the goal before to this one.
        acceleration_ticks: t_acc in periods: the transition into this segment takes twice that.
        configuration: the branch of the inverse solution at the target.
        transition: into this segment, and at its end to rest.
        last: False for all parts of a move but its last; the parts share its number.
        start_angles: joint angles its path in space begins with, rad; None in joint mode, and where
            the path moves by itself.
        goal_angles: at its goal, rad; of a goal that moves by itself where a move in joint mode
            begins, else None. Both tell turns, and theta4 of a straight wrist.
        rest_acceleration_ticks: t_acc of the transition to rest, if another than
            ``acceleration_ticks``: that of a corner follows from the deviation allowed there.
        joints: what was planned of a joint-mode move; a Cartesian transition from or into it needs
            to know.
    """

    sequence: int
    target: Goal
    mode: Mode
    segment_ticks: int
    acceleration_ticks: int
    configuration: Configuration
    transition: Transition = Transition.JOINT
    last: bool = True
    start_angles: Joints | None = None
    goal_angles: Joints | None = None
    rest_acceleration_ticks: int | None = None
    joints: PlannedJoints | None = None

    @property
    def rest_ticks(self) -> int:
        """t_acc of a transition to rest at the goal, and of a stop or a pause on the way there."""
        ticks = self.rest_acceleration_ticks
        return self.acceleration_ticks if ticks is None else ticks

    @property
    def longest_entry(self) -> int:
        """t_acc it may be entered with: should it depart from rest after all, ``rest_ticks``."""
        return max(self.acceleration_ticks, self.rest_ticks)

    @property
    def told_ticks(self) -> int:
        """Time the joints are told its line in, after a Cartesian transition into joint mode."""
        return TOLD_TICKS + 1 if self.rejoins else 0

    @property
    def least_ticks(self) -> int:
        """Least segment time that has room for its transitions, in and to rest, periods."""
        return self.segment_ticks - self.room + self.rest_ticks

    @property
    def room(self) -> int:
        """Longest t_acc the move that follows may have, periods."""
        entry = max(self.acceleration_ticks + self.told_ticks, self.rest_ticks)
        return self.segment_ticks - entry - 2

    @property
    def rejoins(self) -> bool:
        """Whether a Cartesian transition leads into joint mode."""
        return self.mode is Mode.JOINT and self.transition is Transition.CARTESIAN

    def from_rest(self) -> Self:
        """As it departs from rest, where no position is passed."""
        transition = Transition.JOINT if self.mode is Mode.JOINT else self.transition
        return self._replace(acceleration_ticks=self.rest_ticks, transition=transition)

    def to_rest(self) -> Self:
        """The transition to rest at its goal, as a move: t_seg = t_acc.

        There is nothing left to drive through: in joint mode, or in a Cartesian transition if a
        Cartesian segment began with one.
        """
        ticks = self.rest_ticks
        joint = self.mode is Mode.JOINT or self.transition is Transition.JOINT
        return self._replace(
            mode=Mode.JOINT if joint else Mode.CARTESIAN,
            transition=Transition.JOINT if joint else Transition.CARTESIAN,
            segment_ticks=ticks,
            acceleration_ticks=ticks,
            rest_acceleration_ticks=None,
        )


class Segment(NamedTuple):
    """A move under way, or a stay: where T6 is at any r.

    Attributes:
        move: as requested.
        drive: D, in Cartesian mode.
        rests: whether this is the transition that ends at its own goal, t_seg = t_acc.
        line: in joint mode, where it matters: from and into Cartesian transitions.
    """

    move: Move
    drive: DriveTransform | None = None
    rests: bool = False
    line: JointLine | None = None

    @classmethod
    def towards(cls, move: Move, origin: Transform, moment: Moment) -> Self:
        """The segment of ``move`` from the pose ``origin`` = B, its D(1) solved now (3.22)."""
        if move.mode is Mode.JOINT:
            return cls(move)
        goal = move.target
        return cls(move, DriveTransform.between(goal.left(moment), origin, goal.right(moment)))

    @classmethod
    def hold(
        cls, pose: Transform, configuration: Configuration, angles: Joints | None = None
    ) -> Self:
        """At rest at ``pose``, with joint ``angles`` (rad) if they are known."""
        move = Move(0, FixedGoal(pose), Mode.JOINT, 1, 1, configuration, goal_angles=angles)
        return cls(move, rests=True)

    def to_rest(self) -> Self:
        """The transition to rest at this segment's goal: to the same target, t_seg = t_acc."""
        return self._replace(move=self.move.to_rest(), drive=None, rests=True, line=None)

    @property
    def angles(self) -> Joints | None:
        """Of T6_1, rad, where the plan knows them: at a fixed goal."""
        fixed = self.drive is None and self.move.target.constant
        return self.move.goal_angles if fixed else None

    @property
    def first_angles(self) -> Joints | None:
        """The same of the T6_1 that the segment begins with, also where that moves."""
        return self.move.goal_angles if self.drive is None else self.move.start_angles

    def pose(self, moment: Moment, r: float) -> Transform:
        """T6_1: in joint mode the goal, in Cartesian mode L D(r) R."""
        goal = self.move.target
        if self.drive is None:
            return goal.pose(moment)
        return goal.left(moment) @ self.drive.at(r) @ goal.right(moment)

    def hand(self, moment: Moment, r: float) -> Transform:
        """T6 itself: in joint mode that of the joints' angles, by direct kinematics.

        Raises:
            KinematicsError: the goal of a joint-mode segment has no solution.
        """
        if self.line is None:
            return self.pose(moment, r)
        goal = self.move.target
        return self.line.pose(None if goal.constant else goal.pose(moment), r)

    def driven(self, moment: Moment, r: float) -> Transform:
        """T6 in the frame of the goal's drive: L^-1 T6 R^-1, which is D(r) in Cartesian mode.

        Raises:
            KinematicsError: as of ``hand``.
        """
        if self.line is None:
            return Transform.identity() if self.drive is None else self.drive.at(r)
        goal = self.move.target
        return goal.left(moment).inverse() @ self.hand(moment, r) @ goal.right(moment).inverse()


class Rest(NamedTuple):
    """The rest of the arm that a move is to end.

    Attributes:
        clock: local time its goal is told in the last cycle, or when the arm will have come to
            rest, periods.
        seen: periods for which the joints have seen by then how the goal moves.
    """

    clock: float
    seen: int = 0

    @classmethod
    def after(cls, segment: Segment) -> Self:
        """That at the goal of ``segment``, as soon as the arm is there."""
        return cls(segment.move.segment_ticks + segment.move.rest_ticks)


class Entry(NamedTuple):
    """What a move that is to be planned enters from.

    Attributes:
        before: the segment it is to follow; it ``rests`` where that leaves all the time there is.
        tick: of the trajectory generator, at which goals that are observed are looked at.
        left: periods until the goal of ``before``, if it is under way.
        rest: that the move ends, if ``before`` rests.
        feed_rate: asked for.
    """

    before: Segment
    tick: int = 0
    left: float = math.inf
    rest: Rest = Rest(0.0)
    feed_rate: float = 1.0

    def after_rest(self, clock: float) -> Self:
        """The same once the arm rests at that goal, told the local time ``clock``, periods."""
        return self._replace(before=self.before.to_rest(), left=math.inf, rest=Rest(clock))


def whole_ticks(duration_s: float, period_s: float) -> int:
    """``duration_s`` in periods, rounded to the nearest.

    Raises:
        MoveError: not a finite number, or shorter than half a period.
    """
    if not 0.0 < duration_s < 1e9:  # also NaN
        raise MoveError(f"a time of {duration_s} s is not a duration: give seconds, more than zero")
    ticks = round(duration_s / period_s)
    if ticks < 1:
        raise MoveError(
            f"a time of {duration_s:g} s is under half a period of {period_s:g} s: "
            f"give at least {period_s:g} s"
        )
    return ticks

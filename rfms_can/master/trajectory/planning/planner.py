"""The planner: what a request to move becomes, or why it is refused."""

import math
from collections.abc import Mapping
from typing import Any, Final, NamedTuple, Protocol

import numpy as np

from rfms_can.errors import KinematicsError, MoveError
from rfms_can.kinematics import WRIST_BOUND, Configuration, InverseKinematics, Joints
from rfms_can.master.trajectory.admission import (
    MAX_ROTATION,
    check_configuration,
    check_feed,
    check_succession,
    from_goal_to_goal,
)
from rfms_can.master.trajectory.goal import Goal, joint_coordinates
from rfms_can.master.trajectory.joint_line import JointLine, PlannedJoints
from rfms_can.master.trajectory.planning.alternatives import ChangedMode, alternatives
from rfms_can.master.trajectory.planning.base_path import Base, Frame
from rfms_can.master.trajectory.planning.corner import Corner, longest, via_deviation
from rfms_can.master.trajectory.planning.curve import Floats
from rfms_can.master.trajectory.planning.departure import DepartedSegment, Leave
from rfms_can.master.trajectory.planning.effort import (
    Effort,
    MeteredKinematics,
    TooLongError,
)
from rfms_can.master.trajectory.planning.joint_goal import check_reached, configuration_for
from rfms_can.master.trajectory.planning.large_rotation import in_parts
from rfms_can.master.trajectory.planning.limits import LimitedArm, peaks
from rfms_can.master.trajectory.planning.refusal import Attempt, refusal
from rfms_can.master.trajectory.planning.remedy import RefusedError, Remedy, mended, told
from rfms_can.master.trajectory.planning.search import Outcome, Trial
from rfms_can.master.trajectory.planning.straight_wrist import straightened
from rfms_can.master.trajectory.planning.times import (
    PlannedMode,
    least_ticks,
    segment_ticks,
)
from rfms_can.master.trajectory.segment import (
    Entry,
    Move,
    Rest,
    Segment,
    Transition,
    whole_ticks,
)
from rfms_can.transform import DriveTransform
from rfms_can.wire.vocabulary import Mode

REMEMBERED: Final = 300
"""Moves whose angles are kept: more than may wait."""


PHASES: Final = 8
"""Moments of its cycle at which a move may leave a goal that goes on, after a wait."""

BETWEEN: Final = 1.05
"""How much more time it may take between them."""


class PlannedPosition(Protocol):
    """Where a move is to go: what planning asks of a position."""

    @property
    def name(self) -> str:
        """In the world model."""

    @property
    def goal(self) -> Goal:
        """Its equation, solved."""

    @property
    def configuration(self) -> Configuration:
        """The branch of the inverse solution."""


class Plan(NamedTuple):
    """A move that keeps all rules and limits.

    Attributes:
        moves: its parts, for the trajectory generator.
        segment_time: of all of them, s.
        via_deviation: how far the tool stays from the position before, m; None where it rests
            there.
        via_rotation: the rotation to that position where the tool is nearest, rad.
        peak_speeds, peak_accelerations: of each joint, rad/s and rad/s2: in the transition into
            the move, along it, and to rest at its goal.
    """

    moves: tuple[Move, ...]
    segment_time: float
    via_deviation: float | None
    via_rotation: float | None
    peak_speeds: Joints
    peak_accelerations: Joints


class _Planned(NamedTuple):
    """What is remembered of a move: D, theta_BC, and the angles at its goal, rad."""

    drive: DriveTransform | None
    theta_BC: Joints
    goal: Joints

    def departs_as(self, other: "_Planned") -> bool:
        """Whether both are the same to the digit."""
        mine, its = self.drive, other.drive
        drives = (None if each is None else (each.p, each.axis, each.psi) for each in (mine, its))
        return (self.theta_BC, self.goal) == (other.theta_BC, other.goal) and len({*drives}) == 1


Memory = dict[int, _Planned]
"""What is remembered of moves, by number."""


THETA4_ROUNDING: Final = 1e-6
"""Rad theta4 may be off where a Cartesian transition leaves a straight wrist."""

_ZERO: Final[Joints] = (0.0,) * 6


class MovePlanner:
    """Plans moves in the order they are requested.

    Goals that move are judged by where they are at the plan's tick, and transitions as they are
    when nothing is late: a move requested past its time to take over starts up to t_acc / 7 late,
    and its transition is steeper by up to 0.27 dv / t_acc than was planned.
    """

    def __init__(self, arm: LimitedArm, period_s: float, most: float = math.inf) -> None:
        """For an arm whose place ``reset`` tells.

        Args:
            arm: its geometry and limits.
            period_s: tau, s.
            most: poses that may be solved for one request: see ``effort``.
        """
        self.arm: Final = arm
        self._period: Final = period_s
        self.effort: Final = Effort(most)
        self._kinematics: Final = MeteredKinematics(arm, self.effort)
        self._while_moving: Final = InverseKinematics(arm)
        self._planned: Final[dict[int, _Planned]] = {}

    def reset(self, q: Joints) -> None:
        """The arm rests at the angles ``q``, rad, before the first move or after a stop."""
        self._remember(0, _Planned(None, _ZERO, q))

    @property
    def memory(self) -> "Memory":
        """What is remembered of the moves planned so far, to ``recall`` it."""
        return dict(self._planned)

    def recall(self, memory: "Memory") -> None:
        """Remember what was remembered, and nothing that was planned since."""
        self._planned.clear()
        self._planned.update(memory)

    def as_in(self, memory: "Memory", sequence: int) -> bool:
        """Whether what follows a move cannot tell its plan from the one in ``memory``."""
        before, now = memory.get(sequence), self._planned[sequence]
        return before is not None and before.departs_as(now)

    def plan(
        self,
        entry: Entry,
        position: PlannedPosition,
        mode: PlannedMode,
        sequence: int,
    ) -> Plan:
        """What a request to move becomes.

        Args:
            entry: what it is to follow: ``TrajectoryGenerator.entry``.
            position, mode: where to, and how.
            sequence: its number.

        Raises:
            MoveError: a rule or a limit is broken; message and ``remedy`` have what would do.
            KinematicsError: the goal, or a pose on the way there, has no solution.
        """
        try:
            return self._made(*self._attempt(entry, position, mode, sequence))
        except (MoveError, KinematicsError) as error:
            others = alternatives(entry.before, mode, self._period)
            attempt = self._otherwise(entry, position, mode, sequence)
            raise refusal(error, others, attempt, self.effort) from error

    def _otherwise(
        self, entry: Entry, position: PlannedPosition, mode: PlannedMode, sequence: int
    ) -> Attempt:
        """What plans the same with a change of the mode, as ``plan`` would."""

        def attempt(change: Mapping[str, Any]) -> None:
            changed = ChangedMode.of(mode, change)
            if "wait" not in change:
                self._attempt(entry, position, changed, sequence)
                return
            waited, cycle = Rest.after(entry.before).clock, entry.before.move.target.cycle_s
            if cycle and changed.segment_time is not None:
                changed = changed._replace(segment_time=changed.segment_time / BETWEEN)
            for k in range(PHASES if cycle else 1):
                rested = entry.after_rest(waited + k * cycle / PHASES / self._period)
                self._attempt(rested, position, changed, sequence)

        return attempt

    def _attempt(
        self, entry: Entry, position: PlannedPosition, mode: PlannedMode, sequence: int
    ) -> tuple[Trial, Outcome]:
        """``plan``, without remembering anything of it."""
        trial = self.trial(entry, position, mode, sequence)
        outcome = self._outcome(trial, mode, entry)
        check_feed(outcome.base.segment.move, entry.feed_rate, self._period)
        return trial, outcome

    def _outcome(self, trial: Trial, mode: PlannedMode, entry: Entry) -> Outcome:
        """What a trial comes to within all limits, with the times that its mode lets it have."""
        before, move = entry.before, trial.base.segment.move
        if mode.deviation is not None and not before.rests:
            corner = Corner(trial, mode.deviation, longest(before.move, move, entry.left))
            return corner.outcome(mode.lengthen_at_most if mode.lengthen else 1.0)
        if not before.rests:
            check_succession(before.move, move, self._period)
        outcome = trial.run(trial.times)
        excess, lengthen, at_most = outcome.excess, mode.lengthen, mode.lengthen_at_most
        if excess is None:
            return outcome
        try:
            return mended(trial, excess, lengthen=lengthen, at_most=at_most)
        except TooLongError as error:
            raise RefusedError(f"move {move.sequence}: {excess.what}") from error

    def trial(
        self,
        entry: Entry,
        position: PlannedPosition,
        mode: PlannedMode,
        sequence: int,
        acceleration_ticks: int | None = None,
    ) -> Trial:
        """A move as its mode has it, before limits are looked at; arguments as of ``plan``.

        Args:
            acceleration_ticks: t_acc, periods, if another than the mode's.

        Raises:
            MoveError: a rule is broken.
            KinematicsError: the goal, or a pose on the way there, has no solution.
        """
        before, frame = entry.before, Frame(self._kinematics, entry.tick, self._period)
        own = whole_ticks(mode.acceleration_time, self._period)
        acceleration = acceleration_ticks or own
        configuration = _configuration(position, mode, before, sequence)
        move = Move(
            *(sequence, position.goal, mode.mode, least_ticks(acceleration), acceleration),
            *(configuration, mode.transition),
            rest_acceleration_ticks=None if mode.deviation is None else own,
        )
        if before.rests:
            move = move.from_rest()
        leave = Leave.of(before, entry.rest, move)
        departed = self._departed(before, frame, leave, entry.rest)
        goal = straightened(self._kinematics, position.goal, configuration, departed.goal)
        move = move._replace(target=goal)
        check_configuration(before.move, move)
        drive = from_goal_to_goal(before.move, move, entry.tick, self._period, leave.settled)
        parts = 2 if mode.mode is Mode.CARTESIAN and drive.psi > MAX_ROTATION else 1
        base = self._timed(frame, departed, move, drive, parts, mode)
        check_reached(base)
        if mode.transition is Transition.CARTESIAN and before.rests:
            _check_theta4(base, sequence)
        ends = move.to_rest().transition if parts == 1 else Transition.CARTESIAN

        def again(ticks: int) -> Trial:
            return self.trial(entry, position, mode, sequence, ticks)

        moves = not before.move.target.constant
        return Trial(
            *(self.arm, frame, departed, base, ends, parts, self.effort),
            again if moves else None,
        )

    def _departed(self, before: Segment, frame: Frame, leave: Leave, rest: Rest) -> DepartedSegment:
        """The segment to follow, with what was planned of it."""
        move = before.move
        planned = self._planned.get(move.sequence)
        if planned is None:
            raise AssertionError(f"move {move.sequence} was not planned: reset says where it rests")
        goal = planned.goal
        if not move.target.constant:
            pose = move.target.pose(frame.at(1.0, leave.left))
            goal = frame.kinematics.solve(pose, move.configuration, goal)
        if move.mode is Mode.CARTESIAN and before.drive is None and not before.rests:
            before = before._replace(drive=planned.drive)
        if move.mode is Mode.JOINT and not before.rests:
            line = JointLine(self._kinematics, planned.theta_BC, goal, move.configuration)
            before = before._replace(line=line)
        return DepartedSegment(before, planned.theta_BC, goal, rest)

    def _timed(
        self,
        frame: Frame,
        departed: DepartedSegment,
        move: Move,
        drive: DriveTransform,
        parts: int,
        mode: PlannedMode,
    ) -> Base:
        """The segment of ``move`` with the time its mode gives it or asks for."""
        limits, tau = self.arm.speed_limits, self._period
        free = mode.deviation is not None  # to choose the t_acc of its entry, however short
        least = parts * (move._replace(acceleration_ticks=1) if free else move).least_ticks
        ticks = segment_ticks(mode, drive, _ZERO, limits, tau)
        if ticks < least and mode.segment_time is not None and not mode.lengthen:
            raise _too_short(move._replace(segment_ticks=ticks), least, drive.psi, parts, tau)
        if mode.segment_time is not None and least > mode.lengthen_at_most * ticks:
            raise RefusedError(
                f"move {move.sequence}: its transitions alone take {least * tau:.6g} s instead of "
                f"{ticks * tau:.6g} s, and the mode lengthens {mode.lengthen_at_most:g} times at "
                f"most",
                Remedy("ask for that time", {"segment_time": told(least * tau)}),
            )
        move = move._replace(segment_ticks=max(ticks, least))
        segment = Segment(move, drive if move.mode is Mode.CARTESIAN else None)
        base = Base(frame, segment, departed.goal)
        if mode.joint_speed is not None:
            turns = np.subtract(base.goal, base.start).tolist()
            ticks = max(segment_ticks(mode, drive, turns, limits, tau), least)
            if ticks != move.segment_ticks:
                base = base.with_time(ticks, move.acceleration_ticks)
        return base

    def _made(self, trial: Trial, outcome: Outcome) -> Plan:
        """The plan, and what the next one needs to know of it."""
        base, departed = outcome.base, trial.departed
        move, drive, tau = base.segment.move, base.segment.drive, self._period
        if move.mode is Mode.JOINT:
            move = move._replace(joints=PlannedJoints(self._while_moving, base.start, base.goal))
        moves: tuple[Move, ...] = (move,)
        if drive is not None and trial.parts > 1:
            moves = in_parts(move, drive, tau)
            drive = from_goal_to_goal(moves[0], moves[1], trial.frame.tick, tau)
        off = None
        if not departed.segment.rests:
            off = via_deviation(trial, outcome.preview.entry.motion[0])
        self._remember(move.sequence, _Planned(drive, base.theta_BC, base.goal))
        speeds, accelerations = (_joints(values) for values in peaks(outcome.preview[:3]))
        return Plan(
            moves,
            base.segment_time,
            None if off is None else off.distance,
            None if off is None else off.rotation,
            speeds,
            accelerations,
        )

    def _remember(self, sequence: int, planned: _Planned) -> None:
        """Keep what was planned as the newest; the oldest may be forgotten."""
        self._planned.pop(sequence, None)
        self._planned[sequence] = planned
        if len(self._planned) > REMEMBERED:
            del self._planned[next(iter(self._planned))]


def _configuration(
    position: PlannedPosition, mode: PlannedMode, before: Segment, sequence: int
) -> Configuration:
    """The branch the goal is solved in: the mode's, or the position's.

    Raises:
        MoveError: the position is given by joint angles, and the mode asks for another branch.
    """
    angles = joint_coordinates(position.goal)
    own, asked = position.configuration, mode.configuration
    if angles is None:
        return asked or own
    return configuration_for(angles, own, asked, before.move.configuration, sequence)


def _too_short(move: Move, least: int, psi: float, parts: int, tau: float) -> RefusedError:
    """The refusal of a segment time that the transitions of the parts do not fit in.

    Args:
        move: with that time.
        least: time that they fit in, periods.
        psi: rotation of the move, rad.
        parts: in how many it is moved.
        tau: period, s.
    """
    ends = ("twice", "two", "the arm could not stop at the goal")
    if parts > 1:
        ends = ("four times", "four", f"a rotation of {psi:.4g} rad is moved in two parts")
    times, periods, why = ends
    offers = [Remedy("lengthen the segment", {"segment_time": told(least * tau)})]
    fits = told((move.segment_ticks // parts - move.told_ticks - 2) // 2 * tau)
    if fits > 0.0:
        offers.append(Remedy(f"accelerate in {fits:g} s", {"acceleration_time": fits}))
    return RefusedError(
        f"move {move.sequence}: segment time {move.segment_ticks * tau:.6g} s is under {times} the "
        f"acceleration time plus {periods} periods, {least * tau:.6g} s: {why}",
        *offers,
    )


def _check_theta4(base: Base, sequence: int) -> None:
    """A Cartesian transition out of a straight wrist finds theta4 where the path needs it.

    Raises:
        MoveError: it does not; the joints would have to turn while the hand stands still.
    """
    stands, needed = base.start[3], base.begins[3]
    straight = abs(math.sin(base.start[4])) < WRIST_BOUND
    fixed = base.segment.move.target.constant
    if fixed and straight and abs(needed - stands) > THETA4_ROUNDING:
        raise MoveError(
            f"move {sequence}: the path leaves a straight wrist with theta4 = {needed:.6g} rad, "
            f"and the arm holds it at {stands:.6g} rad: a Cartesian transition cannot turn it"
        )


def _joints(values: Floats) -> Joints:
    j1, j2, j3, j4, j5, j6 = values.tolist()
    return (j1, j2, j3, j4, j5, j6)

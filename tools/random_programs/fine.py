"""Whether a refusal was due: the refused move is made all the same, looked at very closely.

The trajectory generator and six joints run it in periods that are ``FINER`` times as short, so that
a move is sampled a hundred times as finely as the planner samples it, and every pose is solved
instead of interpolated. A refusal is due where a pose has no solution, a joint leaves its range, or
passes its speed or acceleration limit; with the time that was asked for, and with the longest one
that the mode allows.
"""

from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np

from rfms_can.arm import Arm
from rfms_can.errors import KinematicsError, RfmsError
from rfms_can.kinematics import InverseKinematics, Joints, configuration_of, direct
from rfms_can.master.trajectory.generator import TrajectoryGenerator
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.trajectory.planning import MovePlanner, PlannedPosition
from rfms_can.master.trajectory.planning.large_rotation import in_parts
from rfms_can.master.trajectory.planning.search import Trial
from rfms_can.master.trajectory.segment import Entry, Move
from rfms_can.master.world.modes import MotionMode
from rfms_can.setpoint import CartesianSetpoint, JointSetpoint
from rfms_can.transform import DriveTransform
from rfms_can.wire.vocabulary import Blend, Mode

FINER: Final = 25
"""Periods in one of the control's: a move of a second is looked at 6,250 times."""
LONGEST: Final = 400_000
"""Periods until a move counts as one that never ends."""
ROUNDING: Final = 1e-3
"""Part of a limit that a motion may stay under it and still count as passing it."""
POSES: Final = 6400
"""Poses of a path that are solved where it cannot be planned: a hundred times the planner's."""
LEAP: Final = 0.3
"""Rad from one of them to the next that no motion can make."""
PARK: Final[Joints] = (0.0,) * 6
END: Final = 1e-9
"""Rad a joint may be past the end of its range."""
RULES: Final = (
    "is under twice the acceleration time",
    "is under four times the acceleration time",
    "is too long to leave move",
    "cannot change the configuration",
    "a Cartesian transition cannot turn it",
    "its transitions alone take",
    "is asked for: the path tells theta4 where it ends in a straight wrist",
    "is asked for: a line stays on the turns it begins on",
    "its mode asks for the configuration",
    "over 100 s",
)
"""Refusals by a rule, which their own numbers show."""


class Case(NamedTuple):
    """A refusal.

    Attributes:
        words: of it.
        entry: what the move was to follow.
        position, mode: where to, and how.
    """

    words: str
    entry: Entry
    position: PlannedPosition
    mode: MotionMode


class _Exact:
    """Six joints in double precision, without limits of speed and acceleration."""

    def __init__(self, arm: Arm, period_s: float, q: Joints) -> None:
        self._solve = InverseKinematics(arm).solve
        self._ranges = [(lower - END, upper + END) for lower, upper in arm.joint_limits]
        self.joints = [JointSetpoint(period_s, angle) for angle in q]

    def take(self, setpoint: CartesianSetpoint) -> str | None:
        """Run the joints through a set-point; why they cannot, in words, or None."""
        joints = self.joints
        near_1 = setpoint.near_1 or [joint.turn_1(setpoint) for joint in joints]
        try:
            first = second = self._solve(
                setpoint.T6_1, setpoint.configuration_1, near_1, _theta4(setpoint.near_1)
            )
            if setpoint.T6_2 is not None:
                near_2 = setpoint.near_2 or [joint.turn_2 for joint in joints]
                second = self._solve(
                    setpoint.T6_2, setpoint.configuration_2, near_2, _theta4(setpoint.near_2)
                )
        except KinematicsError as error:
            return str(error)
        for k, (joint, (lower, upper)) in enumerate(zip(joints, self._ranges, strict=True)):
            angle = joint.advance(setpoint, first[k], second[k])
            if not lower <= angle <= upper:
                return f"joint {k + 1} at {angle:.6g} rad"
        return None


def _theta4(near: Joints | None) -> float | None:
    return None if near is None else near[3]


def evidence(arm: Arm, planner: MovePlanner, case: Case, period_s: float) -> str | None:
    """Why a refusal was due, in words; None if it was not.

    Args:
        arm: the arm.
        planner: that refused, as it was.
        case: the refusal.
        period_s: tau, s.
    """
    for rule in RULES:
        if rule in case.words:
            return f"a rule: {rule}"
    number = case.entry.before.move.sequence + 1
    try:
        trial = planner.trial(case.entry, case.position, case.mode, number)
    except RfmsError:
        return _no_path(arm, case, period_s)
    factors = [1.0]
    if case.mode.lengthen or "no segment time helps" in case.words:
        factors += [2.0, case.mode.lengthen_at_most]
    found = ""
    for factor in factors:
        broken = next(_broken(arm, trial, factor, period_s / FINER), None)
        if broken is None:
            return None
        found = found or broken
    return found


def _no_path(arm: Arm, case: Case, period_s: float) -> str | None:
    """Where the path cannot be: every one of ``POSES`` poses is solved; None if all can be."""
    solve, position, mode = InverseKinematics(arm).solve, case.position, case.mode
    before, goal = case.entry.before, position.goal
    clock = case.entry.rest.clock if before.rests else before.move.segment_ticks
    origin = before.move.target.pose(Moment(case.entry.tick, 1.0, clock * period_s))
    starts = Moment(case.entry.tick, 0.0, -mode.acceleration_time)
    drive = DriveTransform.between(goal.left(starts), origin, goal.right(starts))
    previous: Joints | None = None
    for h, t in _places(case):
        moment = Moment(case.entry.tick, h, t)
        pose = goal.pose(moment)
        if mode.mode is Mode.CARTESIAN:
            pose = goal.left(moment) @ drive.at(1.0 - h) @ goal.right(moment)
        try:
            angles = solve(
                *(pose, mode.configuration or position.configuration),
                previous or before.move.goal_angles or PARK,
            )
        except KinematicsError as error:
            return f"no path at h = {h:.4f}, t = {t:.3f} s: {error}"
        leaps = np.abs(np.subtract(angles, previous or angles))
        if leaps.max() > LEAP:
            place = f"no path at h = {h:.4f}, t = {t:.3f} s"
            return f"{place}: joint {leaps.argmax() + 1} leaps {leaps.max():.3g} rad"
        previous = angles
    return None


def _places(case: Case) -> Iterator[tuple[float, float]]:
    """h and t, s, of the poses of a path: of the way, and of all that its goal does at its end."""
    mode, target = case.mode, case.position.goal
    goes = mode.segment_time or 0.0
    if not target.constant:  # as joints watch it before it takes over
        begins = 2.0 * mode.acceleration_time
        yield from ((0.0, -begins * (1.0 - k / POSES)) for k in range(POSES))
    if mode.mode is Mode.CARTESIAN or not target.constant:
        yield from ((k / POSES, k / POSES * goes) for k in range(POSES))
    for k in range(POSES if target.cycle_s else 1):
        yield 1.0, goes + k / POSES * target.cycle_s


def _broken(arm: Arm, trial: Trial, factor: float, tau: float) -> Iterator[str]:
    """What breaks, in words, as the move is made ``factor`` times as slowly, in periods ``tau``."""
    departed, move = trial.departed, trial.base.segment.move
    generator = TrajectoryGenerator(tau, Blend.CONTINUOUS)
    start = departed.goal
    moves = _parts(trial, _finer(move, factor), tau)
    if not departed.segment.rests:
        start = _start_of(trial)
        moves = (_finer(departed.segment.move, 1.0), *moves)
    generator.enable(direct(arm, start), configuration_of(arm, start), start)
    exact = _Exact(arm, tau, start)
    rested = 0
    try:
        for number in dict.fromkeys(each.sequence for each in moves):
            generator.request(*(each for each in moves if each.sequence == number))
    except RfmsError as error:
        yield f"not taken: {error}"
        return
    for _ in range(LONGEST):
        setpoint = generator.tick()
        refusal = exact.take(setpoint)
        if refusal is not None:
            yield refusal
            return
        if setpoint.sequence == move.sequence:
            yield from _passed(arm, exact, tau, setpoint.h)
        rested = rested + 1 if generator.at_rest else 0
        if rested > move.target.cycle_s / tau:  # and all that its goal does then
            return
    yield "it never ends"


def _passed(arm: Arm, exact: _Exact, tau: float, h: float) -> Iterator[str]:
    """Which limit a cycle passes, in words."""
    for what, values, limits in (
        ("rad/s", [joint.step / tau for joint in exact.joints], arm.speed_limits),
        ("rad/s2", [joint.bend / tau**2 for joint in exact.joints], arm.acceleration_limits),
    ):
        ratios = np.abs(values) / limits
        joint = int(ratios.argmax())
        if ratios[joint] > 1.0 - ROUNDING:
            yield f"joint {joint + 1} at {values[joint]:.4g} {what} at h = {h:.3f}"


def _parts(trial: Trial, move: Move, tau: float) -> tuple[Move, ...]:
    """A move of a large rotation in its parts."""
    drive = trial.base.segment.drive
    return (move,) if drive is None or trial.parts == 1 else in_parts(move, drive, tau)


def _start_of(trial: Trial) -> Joints:
    """Where the segment before began, rad."""
    frame, departed = trial.frame, trial.departed
    segment, move = departed.segment, departed.segment.move
    if move.start_angles is not None:
        return move.start_angles
    if segment.drive is not None:
        began = Moment(frame.tick, 0.0, -move.acceleration_ticks * frame.period_s)
        pose = segment.pose(began, 1.0)
        return frame.kinematics.solve(pose, move.configuration, departed.goal)
    q1, q2, q3, q4, q5, q6 = (a + b for a, b in zip(departed.goal, departed.theta_BC, strict=True))
    return (q1, q2, q3, q4, q5, q6)


def _finer(move: Move, factor: float) -> Move:
    """The same move in shorter periods."""
    rest = move.rest_acceleration_ticks
    return move._replace(
        segment_ticks=round(move.segment_ticks * FINER * factor),
        acceleration_ticks=move.acceleration_ticks * FINER,
        rest_acceleration_ticks=None if rest is None else rest * FINER,
    )

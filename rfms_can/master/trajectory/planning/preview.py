"""What the joints will do in a planned move: the transition into it, its course, and to rest.

To rest it may always come. The transitions are made as :mod:`rfms_can.setpoint.joint` and
:mod:`rfms_can.master.trajectory.correction` make them (the continuous blend), from derivatives of
the paths instead of samples.
"""

import math
from functools import cache
from typing import Final, NamedTuple

import numpy as np

from rfms_can.kinematics import Joints
from rfms_can.master.trajectory.correction import Leaving
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.trajectory.planning.base_path import Base, Frame, blend_derivatives
from rfms_can.master.trajectory.planning.cartesian_entry import (
    check_ends,
    departing_angles,
    lined,
)
from rfms_can.master.trajectory.planning.curve import Curve, Floats
from rfms_can.master.trajectory.planning.departure import (
    DepartedSegment,
    Leave,
    departure_at,
    estimated_departure,
    estimated_start,
)
from rfms_can.master.trajectory.planning.straight_wrist import check_held
from rfms_can.master.trajectory.segment import Rest, Transition
from rfms_can.setpoint.blend import blend_parameter
from rfms_can.setpoint.history import ACCELERATION_TICKS, JERK_TICKS

TRANSITION: Final = 32
"""Intervals a transition is looked at in, at least; even, as most peaks are at p = 1/2."""

STAY: Final = 256
"""Intervals in which all is looked at that a goal does while the arm rests there, at most."""

FINEST: Final = 8192
"""The same at most: twice the degree of a path with more in it, and next to a singularity two a
period."""

COURSE: Final = 64
"""Intervals of the rest of a segment, at least; as those of a transition where more is in it."""


class Phase(NamedTuple):
    """Part of a move, n samples of it.

    Attributes:
        where: for messages.
        even: whether its accelerations are those of the path, and not of a transition.
        motion: angles, rates, accelerations, rad and s; shape (3, n, 6).
    """

    where: str
    even: bool
    motion: Floats


class Preview(NamedTuple):
    """The phases of a move.

    Attributes:
        entry: the transition into its segment.
        course: between the transitions.
        rest: the transition to rest.
        departure: from rest where ``entry`` is not: should the move be requested too late.
        stay: at rest at a goal that goes on.
    """

    entry: Phase
    course: Phase
    rest: Phase
    departure: Phase | None
    stay: Phase | None


def preview(frame: Frame, departed: DepartedSegment, base: Base, ends: Transition) -> Preview:
    """What the joints do in the segment of ``base`` after ``departed``; ``ends`` is how it rests.

    Raises:
        KinematicsError: a pose of a Cartesian transition has no solution.
    """
    before = departed.segment
    where, departure = "on departure", None
    if not before.rests:
        where = f"in the transition from move {before.move.sequence}"
        rested = departed._replace(segment=before.to_rest(), rest=Rest.after(before))
        departing = entry_motion(frame, rested, base.from_rest())
        departure = Phase("on departure from rest", False, departing)
    return Preview(
        Phase(where, False, entry_motion(frame, departed, base)),
        Phase("on its way", True, _course(base)),
        Phase("coming to rest", False, _to_rest(frame, base, ends)),
        departure,
        _stay(frame, base),
    )


def entry_motion(frame: Frame, departed: DepartedSegment, base: Base) -> Floats:
    """Angles, rates, accelerations in the transition from ``departed``; shape (3, n, 6).

    Raises:
        KinematicsError: a pose of a Cartesian transition has no solution.
    """
    move = base.segment.move
    t_acc = base.acceleration_time
    before = departed.segment
    still = before.rests and before.move.target.constant and move.target.constant
    transition = move.from_rest().transition if before.rests else move.transition
    _, left = Leave.of(before, departed.rest, move._replace(transition=transition))
    if transition is Transition.CARTESIAN and not still:
        hand_over = 0 if before.rests else before.move.segment_ticks - move.acceleration_ticks
        leaving = Leaving(before, frame.tick, hand_over, left, 1.0, frame.period_s)
        begins_near = departing_angles(frame, departed, hand_over)
        motion = _curved(frame, leaving, hand_over, base, begins_near)
        check_ends(frame, departed, base, motion[0])
        return motion
    intervals = _intervals(base.entry_degree)
    motion = base.derivatives(t_acc * (2.0 * _p(intervals) - 1.0))
    ticks = move.acceleration_ticks
    was = departure_at(frame, departed, left)
    taken = estimated_departure(frame, departed, left, ticks)
    joined = motion[:, 0]
    if not move.target.constant:
        joined = estimated_start(frame, lambda t, q: base.solve(0.0, t, q), -t_acc, joined, ticks)
    return _blended(frame, motion, was, taken, joined, ticks)


def _course(base: Base) -> Floats:
    t_acc, t_seg = base.acceleration_time, base.segment_time
    times = np.linspace(t_acc, t_seg - base.rest_time, max(COURSE, 2 * base.degree) + 1)
    times[0] += 1e-9 * t_acc  # past the transition
    return base.derivatives(times)[:3]


def _to_rest(frame: Frame, base: Base, ends: Transition) -> Floats:
    move = base.segment.move
    t_acc, t_seg = base.rest_time, base.segment_time
    if ends is Transition.CARTESIAN:
        if move.target.constant:
            p = _p(_intervals(base.entry_degree))
            backwards = -blend_derivatives(1.0 - p, t_acc) * (t_acc / t_seg)
            backwards[0] += 1.0
            backwards[1::2] *= -1.0
            return base.along(backwards)[:3]
        hand_over = move.segment_ticks - move.rest_ticks
        leaving = Leaving(base.segment, frame.tick, hand_over, hand_over, 1.0, frame.period_s)
        return _curved(frame, leaving, hand_over, base, base.goal)
    hand_over = move.segment_ticks - move.rest_ticks
    leaves = DepartedSegment(base.segment, base.theta_BC, base.goal, Rest(0.0))
    at_end = estimated_departure(frame, leaves, hand_over, move.rest_ticks)
    intervals = _intervals(base.rest_degree)
    motion = base.at_rest(t_seg + t_acc * (2.0 * _p(intervals) - 1.0))
    was = departure_at(frame, leaves, hand_over)
    joined, ticks = motion[:, 0], move.rest_ticks
    if not move.target.constant:
        start = t_seg - t_acc
        check_held(frame, base, hand_over)
        joined = estimated_start(frame, lambda t, q: base.solve(1.0, t, q), start, joined, ticks)
    return _blended(frame, motion, was, at_end, joined, ticks)


def _stay(frame: Frame, base: Base) -> Phase | None:
    """A goal that time moves goes on when the arm is there: all of what it does, looked at as often
    as a cycle needs."""
    cycle, first = base.segment.move.target.cycle_s, base.segment_time + base.rest_time
    if not cycle:
        return None
    intervals = min(STAY, max(4, math.ceil(cycle / frame.period_s)))
    angles, previous = [], base.goal
    for k in range(intervals + 3):
        previous = base.solve(1.0, first + cycle * k / intervals, previous)
        angles.append(previous)
    step = cycle / intervals
    motion = np.zeros((3, intervals + 1, 6))
    motion[0] = angles[1:-1]
    motion[1] = (np.array(angles[2:]) - angles[:-2]) / (2.0 * step)
    motion[2] = np.diff(np.array(angles), n=2, axis=0) / step**2
    return Phase("at rest at its goal as that goes on", True, motion)


def _curved(frame: Frame, leaving: Leaving, hand_over: int, base: Base, previous: Joints) -> Floats:
    """A Cartesian transition, from ``leaving`` into ``base`` or, being of it, to rest."""
    ends = leaving.segment is base.segment
    segment = base.segment.to_rest() if ends else lined(frame, base)
    correction = leaving.into(segment, hand_over)
    solve, configuration = frame.kinematics.solve, leaving.segment.move.configuration
    t_acc = segment.move.acceleration_ticks * frame.period_s
    rise = base.acceleration_time / base.segment_time
    middle = leaving.clock * frame.period_s + t_acc if ends else 0.0

    def angles(p: float, previous: Joints) -> Joints:
        t = t_acc * (2.0 * p - 1.0)
        h = 1.0 if ends else blend_parameter(p) * rise
        moment = Moment(frame.tick, h, middle + t)
        return solve(correction.pose(segment, moment, 1.0 - h, p), configuration, previous)

    curve = Curve(angles, (0.0, 1.0), previous)
    span = 2.0 * t_acc
    intervals = _intervals(curve.degree if curve.whole else round(span / frame.period_s))
    motion = curve.derivatives(_p(intervals), frame.period_s / span)[:3]
    return np.asarray(motion * (span ** -np.arange(3.0))[:, None, None])


def _blended(
    frame: Frame, motion: Floats, was: Floats, left: Floats, joined: Floats, ticks: int
) -> Floats:
    """A transition of the joints: ``motion`` (4, n, 6), and what remains of the old one; (3, n, 6).

    Args:
        frame: of the plan.
        motion: of the base.
        was, left: what the joints did before (4, 6), and what they take it for.
        joined: what they take the new base for where it begins (4, 6).
        ticks: t_acc, periods.
    """
    tau = frame.period_s
    blended = motion[:3] + _matching(left - joined, ticks, tau, motion.shape[1] - 1)
    jump = (left - was - joined + motion[:, 0])[:2]
    jump = np.abs(jump[0]) / tau**2 + np.abs(jump[1]) / tau
    blended[2, 0] += np.copysign(jump, blended[2, 0])  # in the first cycle
    return np.asarray(blended)


def _intervals(degree: int) -> int:
    """Intervals in which a transition along a path of that degree is looked at."""
    if 2 * degree <= TRANSITION:
        return TRANSITION
    return min(FINEST, 1 << math.ceil(math.log2(2 * degree)))


@cache
def _p(intervals: int) -> Floats:
    return np.linspace(0.0, 1.0, intervals + 1)


def _matching(difference: Floats, ticks: int, tau: float, intervals: int) -> Floats:
    """What takes out ``difference`` (4, 6) within 2 t_acc (3.18), at even p; shape (3, n, 6)."""
    x, v, a, j = difference
    if ticks > JERK_TICKS:
        j = np.zeros(6)
    if ticks > ACCELERATION_TICKS:
        a = np.zeros(6)
    span = 2.0 * ticks * tau
    a1, a2, a3 = span * v, span**2 / 2.0 * a, span**3 / 6.0 * j
    q = np.stack(
        (
            x,
            a1 + 4.0 * x,
            a2 + 4.0 * a1 + 10.0 * x,
            a3 + 4.0 * a2 + 10.0 * a1 + 20.0 * x,
        )
    )
    return np.asarray((_fading(intervals) @ q) * (span ** -np.arange(3.0))[:, None, None])


@cache
def _fading(intervals: int) -> Floats:
    """(1 - p)^4 p^k for k = 0 to 3, and two derivatives; shape (3, n, 4)."""
    p = _p(intervals)
    fourth = np.polynomial.Polynomial([1.0, -4.0, 6.0, -4.0, 1.0])
    terms = [fourth * np.polynomial.Polynomial.basis(k) for k in range(4)]
    return np.array([[term.deriv(order)(p) for term in terms] for order in range(3)]).swapaxes(1, 2)

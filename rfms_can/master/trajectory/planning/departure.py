"""How the arm departs from the segment before a planned one: set-point and derivatives there."""

from collections.abc import Callable
from typing import Final, NamedTuple, Self

import numpy as np

from rfms_can.kinematics import Joints
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.trajectory.planning.base_path import Frame, remaining
from rfms_can.master.trajectory.planning.curve import Curve, Floats
from rfms_can.master.trajectory.segment import Move, Rest, Segment, Transition
from rfms_can.setpoint.blend import segment_derivatives
from rfms_can.setpoint.history import SampleHistory, least_for, window_for
from rfms_can.wire.vocabulary import Mode

PERIODS: Final = 6
"""How far back its path is looked at; also the degree of the polynomial that tells how it runs."""


class Leave(NamedTuple):
    """When a segment is left: local times of its goal, periods.

    Attributes:
        settled: D(1) of the next one is fixed.
        left: the transition begins.
    """

    settled: float
    left: float

    @classmethod
    def of(cls, before: Segment, rest: Rest, move: Move) -> Self:
        """When ``before``, or its ``rest``, is left for ``move``."""
        window, watched = window_for(move.acceleration_ticks), 1
        if move.transition is Transition.CARTESIAN:
            watched = window = 0
        elif not move.target.constant:
            watched = window - 1
        if not before.rests:
            hand_over = before.move.segment_ticks - move.acceleration_ticks
            return cls(hand_over - watched, hand_over)
        unknown = 0 if before.move.target.constant else window - rest.seen
        return cls(rest.clock + 1, rest.clock + 1 + max(watched, unknown))


class DepartedSegment(NamedTuple):
    """The segment that hands over to the planned one.

    Attributes:
        segment: if it rests, the arm departs from its goal.
        theta_BC: (3.11), rad; of no meaning in Cartesian mode.
        goal: angles at its goal when it is left, rad.
        rest: that is left if it rests.
    """

    segment: Segment
    theta_BC: Joints
    goal: Joints
    rest: Rest


def departure_at(frame: Frame, departed: DepartedSegment, ticks: float) -> Floats:
    """Its set-point at local time ``ticks`` and three derivatives by local time; shape (4, 6).

    At rest that is the local time of the goal alone.
    """
    segment, theta_BC, goal, _ = departed
    move, tau, rests = segment.move, frame.period_s, segment.rests
    derivatives = np.zeros((4, 6))
    derivatives[0] = goal
    if rests and move.target.constant:
        return derivatives
    seconds, t_seg = ticks * tau, move.segment_ticks * tau
    h = np.array([[seconds / t_seg], [1.0 / t_seg], [0.0], [0.0]])
    if move.mode is Mode.JOINT and move.target.constant:
        return np.asarray(derivatives + (remaining(h) * np.array(theta_BC))[:, 0])

    def angles(t: float, previous: Joints) -> Joints:
        part = 1.0 if rests else t / t_seg
        pose = segment.pose(Moment(frame.tick, part, t), 1.0 - part)
        return frame.kinematics.solve(pose, move.configuration, previous)

    span = (seconds - PERIODS * tau, seconds)
    curve = Curve(angles, span, goal, PERIODS, PERIODS, narrowest=1.0)
    derivatives = curve.derivatives(np.array([seconds]), tau)[:, 0]
    if move.mode is Mode.JOINT and not rests:
        derivatives = derivatives + (remaining(h) * np.array(theta_BC))[:, 0]
    return np.asarray(derivatives)


def estimated_departure(
    frame: Frame, departed: DepartedSegment, ticks: float, acceleration_ticks: int
) -> Floats:
    """The same as the joints take it: a fit to the last samples of the base; shape (4, 6).

    Where a joint runs unevenly, or t_acc is long, the fit is not the path: a jerk that is off
    counts with the third power of t_acc. With a straight part too short for ten samples these reach
    back into the transition before.

    Args:
        frame, departed, ticks: as of ``departure_at``.
        acceleration_ticks: t_acc of the transition, which decides how many samples are fitted.
    """
    segment, theta_BC, goal, _ = departed
    move, tau, rests = segment.move, frame.period_s, segment.rests
    if move.target.constant and (rests or move.mode is Mode.JOINT):
        return departure_at(frame, departed, ticks)
    window = window_for(acceleration_ticks)
    if not rests:
        least = least_for(acceleration_ticks, move.acceleration_ticks)
        window = min(window, max(int(ticks) - move.acceleration_ticks, least))
        window = min(window, int(ticks) + move.acceleration_ticks)
    samples = [goal]  # from the newest back, on the turns of the goal
    for k in range(1, window + 1):
        n = ticks - k
        h = 1.0 if rests else segment_derivatives(n, *_times(move))[0]
        pose = segment.pose(Moment(frame.tick, h, n * tau), 1.0 - h)
        samples.append(frame.kinematics.solve(pose, move.configuration, samples[-1]))
    histories = [SampleHistory() for _ in goal]
    for sample in samples[:0:-1]:
        for history, angle in zip(histories, sample, strict=True):
            history.push(angle)
    derivatives = np.array([history.one_ahead(tau, window) for history in histories])
    if move.mode is Mode.JOINT and not rests:
        seconds, t_seg = ticks * tau, move.segment_ticks * tau
        h_there = np.array([[seconds / t_seg], [1.0 / t_seg], [0.0], [0.0]])
        return np.asarray(derivatives.T + (remaining(h_there) * np.array(theta_BC))[:, 0])
    return np.asarray(derivatives.T)


def _times(move: Move) -> tuple[int, int]:
    return (move.acceleration_ticks, move.segment_ticks)


def estimated_start(
    frame: Frame, solve: Callable[[float, Joints], Joints], start: float, exact: Floats, ticks: int
) -> Floats:
    """A goal that moves by itself, at local time ``start``, s, as the joints take it; shape (4, 6).

    They watch it for some periods: where it passes next to a singularity meanwhile, the fit is not
    how it goes on.

    Args:
        frame: of the plan.
        solve: angles at a local time, on the turns nearest to others, rad.
        start: where it takes over.
        exact: what it is there, and three derivatives by time.
        ticks: t_acc of the transition, which decides how long it is watched.
    """
    q1, q2, q3, q4, q5, q6 = exact[0].tolist()
    samples: list[Joints] = [solve(start, (q1, q2, q3, q4, q5, q6))]
    for n in range(1, window_for(ticks)):
        samples.append(solve(start - n * frame.period_s, samples[-1]))
    estimated = exact.copy()
    for joint in range(6):
        history = SampleHistory()
        for sample in reversed(samples):
            history.push(sample[joint])
        estimated[1:, joint] = history.at_newest(frame.period_s, len(samples))[1:]
    return estimated

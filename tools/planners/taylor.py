"""Taylor's bounded-deviation joint paths: as few knots as keep joint motion near a straight line.

Taylor, "Planning and execution of straight line manipulator trajectories", IBM J. Res. Develop.
23(4) (1979); thesis section III.2. The formulas are recalled, not checked. Before the motion, a
line is halved until the hand of the joint angles' midpoint is within a bound of the line's
midpoint, in position and in rotation. The motion itself runs straight in joint angles from knot to
knot, and its transitions are parabolas: at knot k, for |t| <= w,

    q_k - (w - t)^2 / (4 w) rate before + (w + t)^2 / (4 w) rate after.

Ours, as the paper's transitions at goals would reach over several knots: at a goal the same two
parabolas are the time on the leg left and on the leg entered. On legs of one joint line it is the
same. Knots inside a leg have transitions of half the shorter neighbouring interval.
"""

from bisect import bisect_right
from collections.abc import Iterator
from itertools import pairwise
from typing import Final, NamedTuple

from planners.clock import Clock
from planners.planner import NotPossibleError
from planners.task import UPPER_ARM, Leg, Task
from rfms_can.kinematics import InverseKinematics, Joints, direct
from rfms_can.transform import DriveTransform, Transform
from rfms_can.wire.vocabulary import Mode

POSITION_BOUND: Final = 0.25e-3
"""Deviation of the hand at a midpoint, m, on an arm with ``UPPER_ARM``; else in proportion."""

ROTATION_BOUND: Final = 5e-3
"""The same of its rotation, rad."""

MAX_DEPTH: Final = 12
"""Times a line is halved at most."""


class Bounds(NamedTuple):
    """Metres and radians."""

    position: float
    rotation: float


class Knot(NamedTuple):
    """A point a joint path passes: the leg's parameter, 0 to 1, and angles, rad."""

    h: float
    q: Joints


class Line:
    """A straight line in space from ``start`` to ``goal``, tool poses, turning about one axis."""

    def __init__(self, start: Transform, goal: Transform) -> None:
        self._goal: Final = goal
        self._drive: Final = DriveTransform(goal.inverse() @ start)

    def at(self, h: float) -> Transform:
        """The tool's pose."""
        return self._goal @ self._drive.at(1.0 - h)


def bounded_deviation(
    task: Task, line: Line, first: Joints, last: Joints, bounds: Bounds
) -> list[Knot]:
    """Knots of ``line`` from angles ``first`` to ``last``: the algorithm of Taylor (1979).

    Raises:
        NotPossibleError: after so many halvings it is still too far off.
        KinematicsError: a knot has no solution.
    """
    solve = InverseKinematics(task.arm).solve
    from_tool, configuration = task.tool.inverse(), task.configuration

    def between(a: Knot, b: Knot, depth: int) -> Iterator[Knot]:
        middle = tuple(0.5 * (x + y) for x, y in zip(a.q, b.q, strict=True))
        h = 0.5 * (a.h + b.h)
        place = line.at(h)
        error = DriveTransform(place.inverse() @ direct(task.arm, middle) @ task.tool)
        x, y, z = error.p
        if x * x + y * y + z * z <= bounds.position**2 and error.psi <= bounds.rotation:
            yield b
            return
        if depth == MAX_DEPTH:
            raise NotPossibleError(f"{2**depth} knots are not enough for the bound")
        knot = Knot(h, solve(place @ from_tool, configuration, middle))
        yield from between(a, knot, depth + 1)
        yield from between(knot, b, depth + 1)

    begin = Knot(0.0, first)
    return [begin, *between(begin, Knot(1.0, last), 0)]


class JointPath:
    """Straight from knot to knot, rounded by parabolas; straight on before h = 0 and after 1."""

    def __init__(self, knots: list[Knot]) -> None:
        self._knots: Final = knots
        h = [knot.h for knot in knots]
        self._rates: Final = [
            [(y - x) / (b.h - a.h) for x, y in zip(a.q, b.q, strict=True)]
            for a, b in pairwise(knots)
        ]
        self._bounds: Final = [0.5 * (a + b) for a, b in pairwise(h)]
        inner = zip(h, h[1:], h[2:], strict=False)
        self._widths: Final = [0.0, *(0.5 * min(b - a, c - b) for a, b, c in inner), 0.0]

    def at(self, h: float) -> Joints:
        """The angles at h."""
        k = bisect_right(self._bounds, h)
        knot, width, rates = self._knots[k], self._widths[k], self._rates
        t = h - knot.h
        if -width < t < width:
            before, after = -((width - t) ** 2) / (4 * width), (width + t) ** 2 / (4 * width)
        else:
            before, after = min(t, 0.0), max(t, 0.0)
        left, right = rates[max(k - 1, 0)], rates[min(k, len(rates) - 1)]
        q1, q2, q3, q4, q5, q6 = (
            q + before * a + after * b for q, a, b in zip(knot.q, left, right, strict=True)
        )
        return (q1, q2, q3, q4, q5, q6)


class TaylorPlanner:
    """Joint paths of a task's legs, planned before the first cycle.

    Attributes:
        knots: of each leg, its ends included.
    """

    def __init__(self, task: Task, period_s: float) -> None:
        if task.moves:
            raise NotPossibleError("its knots are solved before the motion: no goal may move")
        self.leg = 0
        self.blending = False
        self._clock: Final = Clock(task.legs, period_s)
        self.knots: Final = list(_plan(task))
        self._paths: Final = [JointPath(knots) for knots in self.knots]

    def step(self) -> Joints:
        """Interpolated angles: no kinematics."""
        clock, paths = self._clock, self._paths
        number, n, _ = clock.advance()
        last = len(paths) - 1
        self.blending = clock.blending
        self.leg = last + 1 if clock.over else min(number, last)
        width = clock.acceleration[number]
        if n >= width:
            return (
                self.knots[last][-1].q
                if number > last
                else paths[number].at(n / clock.segment[number])
            )
        left, entered = (width - n) ** 2 / (4 * width), (width + n) ** 2 / (4 * width)
        if number == 0:
            return paths[0].at(entered / clock.segment[0])
        before = paths[number - 1].at(1.0 - left / clock.segment[number - 1])
        if number > last:
            return before
        after = paths[number].at(entered / clock.segment[number])
        corner = self.knots[number][0].q
        q1, q2, q3, q4, q5, q6 = (a + b - c for a, b, c in zip(before, after, corner, strict=True))
        return (q1, q2, q3, q4, q5, q6)


def _plan(task: Task) -> Iterator[list[Knot]]:
    """The knots of each leg."""
    solve = InverseKinematics(task.arm).solve
    from_tool = task.tool.inverse()
    bounds = Bounds(POSITION_BOUND * task.arm.a2 / UPPER_ARM, ROTATION_BOUND)
    q = task.start
    for number, leg in enumerate(task.legs):
        goal = solve(leg.target @ from_tool, task.configuration, q)
        yield _knots(task, number, leg, q, goal, bounds)
        q = goal


def _knots(
    task: Task, number: int, leg: Leg, q: Joints, goal: Joints, bounds: Bounds
) -> list[Knot]:
    if leg.mode is Mode.JOINT:
        return [Knot(0.0, q), Knot(1.0, goal)]
    return bounded_deviation(task, Line(task.before(number, 0.0), leg.target), q, goal, bounds)

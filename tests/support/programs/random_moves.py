"""Moves drawn at random, of every kind the generator knows, near a pose of the PUMA 260."""

from collections.abc import Sequence
from typing import NamedTuple

from hypothesis import strategies as st

from rfms_can.arm import PUMA_260
from rfms_can.errors import KinematicsError
from rfms_can.kinematics import InverseKinematics, Joints, direct
from rfms_can.master.trajectory.goal import FixedGoal, Goal, Moment
from rfms_can.master.trajectory.segment import Move, Segment, Transition
from rfms_can.wire.vocabulary import Mode
from support.trajectory import LEFT_DOWN, REST, TOOL, MovingGoal, WeavingGoal


class Leg(NamedTuple):
    """A move of a program, in seconds; ``wait`` after its request."""

    q: Joints
    kind: str
    mode: Mode
    transition: Transition
    cruise: float
    acceleration_time: float
    wait: float


def hundredths(least: int, most: int) -> st.SearchStrategy[float]:
    """Times that are whole at every period the programs are run with."""
    return st.integers(least, most).map(lambda n: n / 100)


def near(angle: float, reach: float) -> st.SearchStrategy[float]:
    """Angles within a reach of one, rad."""
    return st.floats(angle - reach, angle + reach)


def angles_near(q: Joints, reach: Sequence[float]) -> st.SearchStrategy[Joints]:
    """Joint angles, each within its reach of one of ``q``, rad."""
    return st.tuples(
        near(q[0], reach[0]), near(q[1], reach[1]), near(q[2], reach[2]),
        near(q[3], reach[3]), near(q[4], reach[4]), near(q[5], reach[5]),
    )  # fmt: skip


def legs(kinds: Sequence[str]) -> st.SearchStrategy[list[Leg]]:
    """Programs of one to four moves to goals of some kinds: resting, moving, weaving."""
    leg = st.builds(
        Leg,
        q=angles_near(REST, (0.3, 0.2, 0.2, 0.3, 0.3, 0.3)),
        kind=st.sampled_from(kinds),
        mode=st.sampled_from(Mode),
        transition=st.sampled_from(Transition),
        cruise=hundredths(30, 90),
        acceleration_time=hundredths(10, 30),
        wait=hundredths(0, 120),
    )
    return st.lists(leg, min_size=1, max_size=4)


def goal_of(leg: Leg, period_s: float) -> Goal:
    """What a move goes to."""
    pose = direct(PUMA_260, leg.q)
    if leg.kind == "moving":
        return MovingGoal(pose @ TOOL, (0.004, -0.003, 0.002), period_s)
    if leg.kind == "weaving":
        return WeavingGoal(pose @ TOOL, 0.001, 0.004)
    return FixedGoal(pose)


def move_of(number: int, leg: Leg, period_s: float) -> Move:
    """The move as the generator takes it."""
    acceleration = round(leg.acceleration_time / period_s)
    ticks = 2 * acceleration + round(leg.cruise / period_s)
    entry = leg.transition if leg.mode is Mode.CARTESIAN else Transition.JOINT
    goal = goal_of(leg, period_s)
    return Move(number, goal, leg.mode, ticks, acceleration, LEFT_DOWN, entry)


SAMPLES = 24

_solve = InverseKinematics(PUMA_260).solve


def is_runnable(before: Move, move: Move, q: Joints, period_s: float, tick: int = 0) -> bool:
    """Whether the path of ``move``, from the goal of ``before`` at angles near ``q``, has solutions
    that the joints' speeds allow."""
    origin = before.target.pose(Moment(tick))
    segment = Segment.towards(move, origin, Moment(tick, 0.0))
    samples = 1 if move.mode is Mode.JOINT else SAMPLES
    duration = move.segment_ticks * period_s / samples
    try:
        q = _solve(origin, before.configuration, q)
        for sample in range(1, samples + 1):
            h = sample / samples
            ahead = _solve(segment.pose(Moment(tick, h), 1.0 - h), move.configuration, q)
            turns = (abs(b - a) / duration for a, b in zip(q, ahead, strict=True))
            if any(
                speed > limit for speed, limit in zip(turns, PUMA_260.speed_limits, strict=True)
            ):
                return False
            q = ahead
    except KinematicsError:
        return False
    return True

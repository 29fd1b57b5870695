"""Corners drawn at random: from rest over a position the tool passes to another, and to rest there.

A seed tells all of a corner: where it is, its angle, the lengths and speeds of its two legs, how
the tool turns on each, their modes and the transition between them. It is drawn again until the arm
can do each leg alone, from rest to rest, in the time its speed asks for: what breaks then is the
corner.
"""

import math
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.random import Generator, default_rng

from rfms_can.arm import Arm
from rfms_can.errors import MoveError, RfmsError
from rfms_can.kinematics import Configuration, Joints, configuration_of, direct, inverse
from rfms_can.master.trajectory.goal import FixedGoal, Goal, Moment
from rfms_can.master.trajectory.planning import MovePlanner
from rfms_can.master.trajectory.segment import Entry, Segment, Transition
from rfms_can.transform import Transform, Vector3
from rfms_can.wire.vocabulary import Mode

Floats = npt.NDArray[np.float64]

UPPER_ARM: Final = 0.2032
"""Length of the upper arm that the ranges below are given for, m: the PUMA 260's."""

TOOL_LENGTH: Final = 0.1354
"""From T6 to the tip of the tool, m, on such an arm."""

LENGTH: Final = (0.05, 0.25)
"""Of a leg, m, on such an arm."""

SPEED: Final = (0.05, 0.4)
"""Of the tool on a leg, m/s, on such an arm; drawn on a logarithmic scale."""

ANGLE: Final = (math.radians(15.0), math.radians(165.0))
"""By which the tool's direction changes, rad."""

TURN: Final = math.radians(60.0)
"""Largest rotation of the tool on a leg, rad."""

ACCELERATION: Final = (0.06, 0.3)
"""t_acc of a mode, s."""

SPREAD: Final = 0.5
"""Rad by which each joint may be from where the arm is parked."""


class Place(NamedTuple):
    """A position as a planner sees it."""

    name: str
    goal: Goal
    configuration: Configuration


class How(NamedTuple):
    """A mode as a planner sees it."""

    mode: Mode
    transition: Transition
    speed: float
    acceleration_time: float
    deviation: float | None = None
    segment_time: float | None = None
    angular_speed: float | None = None
    joint_speed: float | None = None
    lengthen: bool = True
    lengthen_at_most: float = 1e3
    configuration: Configuration | None = None


class Corner(NamedTuple):
    """Two legs of one arm.

    Attributes:
        seed: it was drawn with.
        arm: of it.
        start: joint angles it rests at, rad.
        tool: in T6.
        angle: between the two directions, rad.
        places: the position that is passed, and where it ends.
        modes: of the two legs; the second has the transition, and as yet no deviation.
    """

    seed: int
    arm: Arm
    start: Joints
    tool: Transform
    angle: float
    places: tuple[Place, Place]
    modes: tuple[How, How]


def draw(arm: Arm, seed: int, period_s: float) -> Corner:
    """The corner of ``seed``."""
    random = default_rng((arm.arm_id, seed))
    while True:
        try:
            corner = _drawn(arm, seed, random)
            _check_legs(corner, period_s)
        except RfmsError:
            continue
        return corner


def _drawn(arm: Arm, seed: int, random: Generator) -> Corner:
    """A corner.

    Raises:
        KinematicsError: the arm does not reach where it starts.
    """
    scale = arm.a2 / UPPER_ARM
    tool = Transform.translation(0.0, 0.0, TOOL_LENGTH * scale)
    configuration = configuration_of(arm, arm.park)
    q_via = joints(np.array(arm.park) + random.uniform(-SPREAD, SPREAD, 6))
    via = direct(arm, q_via) @ tool
    angle = float(random.uniform(*ANGLE))
    one, aside = _direction(random), _direction(random)
    across = aside - one * (one @ aside)
    across /= np.linalg.norm(across)
    two = math.cos(angle) * one + math.sin(angle) * across
    lengths = random.uniform(*LENGTH, 2) * scale
    begin = _displaced(via, -lengths[0] * one, random)
    end = _displaced(via, lengths[1] * two, random)
    speeds = np.exp(random.uniform(math.log(SPEED[0]), math.log(SPEED[1]), 2)) * scale
    times = random.uniform(*ACCELERATION, 2).round(3)
    modes = [list(Mode)[k] for k in random.integers(len(Mode), size=2)]
    transition = list(Transition)[random.integers(len(Transition))]
    start = inverse(arm, begin @ tool.inverse(), configuration, q_via)
    return Corner(
        *(seed, arm, start, tool, angle),
        (
            Place("via", FixedGoal(via, tool), configuration),
            Place("end", FixedGoal(end, tool), configuration),
        ),
        (
            How(modes[0], Transition.JOINT, float(speeds[0]), float(times[0])),
            How(modes[1], transition, float(speeds[1]), float(times[1])),
        ),
    )


def _check_legs(corner: Corner, period_s: float) -> None:
    """Each leg alone, from rest to rest, is within the limits as it was drawn.

    Raises:
        RfmsError: it is not.
    """
    planner = MovePlanner(corner.arm, period_s)
    q = corner.start
    for number, (place, how) in enumerate(zip(corner.places, corner.modes, strict=True), 1):
        planner.reset(q)
        rest = Segment.hold(direct(corner.arm, q), place.configuration)
        plan = planner.plan(Entry(rest), place, how._replace(lengthen=False), number)
        if plan.segment_time > distance(corner, number - 1) / how.speed + period_s:
            raise MoveError("its acceleration time, not its speed, decides how long it takes")
        q = inverse(corner.arm, place.goal.pose(Moment(0)), place.configuration, q)


def distance(corner: Corner, leg: int) -> float:
    """How far the tool goes on a leg, m."""
    ends = [direct(corner.arm, corner.start) @ corner.tool]
    ends += [place.goal.left(Moment(0)) for place in corner.places]
    a, b = ends[leg : leg + 2]
    return math.dist((a.px, a.py, a.pz), (b.px, b.py, b.pz))


def _direction(random: Generator) -> Floats:
    """A unit vector, any direction as likely as any other."""
    vector = random.normal(size=3)
    return np.asarray(vector / np.linalg.norm(vector))


def _displaced(pose: Transform, by: Floats, random: Generator) -> Transform:
    """``pose`` moved, m, and turned about its own origin by up to ``TURN``."""
    x, y, z = by.tolist()
    axis: Vector3 = tuple(_direction(random).tolist())
    turn = Transform.rotation(axis, float(random.uniform(0.0, TURN)))
    return Transform.translation(x, y, z) @ pose @ turn


def joints(values: Floats) -> Joints:
    """Six angles of an array."""
    j1, j2, j3, j4, j5, j6 = values.tolist()
    return (j1, j2, j3, j4, j5, j6)

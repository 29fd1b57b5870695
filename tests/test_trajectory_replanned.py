"""Planned again from any sample: what a second master and second joints need to go on alike.

Of a motion with moves i, i + 1, ... ahead and i under way, that is: the goal that i left, those
moves, and the arm's own angles of the last 40 cycles before it did. No state is copied.

A goal left behind must rest (one that moves is known only with the move that followed it), a
Cartesian transition wants to know the segment it leaves, and the angles must be of one straight
part. Where one of these is not so, the second instances begin a move earlier.
"""

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st
from pytest import approx
from support.programs.random_moves import Leg, is_runnable, legs, move_of
from support.trajectory import LEFT_DOWN, REST, TAU, Rig

from rfms_can.arm import PUMA_260
from rfms_can.errors import MoveError
from rfms_can.kinematics import direct
from rfms_can.master.trajectory.generator import TrajectoryGenerator
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.trajectory.segment import Move, Transition
from rfms_can.setpoint import CartesianSetpoint, JointSetpoint
from rfms_can.wire.vocabulary import Blend, Mode, TrajectoryState

REACH = 40
"""Cycles of the arm's own angles that tell how it moved."""


class Motion(NamedTuple):
    """A rig that has run, and the moves it has accepted, number k at index k - 1."""

    rig: Rig
    moves: list[Move]

    def begin(self, number: int) -> int:
        """The cycle the segment of move ``number`` is entered with."""
        numbers = (setpoint.sequence for setpoint in self.rig.setpoints)
        return next(k for k, sequence in enumerate(numbers) if sequence == number)

    def straight_before(self, begin: int) -> int:
        """Cycles before ``begin`` outside transitions."""
        first = begin
        while first > 0 and not self.rig.setpoints[first - 1].p:
            first -= 1
        return begin - first

    def planned_from(self, number: int) -> int:
        """The move to begin with in order to go on with move ``number``."""
        while number > 1:
            left, move = self.moves[number - 2], self.moves[number - 1]
            knows = move.transition is Transition.JOINT and left.target.constant
            if knows and self.straight_before(self.begin(number)) >= REACH:
                break
            number -= 1
        return number


def run(program: list[Leg]) -> Motion:
    """All moves requested at once; what the arm cannot do is left out."""
    rig = Rig(Blend.CONTINUOUS, TAU, REST)
    rig.run(REACH)
    moves: list[Move] = []
    for leg in program:
        move = move_of(len(moves) + 1, leg, TAU)
        before = rig.generator.last_accepted.move
        if not is_runnable(before, move, REST, TAU, rig.generator.tick_count):
            continue
        try:
            rig.generator.request(move)
        except MoveError:
            continue
        moves.append(move)
    rig.finish(20000)
    return Motion(rig, moves)


def planned_again(motion: Motion, number: int) -> list[CartesianSetpoint]:
    """What a second master says from the beginning of move ``number`` on."""
    pose = direct(PUMA_260, REST)
    if number > 1:
        pose = motion.moves[number - 2].target.pose(Moment(0))

    def departing(tick: int) -> tuple[TrajectoryGenerator, CartesianSetpoint]:
        master = TrajectoryGenerator(TAU)
        master.enable(pose, LEFT_DOWN)
        master.tick_count = tick
        for move in motion.moves[number - 1 :]:
            master.request(move)
        while (setpoint := master.tick()).sequence != number:
            pass
        return master, setpoint

    begin = motion.begin(number)
    looked, _ = departing(begin)  # it looks at a moving goal for a while, and then departs
    master, first = departing(2 * begin + 1 - looked.tick_count)
    assert master.tick_count == begin + 1
    return [first, *(master.tick() for _ in range(begin + 1, len(motion.rig.q)))]


def followed_again(motion: Motion, begin: int, said: list[CartesianSetpoint]) -> list[list[float]]:
    """Second joints: they follow the arm to ``begin``, as at rest, and then what is ``said``."""
    rig, first = motion.rig, begin - REACH
    joints = [JointSetpoint(TAU, theta) for theta in rig.q[first]]
    setpoints = list(said)
    for k in range(begin - 1, first - 1, -1):
        q1, q2, q3, q4, q5, q6 = rig.q[k]
        setpoints.insert(
            0,
            rig.setpoints[k]._replace(
                state=TrajectoryState.IDLE,
                r=0.0,
                T6_1=direct(PUMA_260, (q1, q2, q3, q4, q5, q6)),
                configuration_1=LEFT_DOWN,
            ),
        )
    q = []
    for setpoint in setpoints:
        pairs = zip(joints, rig.solvers, strict=True)
        q.append([joint.tick(setpoint, solver.solve) for joint, solver in pairs])
    return q[REACH:]


def go_on_from(motion: Motion, sample: int) -> int:
    """Compare the rest from ``sample`` on; the number of the move it was planned from."""
    rig = motion.rig
    number = motion.planned_from(max(1, rig.setpoints[sample].sequence))
    begin = motion.begin(number)
    said = planned_again(motion, number)
    rest = max(sample, begin)
    for mine, reference in zip(said[rest - begin :], rig.setpoints[rest:], strict=True):
        assert (mine.state, mine.mode, mine.sequence) == (
            *(reference.state, reference.mode, reference.sequence),
        )
        assert (mine.n, mine.h, mine.r, mine.p) == approx(
            (reference.n, reference.h, reference.r, reference.p), abs=1e-12
        )
        assert tuple(mine.T6_1) == approx(tuple(reference.T6_1), abs=1e-9)
    again = np.array(followed_again(motion, begin, said))[rest - begin :]
    assert np.max(np.abs(again - np.array(rig.q[rest:]))) < 1e-9
    return number


mostly_resting = legs(("resting", "resting", "resting", "moving", "weaving"))


@settings(max_examples=60)
@given(st.tuples(mostly_resting, mostly_resting), st.floats(0.0, 1.0))
def test_second_instances_reproduce_the_rest_from_any_sample(
    programs: tuple[list[Leg], list[Leg]], share: float
) -> None:
    """Any after the first move, so that there is something that need not be known.

    At five of six of these samples the second instances begin with a later move than the first.
    """
    motion = run([*programs[0], *programs[1]])
    if len(motion.moves) < 2 or np.isnan(motion.rig.q).any():  # a goal went out of reach
        reject()
    second, last = motion.begin(2), len(motion.rig.q) - 1
    go_on_from(motion, second + round(share * (last - second)))


RESTING, MOVING = "resting", "moving"
JOINT, STRAIGHT, BLENDED = Mode.JOINT, Mode.CARTESIAN, Transition.JOINT
FOUR = [
    Leg((0.3, 1.25, -2.6, 0.3, 1.1, -0.2), RESTING, JOINT, BLENDED, 0.6, 0.2, 0.0),
    Leg((0.1, 1.2, -2.7, 0.4, 1.0, 0.0), RESTING, STRAIGHT, BLENDED, 0.6, 0.2, 0.0),
    Leg((0.3, 1.1, -2.7, 0.3, 0.9, -0.2), MOVING, STRAIGHT, BLENDED, 0.6, 0.1, 0.0),
    Leg((0.2, 1.2, -2.6, 0.2, 1.1, -0.1), RESTING, JOINT, BLENDED, 0.6, 0.2, 0.0),
]


@pytest.mark.parametrize(("move", "planned_from"), [(1, 1), (2, 2), (3, 3), (4, 3)])
def test_they_need_no_more_than_the_move_under_way(move: int, planned_from: int) -> None:
    """In its transition, along it, and before the next; of the fourth, which leaves a moving goal,
    the third."""
    motion = run(FOUR)
    assert len(motion.moves) == len(FOUR)
    cycles = [k for k, each in enumerate(motion.rig.setpoints) if each.sequence == move]
    for sample in (cycles[0], cycles[7], cycles[len(cycles) // 2], cycles[-1]):
        assert go_on_from(motion, sample) == planned_from

"""Random programs of everything the generator knows: what must hold of each of them.

Programs mix modes and transitions, goals that rest, move and weave, requests made in motion and too
late, feed rates, pauses and resumes.
"""

import itertools
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from hypothesis import given, reject, settings
from hypothesis import strategies as st
from pytest import approx
from support.programs.random_moves import Leg, hundredths, is_runnable, legs, move_of
from support.trajectory import LEFT_DOWN, REST, TAU, Rig, deviation

from rfms_can.arm import PUMA_260
from rfms_can.errors import MoveError
from rfms_can.kinematics import direct
from rfms_can.master.trajectory.states import Stage
from rfms_can.setpoint import JointSetpoint
from rfms_can.wire.vocabulary import Blend, Mode, TrajectoryState


class Pace(NamedTuple):
    """An operator at work: ``wait`` seconds, then a feed rate, or a pause (0) of ``stand``."""

    wait: float
    rate: float
    stand: float


paces = st.lists(
    st.builds(
        Pace,
        wait=hundredths(1, 80),
        rate=st.sampled_from((0.0, 0.25, 0.5, 1 / 3, 0.8, 1.0)),
        stand=hundredths(10, 60),
    ),
    max_size=5,
)


def requests(
    rig: Rig, program: list[Leg], *, at_once: bool = False, begin: int = 1
) -> Iterator[None]:
    """Request the moves of ``program``; a step of this is a cycle. Refused ones are left out."""
    q1, q2, q3, q4, q5, q6 = rig.q[-1]
    here = (q1, q2, q3, q4, q5, q6)
    for number, leg in enumerate(program, begin):
        move = move_of(number, leg, rig.period_s)
        before = rig.generator.last_accepted.move
        if not is_runnable(before, move, here, rig.period_s, rig.generator.tick_count):
            continue
        try:
            rig.generator.request(move)
        except MoveError:
            continue
        if not at_once:
            yield from itertools.repeat(None, round(leg.wait / rig.period_s))


def operate(rig: Rig, changes: list[Pace]) -> Iterator[None]:
    """Change the pace; a step of this is a cycle. In the end at full speed."""
    for change in changes:
        yield from itertools.repeat(None, round(change.wait / rig.period_s))
        if change.rate:
            rig.generator.set_feed(change.rate)
        else:
            rig.generator.pause()
            yield from itertools.repeat(None, round(change.stand / rig.period_s))
            rig.generator.resume()
    if changes:
        rig.generator.set_feed(1.0)


def run(
    program: list[Leg],
    changes: list[Pace],
    period_s: float = TAU,
    *,
    at_once: bool = False,
    feed: float = 1.0,
) -> Rig:
    rig = Rig(Blend.CONTINUOUS, period_s, REST)
    rig.generator.set_feed(feed)
    rig.run(round(0.1 / period_s))
    drive(rig, [requests(rig, program, at_once=at_once), operate(rig, changes)])
    return rig


def drive(rig: Rig, hands: list[Iterator[None]]) -> None:
    """Let ``hands`` at the generator, one step a cycle, and run to the end."""
    over = object()
    while hands:
        hands = [hand for hand in hands if next(hand, over) is not over]
        rig.tick()
    rig.finish(20000)
    rig.run(round(0.1 / rig.period_s))
    if np.isnan(rig.q).any():  # a goal has carried the path out of reach
        reject()


# --- Continuity -------------------------------------------------------------------------------


@settings(max_examples=25)
@given(legs(("resting", "moving", "weaving")), paces)
def test_position_velocity_acceleration_and_jerk_are_continuous(
    program: list[Leg], changes: list[Pace]
) -> None:
    """A difference quotient stays where it is with half the period, if derivatives do not step.

    That of order 4 would double if jerk stepped, and grow fourfold if acceleration did. At the end
    of a ramp of the pace it is seen more sharply with the shorter period: there it may double.
    """
    coarse, fine = (run(program, changes, period) for period in (0.005, 0.0025))
    assert coarse.generator.completed == fine.generator.completed
    for order, most in ((1, 1.1), (2, 1.1), (3, 1.15), (4, 3.0 if changes else 1.75)):
        assert fine.difference(order) < most * coarse.difference(order) + 20.0, f"order {order}"


def test_the_bound_is_one_the_blend_of_the_thesis_breaks() -> None:
    """Which takes the acceleration that a straight line leaves behind for zero."""
    grown = []
    for period in (0.005, 0.0025):
        rig = Rig(Blend.THESIS, period)
        rig.move(Mode.CARTESIAN, "W1", 1.0, 0.2)
        rig.move(Mode.CARTESIAN, "W2", 1.0, 0.2)
        rig.finish()
        grown.append(rig.difference(4))
    assert grown[1] > 2.0 * grown[0]


# --- The path ---------------------------------------------------------------------------------


@settings(max_examples=30)
@given(legs(("resting",)), paces, st.sampled_from((0.2, 1 / 3, 0.5, 1.0)))
def test_the_path_does_not_depend_on_the_pace(
    program: list[Leg], changes: list[Pace], feed: float
) -> None:
    """To rounding; where a joint estimates how it leaves a straight line, to that estimate."""
    nominal = run(program, [], at_once=True)
    rig = run(program, changes, at_once=True, feed=feed)
    assert rig.generator.completed == nominal.generator.completed
    if rig.generator.completed:
        straight = any(point.mode is Mode.CARTESIAN for point in nominal.setpoints)
        assert deviation(rig, nominal) < (5e-5 if straight and nominal.starts() else 1e-7)
        assert rig.q[-1] == approx(nominal.q[-1], abs=1e-9)


# --- Planned again from a sample --------------------------------------------------------------


def largest(mine: list[list[float]], reference: list[list[float]]) -> float:
    assert len(mine) == len(reference)
    return float(np.max(np.abs(np.array(mine) - np.array(reference))))


@settings(max_examples=25)
@given(legs(("resting", "moving", "weaving")), st.sampled_from((0.3, 0.5, 1.0)))
def test_joints_that_saw_only_poses_before_a_hand_over_reproduce_the_rest(
    program: list[Leg], feed: float
) -> None:
    """They know nothing of the segment left: they followed the arm's own poses, as in IDLE.

    What the first joints knew of it, r and theta_BC, the goal and the turns, is in the samples.
    """
    rig = run(program, [], feed=feed)
    for start in rig.starts():
        first = start
        while first > 0 and not rig.setpoints[first - 1].p and start - first < 200:
            first -= 1
        if start - first < 40:
            continue
        joints = [JointSetpoint(TAU, theta) for theta in rig.q[first]]
        again = []
        for k in range(first, len(rig.q)):
            setpoint = rig.setpoints[k]
            if k < start:
                q1, q2, q3, q4, q5, q6 = rig.q[k]
                pose = direct(PUMA_260, (q1, q2, q3, q4, q5, q6))
                setpoint = setpoint._replace(
                    state=TrajectoryState.IDLE, T6_1=pose, configuration_1=LEFT_DOWN
                )
            pairs = zip(joints, rig.solvers, strict=True)
            again.append([joint.tick(setpoint, solver.solve) for joint, solver in pairs])
        assert largest(again, rig.q[first:]) < 1e-9


@settings(max_examples=25)
@given(legs(("resting", "weaving")), legs(("resting", "moving", "weaving")), paces)
def test_a_second_generator_enabled_at_rest_reproduces_the_rest(
    before: list[Leg], program: list[Leg], changes: list[Pace]
) -> None:
    first = run([leg._replace(kind="resting") for leg in before], [])
    here = len(first.q)
    q1, q2, q3, q4, q5, q6 = first.q[-1]
    second = Rig(Blend.CONTINUOUS, TAU, (q1, q2, q3, q4, q5, q6))
    second.generator.tick_count = here
    second.tick()
    first.tick()
    for rig in (first, second):
        drive(rig, [requests(rig, program, begin=len(before) + 1), operate(rig, changes)])
    assert largest(second.q, first.q[here:]) < 1e-9
    for mine, reference in zip(second.setpoints, first.setpoints[here:], strict=True):
        assert (mine.r, mine.p) == (reference.r, reference.p)
        assert approx(tuple(reference.T6_1), abs=1e-9) == mine.T6_1
        assert (mine.n, mine.h, mine.state) == (reference.n, reference.h, reference.state)


@settings(max_examples=10)
@given(legs(("resting", "moving", "weaving")), paces, st.floats(0.0, 1.0))
def test_a_second_instance_that_is_told_the_same_up_to_any_sample_continues_alike(
    program: list[Leg], changes: list[Pace], share: float
) -> None:
    """Joints that know nothing but where they are go on from a Cartesian transition."""
    rig, again = run(program, changes), run(program, changes)
    assert again.q == rig.q
    assert again.setpoints == rig.setpoints
    curves = [k for k, stage in enumerate(rig.stages) if stage is Stage.CURVE]
    if not curves:
        return
    sample = curves[round(share * (len(curves) - 1))]
    joints = [JointSetpoint(TAU, theta) for theta in rig.q[sample - 1]]
    end = next((k for k in rig.starts() if k > sample), len(rig.q))
    for k in range(sample, end):
        pairs = zip(joints, rig.solvers, strict=True)
        q = [joint.tick(rig.setpoints[k], solver.solve) for joint, solver in pairs]
        assert q == approx(rig.q[k], abs=1e-9)

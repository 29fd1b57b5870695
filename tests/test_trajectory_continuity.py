"""What the thesis claims of its transitions and the default blend keeps: continuity up to jerk.

A difference quotient of order 4 stays where it is when the period is halved if the third
derivative is continuous, doubles if jerk steps, grows fourfold if acceleration steps and
eightfold if velocity does.
"""

from collections.abc import Callable

import numpy as np
import pytest
from pytest import approx
from support.trajectory import Rig, golden_rig

from rfms_can.wire.vocabulary import Blend, Mode

CARTESIAN, JOINT = Mode.CARTESIAN, Mode.JOINT
VELOCITY = (-0.05, -0.03, -0.03)  # m/s

Program = Callable[[Rig], None]


def leaving_a_cartesian_segment(rig: Rig) -> None:
    rig.move(JOINT, "W1", 1.0, 0.2)
    rig.move(CARTESIAN, "W2", 1.5, 0.25)
    rig.move(JOINT, "W3", 1.2, 0.2)


def leaving_a_moving_goal(rig: Rig) -> None:
    rig.move(JOINT, "W2", 1.0, 0.2, VELOCITY)
    rig.move(JOINT, "W1", 1.0, 0.2)


def joining_a_moving_goal_on_a_straight_line(rig: Rig) -> None:
    rig.move(JOINT, "W1", 1.0, 0.2)
    rig.move(CARTESIAN, "W2", 1.2, 0.2, VELOCITY)
    rig.move(CARTESIAN, "W1", 1.2, 0.2)


def joint_to_joint(rig: Rig) -> None:
    rig.move(JOINT, "W1", 1.0, 0.2)
    rig.move(JOINT, "W2", 1.0, 0.25)
    rig.move(JOINT, "W3", 1.0, 0.2)


def straight_lines_from_rest_to_rest(rig: Rig) -> None:
    rig.move(CARTESIAN, "W1", 1.0, 0.2)
    rig.move(CARTESIAN, "W2", 1.0, 0.2)


def segments_hardly_longer_than_their_transitions(rig: Rig) -> None:
    rig.move(CARTESIAN, "W1", 0.46, 0.2)
    rig.move(CARTESIAN, "W2", 0.47, 0.2)
    rig.move(JOINT, "W1", 0.48, 0.2)


PROGRAMS = [
    leaving_a_cartesian_segment,
    leaving_a_moving_goal,
    joining_a_moving_goal_on_a_straight_line,
    joint_to_joint,
    straight_lines_from_rest_to_rest,
    segments_hardly_longer_than_their_transitions,
]


def run(program: Program, blend: Blend, period_s: float) -> Rig:
    rig = Rig(blend, period_s)
    rig.run(20)
    program(rig)
    rig.finish()
    return rig


def growth(program: Program, blend: Blend) -> tuple[float, float]:
    """How the fourth difference quotient grows with half the period: overall, at a start."""
    coarse, fine = run(program, blend, 0.005), run(program, blend, 0.0025)
    overall = fine.difference(4) / coarse.difference(4)
    at_starts = max(
        fine.difference(4, b) / coarse.difference(4, a)
        for a, b in zip(coarse.starts(), fine.starts(), strict=True)
    )
    return overall, at_starts


@pytest.mark.parametrize("program", PROGRAMS)
def test_the_default_blend_is_continuous_up_to_jerk(program: Program) -> None:
    overall, at_starts = growth(program, Blend.CONTINUOUS)
    assert overall < 1.1
    assert at_starts < 1.5


@pytest.mark.parametrize("program", PROGRAMS[:3])
def test_the_thesis_blend_steps_in_acceleration_where_one_is_left_behind(program: Program) -> None:
    _, at_starts = growth(program, Blend.THESIS)
    assert at_starts == approx(4.0, abs=0.4)


def test_the_acceleration_step_of_the_golden_trajectory_is_gone() -> None:
    steps = {}
    for blend in Blend:
        rig, rows = golden_rig("static", blend)
        rig.run(len(rows))
        steps[blend] = rig.difference(3, 501, 4) * rig.period_s
    assert steps[Blend.THESIS] == approx(0.55, abs=0.01)  # rad/s2 in one period
    assert steps[Blend.CONTINUOUS] < 0.13  # what jerk alone makes of a period


@pytest.mark.parametrize("program", PROGRAMS)
def test_float32_on_the_wire_does_not_shake_a_transition(program: Program) -> None:
    exact, rounded = Rig(Blend.CONTINUOUS, 0.004), Rig(Blend.CONTINUOUS, 0.004, wire=True)
    for rig in (exact, rounded):
        rig.run(20)
        program(rig)
        rig.finish()
    difference = max(
        abs(a - b)
        for mine, reference in zip(rounded.q, exact.q, strict=True)
        for a, b in zip(mine, reference, strict=True)
    )
    assert difference < 2e-5
    for a, b in zip(exact.starts(), rounded.starts(), strict=True):
        assert rounded.difference(2, b) == approx(exact.difference(2, a), abs=0.2)


def slow_and_hardly_longer_than_its_transitions(rig: Rig) -> None:
    rig.move(CARTESIAN, "W1", 1.36, 0.6)
    rig.move(CARTESIAN, "W2", 1.36, 0.6)


@pytest.mark.parametrize("feed", [1.0, 0.3])
def test_noise_does_not_grow_with_the_third_power_of_a_slow_transition(feed: float) -> None:
    """With ten samples, what fits into two periods of even motion, it would be 1e-3 to 1e-2 rad."""
    rigs = [Rig(Blend.CONTINUOUS, 0.004), Rig(Blend.CONTINUOUS, 0.004, wire=True)]
    for rig in rigs:
        rig.run(20)
        rig.generator.set_feed(feed)
        slow_and_hardly_longer_than_its_transitions(rig)
        rig.finish()
    assert np.abs(np.subtract(rigs[0].q, rigs[1].q)).max() < 3e-4 / feed


def test_what_the_servo_hears_follows_the_commanded_motion_without_delay() -> None:
    rig = Rig(Blend.CONTINUOUS)
    leaving_a_cartesian_segment(rig)
    rates, accelerations = [], []
    while rig.generator.completed < 3:
        rig.tick()
        rates.append([joint.rate for joint in rig.joints])
        accelerations.append([joint.acceleration for joint in rig.joints])
    tau = rig.period_s
    for k in range(1, len(rates) - 1):
        for j in range(6):
            before, now, after = (rig.q[k + step][j] for step in (-1, 0, 1))
            assert rates[k][j] == approx((after - before) / (2.0 * tau), abs=1e-3)
            assert accelerations[k][j] == approx((after - 2.0 * now + before) / tau**2, abs=0.1)

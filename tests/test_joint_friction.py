"""Friction compensation of a complying joint: by motion, by intent, by a dither; transfers."""

import math
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rfms_can.arm import PUMA_560
from rfms_can.joint_nodes.friction import (
    COMPLYING_FRACTION,
    MOVING_CODES,
    TRANSFER_FRACTION,
    FrictionCompensation,
)
from rfms_can.master.start_up.node_parameters import joint_parameters
from rfms_can.wire.vocabulary import Parameter

DITHER_PERIOD_S = 0.032
POSITIVE, NEGATIVE, VISCOUS, LIMIT = 2.0, 3.0, 0.5, 50.0
MOVING = 0.003
"""Speed from which it counts as moving, rad/s."""
STEP = TRANSFER_FRACTION * LIMIT


def compensation(dither: float = 0.0, period: float = 0.004) -> FrictionCompensation:
    return FrictionCompensation(
        {
            Parameter.COULOMB_POSITIVE: POSITIVE,
            Parameter.COULOMB_NEGATIVE: NEGATIVE,
            Parameter.VISCOUS: VISCOUS,
            Parameter.FRICTION_SPEED: 2e-4,
            Parameter.PERIOD: period,
            Parameter.TORQUE_LIMIT: LIMIT,
            Parameter.NATURAL_FREQUENCY: 0.0,
            Parameter.COUNTS_PER_UNIT: 1.0,
            Parameter.RATE_PER_CODE: -MOVING / MOVING_CODES,  # a motor that turns against it
            Parameter.DITHER_FRACTION: dither,
            Parameter.DITHER_PERIOD: DITHER_PERIOD_S,
        }
    )


def settled(
    friction: FrictionCompensation, desired: float, measured: float, push: float = 0.0
) -> float:
    """Torque once compliance has begun."""
    for _ in range(120):
        torque = friction.complying(desired, measured, push, 0)
    return torque


# --- which way ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("measured", "torque"),
    [
        (0.4, COMPLYING_FRACTION * POSITIVE + 0.4 * VISCOUS),
        (-0.4, -COMPLYING_FRACTION * NEGATIVE - 0.4 * VISCOUS),
        (1.01 * MOVING, COMPLYING_FRACTION * POSITIVE + 1.01 * MOVING * VISCOUS),
    ],
)
def test_of_a_joint_that_moves_it_is_that_of_the_way_it_moves(
    measured: float, torque: float
) -> None:
    """It may be pushed against what is commanded: then what is commanded says nothing."""
    for desired, push in ((0.0, 0.0), (-0.9, 5.0), (0.9, -5.0)):
        assert settled(compensation(), desired, measured, push) == pytest.approx(torque)


@pytest.mark.parametrize("push", [0.02, -0.02])
def test_of_a_joint_that_rests_it_is_that_of_the_way_it_is_pushed(push: float) -> None:
    coulomb = COMPLYING_FRACTION * (POSITIVE if push > 0.0 else -NEGATIVE)
    torque = settled(compensation(), 0.0, 0.5 * MOVING, push)
    assert torque == pytest.approx(coulomb + VISCOUS * push)


def test_a_small_push_overcomes_a_part_of_it() -> None:
    """Less than a code of speed, either way: in proportion, without a step in between."""
    torques = [settled(compensation(), 0.0, 0.0, k * MOVING / 20.0) for k in range(-20, 21)]
    assert torques[20] == 0.0
    steps = [b - a for a, b in pairwise(torques)]
    assert min(steps) > 0.0
    assert max(steps) < 0.06 * (POSITIVE + NEGATIVE)


def test_it_never_overcomes_all_there_is() -> None:
    """Whatever moves by itself would go on for ever."""
    for measured in (-1.0, -0.01, 0.01, 1.0):
        coulomb = settled(compensation(), 0.0, measured) - VISCOUS * measured
        assert 0.9 < abs(coulomb) / (POSITIVE if measured > 0.0 else NEGATIVE) < 1.0


# --- dither ------------------------------------------------------------------------------------


@pytest.mark.parametrize(("rate", "cycles"), [(100, 4), (125, 4), (250, 8), (500, 16), (1000, 32)])
def test_a_dither_is_up_as_long_as_down_and_takes_its_time_in_seconds(
    rate: int, cycles: int
) -> None:
    friction = compensation(dither=0.5, period=1.0 / rate)
    settled(friction, 0.0, 0.0)
    wave = [friction.complying(0.0, 0.0, 0.0, k) for k in range(10 * cycles)]
    assert wave[:cycles] == wave[cycles : 2 * cycles]
    assert wave[:cycles] == [0.5 * POSITIVE] * (cycles // 2) + [-0.5 * NEGATIVE] * (cycles // 2)
    assert cycles / rate == pytest.approx(DITHER_PERIOD_S, rel=0.3)


@given(st.floats(0.0, 1.0), st.floats(-1.0, 1.0))
def test_a_dither_goes_a_part_of_the_way_to_the_friction_of_either_sense(
    part: float, push: float
) -> None:
    friction, still = compensation(dither=part), compensation()
    settled(friction, 0.0, 0.0, push * MOVING)
    without = settled(still, 0.0, 0.0, push * MOVING)
    for k in range(8):
        torque = friction.complying(0.0, 0.0, push * MOVING, k)
        wave = POSITIVE if k < 4 else -NEGATIVE
        coulomb = without - VISCOUS * push * MOVING
        assert torque - without == pytest.approx(part * (wave - coulomb))
        assert -NEGATIVE <= torque - VISCOUS * push * MOVING <= POSITIVE


def test_what_moves_is_not_dithered() -> None:
    friction = compensation(dither=1.0)
    settled(friction, 0.0, 0.2)
    assert len({friction.complying(0.0, 0.2, 0.0, k) for k in range(16)}) == 1


def test_a_dither_waits_until_compliance_has_begun() -> None:
    friction = compensation(dither=1.0)
    friction.rigid(0.4)
    friction.rigid(0.0)
    torques = [friction.complying(0.0, 0.0, -0.1, k) for k in range(40)]
    begun = next(k for k, t in enumerate(torques) if abs(t - torques[max(k - 1, 0)]) > STEP * 1.001)
    assert begun > (POSITIVE + COMPLYING_FRACTION * NEGATIVE) / STEP - 1.0


def test_a_rigid_joint_is_never_dithered() -> None:
    friction = compensation(dither=1.0)
    assert {friction.rigid(0.0) for _ in range(20)} == {0.0}


# --- bumpless transfer -------------------------------------------------------------------------

speeds = st.floats(-1.0, 1.0)


@given(speeds, speeds, speeds, speeds)
@settings(max_examples=200)
def test_where_compliance_begins_torque_goes_over_in_small_steps(
    desired: float, later: float, measured: float, push: float
) -> None:
    friction = compensation()
    friction.rigid(desired)
    before = friction.rigid(later)
    for k in range(60):
        torque = friction.complying(later, measured, push, k)
        assert abs(torque - before) <= STEP * (1.0 + 1e-9)
        before = torque
    assert before == settled(compensation(), later, measured, push)  # and gets there


@given(speeds, speeds, speeds, speeds)
@settings(max_examples=200)
def test_where_compliance_ends_torque_goes_over_in_small_steps(
    desired: float, measured: float, push: float, later: float
) -> None:
    friction = compensation()
    before = settled(friction, desired, measured, push)
    for _ in range(60):
        torque = friction.rigid(later)
        assert abs(torque - before) <= STEP * (1.0 + 1e-9)
        before = torque
    assert -NEGATIVE <= before - VISCOUS * later <= POSITIVE
    if abs(later) > 2e-4:
        coulomb = POSITIVE if later > 0.0 else -NEGATIVE
        assert before == pytest.approx(coulomb + VISCOUS * later)


def test_a_joint_that_goes_on_complying_turns_its_friction_at_once() -> None:
    friction = compensation()
    settled(friction, 0.0, 0.3)
    assert friction.complying(0.0, -0.3, 0.0, 0) == pytest.approx(
        -COMPLYING_FRACTION * NEGATIVE - 0.3 * VISCOUS
    )


def test_the_nodes_of_an_arm_count_as_moving_from_a_code_and_a_half() -> None:
    for joint, parameters in joint_parameters(PUMA_560, "corke", 0.004).items():
        friction = FrictionCompensation(parameters)
        code = abs(parameters[Parameter.RATE_PER_CODE])
        for _ in range(300):
            resting = friction.complying(0.0, code, 0.0, 0)
        assert resting == pytest.approx(0.0, abs=1e-12), joint
        for _ in range(300):
            moving = friction.complying(0.0, 2.0 * code, 0.0, 0)
        coulomb = parameters[Parameter.COULOMB_POSITIVE]
        assert moving == pytest.approx(
            COMPLYING_FRACTION * coulomb + 2.0 * code * parameters[Parameter.VISCOUS]
        )
        assert math.isfinite(moving)

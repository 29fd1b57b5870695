"""Worn plants: friction beyond what servos compensate, boards that are noisy and a little off."""

import random
from dataclasses import astuple

import pytest

from rfms_can.arm import ARMS, PUMA_560, Arm, friction_set
from rfms_can.plant.imperfect_board import BoardErrors, ImperfectBoard
from rfms_can.plant.variant import (
    WORN_CURRENT_NOISE,
    WORN_FRICTION,
    WORN_OFFSET,
    WORN_SLOPE,
    WORN_TACHOMETER,
    WORN_VELOCITY_NOISE,
    make_variant,
)

SEEDS = 40
DRAWN = {
    "adc_slope": WORN_SLOPE,
    "adc_offset": WORN_OFFSET,
    "current_noise": WORN_CURRENT_NOISE,
    "velocity_noise": WORN_VELOCITY_NOISE,
    "tachometer_gain": WORN_TACHOMETER,
}


@pytest.mark.parametrize("arm", ARMS.values(), ids=lambda arm: arm.name)
def test_friction_is_drawn_over_its_range_joint_by_joint(arm: Arm) -> None:
    least, most = WORN_FRICTION
    factors = []
    for seed in range(SEEDS):
        worn = make_variant(f"worn:{seed}", arm, "corke")
        assert worn.arm is arm
        for joint, known in zip(worn.friction, friction_set(arm, "corke"), strict=True):
            factor = joint.coulomb_positive / known.coulomb_positive
            assert astuple(joint) == pytest.approx(astuple(known.scaled(factor)))
            factors.append(factor)
    assert least <= min(factors) < least + 0.02
    assert most - 0.02 < max(factors) <= most
    assert len(set(factors)) == len(factors)


@pytest.mark.parametrize("name", DRAWN)
def test_boards_are_drawn_over_their_ranges(name: str) -> None:
    least, most = DRAWN[name]
    boards = [
        board
        for seed in range(SEEDS)
        for board in make_variant(f"worn:{seed}", PUMA_560, "corke").board_errors
    ]
    values = [getattr(board, name) for board in boards]
    margin = 0.05 * (most - least)
    assert least <= min(values) < least + margin
    assert most - margin < max(values) <= most
    assert {(board.encoder_sign, board.current_offset) for board in boards} == {(1, 0)}


def test_a_seed_has_one_plant() -> None:
    first, again = (make_variant("worn:3", PUMA_560, "thesis") for _ in range(2))
    assert [*map(astuple, first.friction)] == [*map(astuple, again.friction)]
    assert first.board_errors == again.board_errors
    assert first.board_errors != make_variant("worn:4", PUMA_560, "thesis").board_errors


def test_a_tachometer_is_off_by_its_gain_and_the_encoder_is_not() -> None:
    errors = BoardErrors(tachometer_gain=1.03)
    off = ImperfectBoard(PUMA_560, 0, 0.0, errors, random.Random(0))
    true = ImperfectBoard(PUMA_560, 0, 0.0, BoardErrors(), random.Random(0))
    for board in (off, true):
        board.observe(0.01, PUMA_560.speed_limits[0])
    (counts, _, told, _), (true_counts, _, speed, _) = off.sample(), true.sample()
    assert counts == true_counts
    assert told == pytest.approx(1.03 * speed, abs=1.0)

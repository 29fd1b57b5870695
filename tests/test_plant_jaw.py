"""The gripper's jaw: it opens, closes, and stalls on a part with its force on."""

import pytest

from rfms_can.arm import PUMA_260
from rfms_can.errors import PlantError
from rfms_can.plant.jaw import Jaw

GRIPPER = PUMA_260.gripper


def run(jaw: Jaw, code: int, seconds: float) -> None:
    jaw.set_motor_current(code)
    for _ in range(round(seconds * 1000)):
        jaw.step(1e-3)


def test_full_force_moves_at_the_speed_where_friction_balances_it() -> None:
    jaw = Jaw(GRIPPER, opening=GRIPPER.stroke)
    run(jaw, -2048, 0.05)
    assert jaw.speed == pytest.approx(-GRIPPER.force_limit / GRIPPER.friction, rel=1e-3)
    counts, current = jaw.sample()
    assert current == -2048
    assert counts == pytest.approx((jaw.opening - GRIPPER.stroke) * GRIPPER.counts_per_metre, abs=1)


def test_jaw_stops_at_either_end_and_without_force_stays_where_it_is() -> None:
    jaw = Jaw(GRIPPER, opening=0.04)
    run(jaw, 2047, 1.0)
    assert (jaw.opening, jaw.speed) == (GRIPPER.stroke, 0.0)
    run(jaw, -2048, 1.0)
    assert (jaw.opening, jaw.speed) == (0.0, 0.0)
    run(jaw, 0, 0.1)
    assert jaw.sample() == (round(-0.04 * GRIPPER.counts_per_metre), 0)


def test_jaw_stalls_on_a_part_and_goes_on_closing_when_it_is_taken_away() -> None:
    jaw = Jaw(GRIPPER, opening=0.05, part_width=0.02)
    run(jaw, -1000, 1.0)
    assert (jaw.opening, jaw.speed) == (0.02, 0.0)
    assert jaw.sample()[1] == -1000
    jaw.put_part(0.0)
    run(jaw, -1000, 1.0)
    assert jaw.opening == 0.0


def test_a_part_that_does_not_fit_is_refused() -> None:
    with pytest.raises(PlantError, match=r"opening 0\.01 m with a part of 0\.02 m"):
        Jaw(GRIPPER, opening=0.01, part_width=0.02)
    jaw = Jaw(GRIPPER, opening=0.01)
    with pytest.raises(PlantError, match=r"0\.03 m does not fit in an opening of 0\.0100 m"):
        jaw.put_part(0.03)

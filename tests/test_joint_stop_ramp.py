"""The controlled stop of one joint: decelerates, then holds where the joint came to rest."""

import pytest

from rfms_can.joint_nodes.stop_ramp import SETTLING_S, STILL_CYCLES, StopRamp

PERIOD = 0.004


def stopped() -> StopRamp:
    ramp = StopRamp(1.0, 0.5, 5.0, PERIOD)
    while ramp.speed:
        ramp.step()
    return ramp


def test_the_ramp_ends_where_constant_deceleration_does() -> None:
    assert stopped().position == pytest.approx(1.0 + 0.5**2 / (2 * 5.0), abs=1e-12)


def test_a_joint_that_stands_is_held_where_it_stands() -> None:
    ramp = stopped()
    for _ in range(STILL_CYCLES):
        ramp.watch(1.02)
    assert ramp.position == pytest.approx(1.025)
    ramp.watch(1.02)
    assert ramp.position == 1.02


def test_nothing_is_held_while_the_ramp_runs_or_the_joint_moves() -> None:
    ramp = StopRamp(1.0, 0.5, 5.0, PERIOD)
    for _ in range(2 * STILL_CYCLES):
        ramp.watch(0.9)
    assert ramp.position == 1.0
    ramp = stopped()
    for count in range(2 * STILL_CYCLES):
        ramp.watch(1.0 + 1e-4 * count)
    assert ramp.position == pytest.approx(1.025)


def test_once_settled_it_does_not_yield_to_a_push() -> None:
    ramp = stopped()
    for _ in range(round(SETTLING_S / PERIOD)):
        ramp.watch(1.02)
    for _ in range(100):
        ramp.watch(1.2)
    assert ramp.position == 1.02

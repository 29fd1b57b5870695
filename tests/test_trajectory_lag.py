"""A joint asked for a little more than it may lags behind, and comes up again."""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rfms_can.arm import PUMA_260
from rfms_can.master.trajectory.lag import KEPT, KEPT_SPEED, LARGEST, Lag

TAU = 0.004
SPEEDS = np.array(PUMA_260.speed_limits)
ACCELERATIONS = np.array(PUMA_260.acceleration_limits)


def followed(asked: npt.NDArray[np.float64]) -> tuple[npt.NDArray[np.float64], Lag]:
    """What is commanded for angles asked for, (n, 6) rad, from rest at the first."""
    lag = Lag(PUMA_260, TAU)
    lag.reset(asked[0].tolist())
    commanded = []
    for angles in asked:
        lag.follow(angles.tolist())
        commanded.append(angles + lag.angles)
    return np.array(commanded), lag


def ramp(factors: Sequence[float], cycles: int) -> npt.NDArray[np.float64]:
    """Each joint accelerates to a part of its speed limit with ``factors`` of its acceleration
    limit, goes on, and slows down as it started; then it rests for half a second."""
    rates = np.zeros((cycles + 126, 6))
    for k, factor in enumerate(factors):
        rate = 0.0
        for cycle in range(cycles):
            goal = 0.7 * SPEEDS[k] if cycle < cycles // 2 else 0.0
            most = factor * ACCELERATIONS[k] * TAU
            rate += min(max(goal - rate, -most), most)
            rates[cycle + 1, k] = rate
    return np.cumsum(rates, axis=0) * TAU


def test_within_the_limits_nothing_is_added() -> None:
    asked = ramp((1.0, 0.9, 0.5, 1.0, 0.2, 1.005), 400)
    commanded, lag = followed(asked)
    assert np.array_equal(commanded, asked)
    assert not lag.active


@settings(max_examples=60)
@given(st.tuples(*[st.floats(0.3, 1.4)] * 6), st.integers(100, 400))
def test_over_the_limits_it_keeps_them_and_comes_up(factors: tuple[float, ...], n: int) -> None:
    asked = ramp(factors, n)
    commanded, lag = followed(asked)
    bends = np.abs(np.diff(commanded, n=2, axis=0)).max(axis=0) / TAU**2
    assert np.all(bends <= KEPT * ACCELERATIONS * (1.0 + 1e-9))
    assert np.all(np.abs(np.diff(commanded, axis=0)).max(axis=0) <= KEPT_SPEED * SPEEDS * TAU)
    assert lag.joint_too_far is None
    assert commanded[-1] == pytest.approx(asked[-1], abs=1e-9)
    assert not lag.active


def test_a_step_of_speed_is_followed_without_overshoot() -> None:
    """What a correction does that begins at once: joint 1 is asked for 0.05 rad/s in one cycle."""
    asked = np.zeros((200, 6))
    asked[:, 0] = np.maximum(0.0, np.arange(200) - 20) * 0.05 * TAU
    commanded, lag = followed(asked)
    behind = commanded[:, 0] - asked[:, 0]
    assert behind.min() < -1e-5 and behind.max() < 1e-5
    assert not lag.active


def test_what_cannot_be_followed_is_told() -> None:
    asked = np.zeros((60, 6))
    asked[:, 3] = 0.5 * 3.0 * ACCELERATIONS[3] * (np.arange(60) * TAU) ** 2
    _, lag = followed(asked)
    assert lag.joint_too_far == 4
    assert math.fabs(lag.angles[3]) > LARGEST

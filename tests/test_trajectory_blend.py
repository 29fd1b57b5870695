"""Blend polynomials and end-point derivatives on their own."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from rfms_can.setpoint.blend import MatchingPolynomial, blend_parameter, stop_parameter
from rfms_can.setpoint.history import LONGEST, SHORTEST, SampleHistory, window_for

values = st.floats(-10.0, 10.0)


@given(st.tuples(values, values, values, values), st.floats(0.05, 1.0))
def test_a_matching_polynomial_starts_as_told_and_ends_in_nothing(
    difference: tuple[float, float, float, float], t_acc: float
) -> None:
    match = MatchingPolynomial.matching(difference, t_acc)
    assert match.derivatives(0.0, t_acc) == approx(difference, rel=1e-9, abs=1e-9)
    scale = max(map(abs, match.coefficients)) / (2.0 * t_acc) ** 3
    assert match.derivatives(1.0, t_acc) == approx((0.0,) * 4, abs=1e-12 * (1.0 + 1e3 * scale))
    assert match.at(1.0) == 0.0
    assert match.at(0.0) == difference[0]


@given(values, values, st.floats(0.05, 1.0), st.floats(0.0, 1.0))
def test_without_acceleration_and_jerk_the_two_blends_are_one(
    position: float, velocity: float, t_acc: float, p: float
) -> None:
    thesis = MatchingPolynomial.thesis(position, velocity, t_acc)
    assert thesis == MatchingPolynomial.matching((position, velocity, 0.0, 0.0), t_acc)
    a0, a1, a2, a3, a4, a5, a6, a7 = thesis.coefficients
    expected = (
        *(-20.0 * a1 - 35.0 * a0, 45.0 * a1 + 84.0 * a0),
        *(-36.0 * a1 - 70.0 * a0, 10.0 * a1 + 20.0 * a0),
    )
    assert (a2, a3) == approx((0.0, 0.0), abs=1e-12)
    assert (a4, a5, a6, a7) == approx(expected, abs=1e-9)


def test_a_stop_is_an_acceleration_run_backwards() -> None:
    for p in np.linspace(0.0, 1.0, 21):
        assert stop_parameter(p) == approx(1.0 - blend_parameter(1.0 - p), abs=1e-12)


def history_of(samples: list[float]) -> SampleHistory:
    history = SampleHistory()
    for sample in samples:
        history.push(sample)
    return history


@given(st.lists(values, min_size=5, max_size=5), st.integers(SHORTEST, LONGEST))
def test_a_full_history_tells_the_derivatives_of_a_quartic_now_and_one_ahead(
    coefficients: list[float], window: int
) -> None:
    tau = 0.1
    curve = np.polynomial.Polynomial(coefficients)
    history = history_of([curve(k * tau) for k in range(LONGEST + 3)])
    newest = (LONGEST + 2) * tau
    for time, derivatives in (
        (newest, history.at_newest(tau, window)),
        (newest + tau, history.one_ahead(tau, window)),
    ):
        expected = [curve(time), *(curve.deriv(order)(time) for order in (1, 2, 3))]
        assert derivatives == approx(expected, rel=1e-7, abs=1e-7)


@given(values, st.integers(1, LONGEST + 2))
def test_a_joint_at_rest_has_derivatives_of_exactly_zero(theta: float, count: int) -> None:
    history = history_of([theta] * count)
    assert history.at_newest(0.004) == (theta, 0.0, 0.0, 0.0)
    assert history.one_ahead(0.004) == (theta, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(("count", "known"), [(1, 1), (2, 2), (3, 3), (7, 3), (8, 4)])
def test_a_short_history_tells_as_many_derivatives_as_it_can(count: int, known: int) -> None:
    cubic = np.polynomial.Polynomial([0.3, -0.2, 0.5, 0.7][:known])
    tau = 0.01
    history = history_of([cubic(k * tau) for k in range(count)])
    expected = [
        cubic.deriv(n)((count - 1) * tau) if n else cubic((count - 1) * tau) for n in range(4)
    ]
    assert history.at_newest(tau) == approx(expected, abs=1e-6)


def test_float32_noise_stays_below_what_the_docstring_promises() -> None:
    rng = np.random.default_rng(1)
    tau, noise = 0.005, 3e-8
    found = np.array(
        [history_of(list(rng.normal(0.0, noise, SHORTEST))).one_ahead(tau) for _ in range(2000)]
    )
    assert np.std(found, axis=0) == approx([9.9e-8, 2.2e-5, 3.1e-3, 0.25], rel=0.1)


def test_the_window_is_half_the_acceleration_time_within_bounds() -> None:
    assert [window_for(ticks) for ticks in (1, 20, 40, 64, 256)] == [10, 10, 20, 32, 32]
    assert window_for(257) == LONGEST


def test_a_missing_sample_is_filled_in_evenly() -> None:
    history = history_of([0.1 * k for k in range(6)])
    history.extrapolate()
    assert len(history) == 7
    assert history.newest == approx(0.6)
    assert history.at_newest(1.0) == approx((0.6, 0.1, 0.0, 0.0), abs=1e-9)
    lone = history_of([0.25])
    lone.extrapolate()
    assert lone.at_newest(1.0) == (0.25, 0.0, 0.0, 0.0)
    nothing = history_of([])
    nothing.extrapolate()
    assert len(nothing) == 0

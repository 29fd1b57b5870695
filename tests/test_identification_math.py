"""The mathematics of identification: double sums, least squares, observability, verdicts."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfms_can.arm import PUMA_260, PUMA_560, Arm
from rfms_can.dynamics.fitted import fitted_constants
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.dynamics.simplified import SimplifiedDynamics
from rfms_can.identification.fit.configurations import (
    BETTER_4_29,
    CORRECTED_4_2,
    CORRECTED_4_29,
    PRINTED_4_29,
    TABLE_4_2,
    equation_of,
    first_joint,
)
from rfms_can.identification.fit.least_squares import IdentificationError, solve
from rfms_can.identification.fit.links import smoothed
from rfms_can.identification.fit.momentum import printed_sum, twice
from rfms_can.identification.fit.significance import (
    fine_motion,
    gross_motion,
    significance,
    velocity_torque,
)
from rfms_can.identification.fit.truth import (
    THESIS_OZ_IN,
    VERDICTS,
    identities,
    thesis_constants,
    truth_of,
)
from rfms_can.plant.variant import make_variant

TRUTH = truth_of(make_variant("table41", PUMA_560, "corke")).constants


@pytest.mark.parametrize("n", [10, 50, 200])
def test_the_printed_double_sum_is_too_large_by_1_plus_3_over_n(n: int) -> None:
    """A constant torque from rest: W is tau t^2 / 2."""
    period, torque = 0.02, 1.7
    exact = torque * (n * period) ** 2 / 2.0
    printed = printed_sum(np.full(n + 1, torque), period)
    assert printed / exact == pytest.approx((n + 1) * (n + 2) / n**2, rel=1e-12)
    assert printed / exact - 1.0 == pytest.approx(3.0 / n, rel=0.1)
    assert twice(np.full(n + 1, torque), period)[-1] == pytest.approx(exact, rel=1e-12)


@given(st.lists(st.floats(-100.0, 100.0), min_size=1, max_size=60))
def test_held_torques_are_integrated_exactly(torques: list[float]) -> None:
    """Against the motion of a unit inertia under them, step by step."""
    period, speed, place = 0.01, 0.0, 0.0
    for torque in torques:
        place += speed * period + 0.5 * torque * period**2
        speed += torque * period
    assert twice(np.array([0.0, *torques]), period)[-1] == pytest.approx(place, abs=1e-9)


def test_least_squares_gives_values_and_honest_deviations() -> None:
    draw = np.random.default_rng(3)
    matrix = draw.normal(size=(200, 3))
    true = np.array([3.0, -1.0, 0.5])
    scores = []
    for _ in range(100):
        fit = solve(("a", "b", "c"), matrix, matrix @ true + draw.normal(0.0, 0.4, 200), "x")
        scores += [
            (fit.values[k] - t) / fit.deviations[k] for k, t in zip("abc", true, strict=True)
        ]
    assert np.std(scores) == pytest.approx(1.0, abs=0.1)
    assert fit.residual == pytest.approx(0.4, rel=0.15)


def test_what_equations_do_not_tell_apart_is_named() -> None:
    matrix = np.array([[1.0, 2.0, 0.0], [2.0, 4.0, 1.0], [3.0, 6.0, 5.0], [1.0, 2.0, 7.0]])
    with pytest.raises(IdentificationError, match="do not distinguish a, b: rank 2 of 3"):
        solve(("a", "b", "c"), matrix, np.ones(4), "x")
    with pytest.raises(IdentificationError, match="2 equations for 3 unknowns"):
        solve(("a", "b", "c"), matrix[:2], np.ones(2), "x")


def test_equation_4_29_as_printed_does_not_see_b15() -> None:
    printed, corrected, better = map(first_joint, (PRINTED_4_29, CORRECTED_4_29, BETTER_4_29))
    assert (printed.rank, printed.unknowns) == (5, 6)
    assert corrected.rank == better.rank == 6
    assert corrected.condition == pytest.approx(23.0, abs=0.5)
    assert better.condition == pytest.approx(5.1, abs=0.1)


def test_two_equations_of_table_4_2_have_a_wrong_sign() -> None:
    wrong = [
        number
        for number, row in enumerate(TABLE_4_2, start=1)
        if equation_of(row) != pytest.approx(row.printed)
    ]
    assert wrong == [6, 8]
    assert equation_of(TABLE_4_2[5]) == {"c21": -1.0, "c31": 1.0}
    assert equation_of(TABLE_4_2[7]) == {"c50": 1.0}
    corrected = TABLE_4_2[5]._replace(angles_deg=CORRECTED_4_2[5])
    assert equation_of(corrected) == TABLE_4_2[5].printed


def test_every_figure_of_the_thesis_has_a_verdict_with_a_reason() -> None:
    assert VERDICTS.keys() == THESIS_OZ_IN.keys()
    impossible = {name for name, verdict in VERDICTS.items() if verdict.word == "impossible"}
    assert impossible == {"b12", "b13", "b15", "b25", "b31"}
    assert all(VERDICTS[name].why for name in impossible)


def test_the_plant_keeps_the_identities_the_thesis_breaks() -> None:
    for identity in identities(PUMA_560, TRUTH):
        size = max(abs(identity.value), abs(identity.expected))
        assert abs(identity.value - identity.expected) < 0.02 * size + 3e-3, identity
    broken = {
        (identity.name, identity.equals)
        for identity in identities(PUMA_560, thesis_constants())
        if not 0.5 < identity.value / identity.expected < 2.0
    }
    assert broken == {
        ("b13", "b25"),
        ("b25", "2 a2 c31 / g"),
        ("b26", "2 a2 c32 / g"),
        ("b31", "-2 d4 c50 / g"),
    }


def test_the_sign_of_b12_is_that_of_no_arm() -> None:
    """Stretched out (C23 = 0) an arm must turn harder than with its forearm upright."""
    assert TRUTH["b12"] < 0.0 < thesis_constants()["b12"]


@pytest.mark.parametrize("order", [0, 1, 2])
def test_local_polynomials_are_exact_for_cubics(order: int) -> None:
    time = 0.004 * np.arange(60)
    cubic = np.polynomial.Polynomial([0.3, -1.0, 4.0, 9.0])
    values = cubic(time)[:, None]
    wanted = cubic.deriv(order)(time) if order else cubic(time)
    found = smoothed(values, 0.004, order)[:, 0]
    np.testing.assert_allclose(found, wanted[6:-6], rtol=1e-6)


@pytest.mark.parametrize("arm", [PUMA_260, PUMA_560], ids=lambda arm: arm.name)
def test_significance_argues_as_the_thesis_does(arm: Arm) -> None:
    """Without velocity terms a fine motion loses next to nothing, a gross one a part."""
    constants = fitted_constants(ArmDynamics(arm))
    whole, slow, _, simple, gravity = significance(arm, constants)
    assert whole.gross == whole.fine == 0.0
    assert slow.fine < 0.02 < slow.gross
    assert all(model.microseconds > 0.0 for model in (whole, simple))  # "rfms identify" prints it
    assert gravity.fine > simple.fine
    for path in (gross_motion(arm), fine_motion(arm)):
        limits = np.array(arm.acceleration_limits)
        assert (np.abs(path.qdd).max(axis=0) <= limits).all()
        assert (np.abs(path.qd).max(axis=0) <= np.array(arm.speed_limits)).all()


def test_velocity_terms_of_the_simplified_model_do_no_work_of_their_own() -> None:
    """M' - 2 C is skew: qd (M' qd / 2 - C qd) = 0."""
    simple = SimplifiedDynamics(PUMA_560, TRUTH)
    draw = np.random.default_rng(2)
    for _ in range(20):
        q, qd = draw.uniform(-2.0, 2.0, 6), draw.uniform(-1.0, 1.0, 6)
        step = 1e-6
        simple.update((q + step * qd).tolist())
        ahead = simple.M.copy()
        simple.update((q - step * qd).tolist())
        growth = (ahead - simple.M) / (2.0 * step)
        power = float(qd @ velocity_torque(simple, q, qd))
        assert power == pytest.approx(0.5 * float(qd @ growth @ qd), abs=1e-6)
        assert math.isfinite(power)

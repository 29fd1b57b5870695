"""The thesis' blend against trajectories of an independent implementation, tick by tick."""

import pytest
from pytest import approx
from support.golden import golden
from support.trajectory import golden_rig

from rfms_can.setpoint.blend import MatchingPolynomial, segment_derivatives
from rfms_can.wire.vocabulary import Blend

POLYNOMIALS = golden("polynomials")


@pytest.mark.parametrize("name", ["static", "tracking"])
def test_every_tick_of_the_golden_trajectory(name: str) -> None:
    rig, rows = golden_rig(name, Blend.THESIS)
    assert len(rows) == 824
    for k, state, mode, n, h, r, p, q in rows:
        assert rig.tick() == approx(q, abs=1e-10), f"tick {k}"
        setpoint = rig.setpoints[-1]
        assert setpoint.state.name == state
        if state == "IDLE":
            continue
        assert setpoint.mode.name[0] == mode
        assert setpoint.n == n
        assert (setpoint.h, setpoint.r, setpoint.p) == approx((h, r, p or 0.0), abs=1e-11)
    assert rig.generator.completed == 3


@pytest.mark.parametrize("name", ["static", "tracking"])
def test_float32_on_the_wire_costs_a_microradian(name: str) -> None:
    rig, rows = golden_rig(name, Blend.THESIS, wire=True)
    assert max(
        abs(theta - reference)
        for row in rows
        for theta, reference in zip(rig.tick(), row[7], strict=True)
    ) < (1e-5)


def test_the_default_blend_differs_only_where_acceleration_or_jerk_was_left_behind() -> None:
    rig, rows = golden_rig("static", Blend.CONTINUOUS)
    for k, *_, q in rows:
        theta = rig.tick()
        if k < 501:  # rest, joint segment to Cartesian: nothing to match but position and rate
            assert theta == approx(q, abs=1e-10)
    largest = max(
        abs(a - b)
        for mine, row in zip(rig.q[501:], rows[501:], strict=True)
        for a, b in zip(mine, row[7], strict=True)
    )
    assert 1e-4 < largest < 5e-3  # the acceleration of up to 0.55 rad/s2 that is now blended out
    assert rig.q[-1] == approx(rows[-1][7], abs=1e-10)


@pytest.mark.parametrize("case", POLYNOMIALS["h"])
def test_the_segment_parameter_and_its_derivatives(case: dict[str, object]) -> None:
    t_acc, t_seg, rows = case["tacc"], case["tseg"], case["rows"]
    assert isinstance(t_acc, float) and isinstance(t_seg, float) and isinstance(rows, list)
    for t, _, *expected in rows:
        assert segment_derivatives(t, t_acc, t_seg) == approx(expected, rel=1e-9, abs=1e-9)
    assert segment_derivatives(t_seg, t_acc, t_seg) == approx((1.0, 1.0 / t_seg, 0.0, 0.0))


@pytest.mark.parametrize("case", POLYNOMIALS["matching"])
def test_the_thesis_matching_polynomial(case: dict[str, float]) -> None:
    t_acc = case["tacc"]
    match = MatchingPolynomial.thesis(case["dtheta_AB"], case["dthetadot_AC"], t_acc)
    expected: dict[str, float] = case["a"]  # type: ignore[assignment]
    for name, coefficient in expected.items():
        assert match.coefficients[int(name[1])] == approx(coefficient, rel=1e-9, abs=1e-9)
    rows: list[list[float]] = case["rows"]  # type: ignore[assignment]
    for _, p, *derivatives in rows:
        assert match.at(p) == approx(derivatives[0], abs=1e-9)
        assert match.derivatives(p, t_acc) == approx(derivatives, rel=1e-9, abs=1e-9)

"""Loops and poles: what a projector, damping, scheduling and the bus make of them."""

from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from rfms_can.analysis.stability import (
    Analyst,
    ControlLaw,
    Loop,
    Study,
    Verdict,
    gain_margin,
    growth,
    is_stable,
    largest_frequency,
    sampled_matrix,
    sampled_poles,
    scheduled_loop,
    state_matrix,
    verdict,
    weighted_loop,
)
from rfms_can.analysis.stability.sampled import matrix_exponential
from rfms_can.arm import PUMA_260, PUMA_560
from rfms_can.compliance import Selection, compliance_jacobian, hybrid_rows, regular_pose
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.errors import ArmError, RfmsError
from rfms_can.transform import Transform

Matrix = NDArray[np.float64]
PEG = Selection.parse("fx fy rx ry")
TOOL = Transform.translation(0.0, 0.0, 0.2)
MIXED = (10.0, 10.0, 10.0, 40.0, 40.0, 40.0)


def study(**changes: object) -> Study:
    values: dict[str, object] = {"arm": PUMA_560, "selection": PEG, "frame": TOOL, **changes}
    return Study(**values)  # type: ignore[arg-type]


@given(
    st.tuples(*[st.floats(-pi, pi)] * 6),
    st.tuples(*[st.booleans()] * 6),
    st.floats(0.0, 0.3),
    st.floats(0.3, 2.0),
    st.floats(0.5, 20.0),
)
def test_weighted_poles_depend_on_nothing(
    q: tuple[float, ...], selected: tuple[bool, ...], tool: float, zeta: float, mu: float
) -> None:
    """(s^2 + 2 zeta wn s + wn^2)^(6-n) (s (s + mu))^n, whatever arm, pose, word and frame."""
    selection, wn = Selection.of(selected), 20.0
    dynamics = ArmDynamics(PUMA_260)
    dynamics.update(regular_pose(PUMA_260, q))
    J = compliance_jacobian(dynamics.J, Transform.translation(0.0, 0.0, tool))
    C, M = hybrid_rows(J, selection, dynamics.M).errors, dynamics.M
    loop = weighted_loop(M, M, C, wn, zeta, selection.size, compliant_rate=mu)
    n = selection.size
    A = state_matrix(loop)
    for s in (1.0 + 2.0j, -5.0 + 0.5j, 30.0j):
        ours = np.linalg.det(A - s * np.eye(12))
        expected = (s * s + 2.0 * zeta * wn * s + wn * wn) ** (6 - n) * (s * (s + mu)) ** n
        assert ours == pytest.approx(expected, rel=1e-5)
    assert verdict(loop) is Verdict.STABLE


def test_without_damping_compliant_directions_drift() -> None:
    """The thesis calls it stable in the sense of Lyapunov; 0.01 rad/s is 0.1 rad after 10 s."""
    q = PUMA_560.park
    bare = Analyst(study(law=ControlLaw.WEIGHTED)).analyse(q)
    braked = Analyst(study(law=ControlLaw.WEIGHTED, compliant_rate=5.0)).analyse(q)
    rubbed = Analyst(study(law=ControlLaw.WEIGHTED, friction="corke")).analyse(q)
    assert bare.verdict is Verdict.DRIFTS
    assert np.count_nonzero(bare.poles == 0.0) == 2 * PEG.size
    assert braked.verdict is rubbed.verdict is Verdict.STABLE
    assert np.count_nonzero(braked.poles == 0.0) == PEG.size
    loop = Analyst(study(law=ControlLaw.WEIGHTED)).loop(q)
    _, free = loop.bases
    pushed = np.concatenate([np.zeros(6), 0.01 * free[:, 0]])
    after = matrix_exponential(state_matrix(loop) * 10.0) @ pushed
    assert np.linalg.norm(after[:6]) == pytest.approx(0.1, rel=1e-6)


def test_position_control_is_each_joint_alone() -> None:
    """(5.25) with the thesis' plant: all poles at -wn, word or not."""
    asked = study(law=ControlLaw.POSITION, diagonal=True, natural=MIXED)
    analysis = Analyst(asked).analyse(PUMA_560.park)
    np.testing.assert_allclose(analysis.poles.real, np.repeat([-40.0, -10.0], 6), atol=1e-3)
    assert analysis.verdict is Verdict.STABLE


def test_mixed_gains_and_a_tool_are_unstable_similar_ones_are_not() -> None:
    q, free = (0.3, 0.4, -2.0, 0.2, 0.9, 0.1), Selection.parse("rx ry rz")
    unstable = Analyst(study(selection=free, natural=MIXED)).analyse(q)
    assert unstable.verdict is Verdict.UNSTABLE
    assert not unstable.sampled_stable
    weighted = Analyst(study(selection=free, law=ControlLaw.WEIGHTED)).analyse(q)
    assert weighted.verdict is Verdict.DRIFTS
    assert weighted.sampled_stable
    at_the_wrist = study(selection=free, natural=MIXED, frame=Transform.identity(), diagonal=True)
    assert growth(Analyst(at_the_wrist).analyse(q).poles) == 0.0


def test_scheduled_gains_cannot_hold_a_stiffness_that_pushes_away() -> None:
    """A negative eigenvalue of M^-1 K is a pole to the right of 0 at any damping."""
    M, C = np.eye(6), np.eye(6)
    stiffness = np.diag([100.0, -4.0, 100.0, 100.0, 100.0, 100.0])
    loop = Loop(M, stiffness, 20.0 * C, np.zeros((6, 6)), 0)
    for factor in (0.1, 1.0, 10.0):
        assert verdict(scheduled_loop(loop, factor)) is Verdict.UNSTABLE


def test_scheduled_gains_are_those_of_5_13() -> None:
    loop = Analyst(study()).loop(PUMA_560.park)
    damping = scheduled_loop(loop, 0.9).damping
    expected = [0.9 * sum(abs(k) for k in row) ** 0.5 for row in loop.stiffness.tolist()]
    np.testing.assert_allclose(damping, np.diag(expected), rtol=1e-12)


@pytest.mark.parametrize("size", [0.0, 1e-3, 1.0, 50.0])
def test_the_exponential_against_eigenvalues(size: float) -> None:
    A = size * np.array([[-1.0, 2.0, 0.3], [0.1, -0.5, 0.0], [0.4, 0.2, -2.0]])
    values, vectors = np.linalg.eig(A)
    expected = (vectors @ np.diag(np.exp(values)) @ np.linalg.inv(vectors)).real
    np.testing.assert_allclose(matrix_exponential(A), expected, rtol=1e-10, atol=1e-12)


def test_the_exponential_of_a_double_integrator_is_a_polynomial() -> None:
    A = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])
    expected = [[1.0, 0.1, 0.01], [0.0, 1.0, 0.2], [0.0, 0.0, 1.0]]
    np.testing.assert_allclose(matrix_exponential(0.1 * A), expected, rtol=1e-14)


def fine_simulation(loop: Loop, period: float, start: Matrix, cycles: int) -> Matrix:
    """Angles and rates at every SYNC: the torque computed of SYNC k acts from k+1 to k+2.

    Runge-Kutta with small steps in between: shares nothing with the model but the loop.
    """
    inverse = np.linalg.inv(loop.inertia)
    q, v, torque = start[:6].copy(), start[6:].copy(), np.zeros(6)
    steps, seen = 20, [start]
    h = period / steps

    def acceleration(v: Matrix, torque: Matrix) -> Matrix:
        result: Matrix = inverse @ (torque - loop.friction @ v)
        return result

    for _ in range(cycles):
        following = -loop.stiffness @ q - loop.damping @ v
        for _ in range(steps):
            a1 = acceleration(v, torque)
            a2 = acceleration(v + 0.5 * h * a1, torque)
            a3 = acceleration(v + 0.5 * h * a2, torque)
            a4 = acceleration(v + h * a3, torque)
            q = q + h * v + h * h / 6.0 * (a1 + a2 + a3)
            v = v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        torque = following
        seen.append(np.concatenate([q, v]))
    return np.array(seen)


@pytest.mark.parametrize("law", [ControlLaw.HYBRID, ControlLaw.WEIGHTED, ControlLaw.STIFFNESS])
@pytest.mark.parametrize("friction", ["none", "corke"])
def test_the_sampled_model_is_the_simulated_loop(law: ControlLaw, friction: str) -> None:
    loop = Analyst(study(law=law, friction=friction, compliant_rate=3.0)).loop(PUMA_560.park)
    start = np.array([0.01, -0.02, 0.015, 0.02, -0.01, 0.005, *[0.0] * 6])
    simulated = fine_simulation(loop, 0.004, start, 50)
    step, state = sampled_matrix(loop, 0.004), np.concatenate([start, np.zeros(6)])
    for k in range(51):
        np.testing.assert_allclose(state[:12], simulated[k], rtol=0, atol=1e-8)
        state = step @ state
    whole = np.linalg.eigvals(step)
    size = np.abs(sampled_poles(loop, 0.004)).max()
    assert size == pytest.approx(max(1.0, np.abs(whole).max()), abs=1e-6)


def test_the_bound_of_the_sampled_loop_is_where_a_simulation_begins_to_grow() -> None:
    """One joint of inertia 1, natural frequency two percent below and above the bound."""
    period = 0.004
    bound = largest_frequency(period, 0.7)
    sizes = []
    for wn in (0.98 * bound, 1.02 * bound):
        loop = weighted_loop(np.eye(6), np.eye(6), np.eye(6), wn, 0.7, 0)
        start = np.array([0.01] * 6 + [0.0] * 6)
        path = np.abs(fine_simulation(loop, period, start, 1500)[:, 0])
        sizes.append(path[-100:].max() / path[:100].max())
    assert sizes[0] < 0.5
    assert sizes[1] > 2.0


def test_the_weighted_law_is_bounded_like_a_joint_alone_anywhere() -> None:
    for q in (PUMA_560.park, (0.3, 0.4, -2.0, 0.2, 0.9, 0.1)):
        analyst = Analyst(study(law=ControlLaw.WEIGHTED))
        margin = gain_margin(analyst.loop(q), 0.004) * float(analyst.natural[0])
        assert margin == pytest.approx(largest_frequency(0.004), rel=1e-3)
    assert largest_frequency(0.004) == pytest.approx(106.54, abs=0.01)
    assert largest_frequency(0.002) == pytest.approx(2.0 * largest_frequency(0.004), rel=1e-6)


def test_the_nodes_own_gains_have_margin() -> None:
    """Natural frequency 30 rad/s at 250 Hz: three and a half times is the end."""
    analysis = Analyst(study(law=ControlLaw.WEIGHTED)).analyse(PUMA_560.park, margin=True)
    assert analysis.margin == pytest.approx(3.55, abs=0.01)
    assert is_stable(analysis.sampled)
    fast = Analyst(study(law=ControlLaw.WEIGHTED, natural=(110.0,) * 6)).analyse(PUMA_560.park)
    assert not fast.sampled_stable
    assert fast.verdict is Verdict.DRIFTS  # the continuous model knows nothing of it


@pytest.mark.parametrize("law", list(ControlLaw))
def test_every_law_has_twelve_and_eighteen_poles(law: ControlLaw) -> None:
    analysis = Analyst(study(law=law)).analyse(PUMA_560.park)
    assert analysis.poles.shape == (12,)
    assert analysis.sampled.shape == (18,)
    expected = 0 if law is ControlLaw.POSITION else PEG.size
    assert np.count_nonzero(analysis.poles == 0.0) >= expected


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"natural": (1.0, 2.0)}, "give six"),
        ({"natural": (0.0,) * 6}, "0.01 to 10000"),
        ({"natural": MIXED, "law": ControlLaw.WEIGHTED}, "one natural frequency"),
        ({"rate_hz": 0.0}, "rate 0 is not in"),
        ({"damping_ratio": float("nan")}, "damping ratio nan"),
        ({"compliant_rate": -1.0}, "compliant damping -1"),
    ],
)
def test_impossible_studies_are_refused(changes: dict[str, object], complaint: str) -> None:
    with pytest.raises(RfmsError, match=complaint):
        study(**changes)
    with pytest.raises(ArmError, match="friction set"):
        study(friction="ice")


def test_conflicts_are_reported_near_a_singularity() -> None:
    near = Analyst(study(selection=Selection.parse("rx"))).analyse((0.1, 1.4, -3.0, 0.8, 0.0, 0.4))
    (conflict,) = near.conflicts
    assert conflict.startswith("comply rx: near a singularity")
    assert Analyst(study()).analyse(PUMA_560.park).conflicts == ()

"""What the hand feels: readings without weight and bias; guesses from torques, and how sure."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfms_can.arm import PUMA_260, PUMA_560, Load, friction_set
from rfms_can.arm.load import NOTHING
from rfms_can.dynamics.model import make_dynamics
from rfms_can.kinematics import Joints, direct
from rfms_can.master.force.specification import NO_FORCE
from rfms_can.master.force.wrench import weight
from rfms_can.master.force.wrench_estimate import TARE_CYCLES, WrenchEstimate
from rfms_can.transform import Transform

T = 0.004
FRICTION = friction_set(PUMA_560, "corke")
NONE = friction_set(PUMA_560, "none")
q6 = st.tuples(*[st.floats(-2.5, 2.5)] * 6)
six = st.tuples(*[st.floats(-30.0, 30.0)] * 6)


def reading(
    pushed: tuple[float, ...], load: Load, q: Joints, off: tuple[float, ...]
) -> list[float]:
    """What a sensor between hand and tool says: it carries the tool, and is off."""
    carried = weight(load, direct(PUMA_560, q))
    return [p - w + o for p, w, o in zip(pushed, carried, off, strict=True)]


# --- with a sensor -----------------------------------------------------------------------------


@given(q6, q6, st.floats(0.0, 5.0), st.tuples(*[st.floats(-0.2, 0.2)] * 3), six, six)
def test_tared_anywhere_it_feels_what_is_touched_anywhere_else(
    at: Joints,
    later: Joints,
    mass: float,
    centre: tuple[float, float, float],
    off: tuple[float, ...],
    pushed: tuple[float, ...],
) -> None:
    """The weight turns with the hand; the bias does not. Both are taken out, and nothing else."""
    load, estimate = Load(mass, centre), WrenchEstimate(FRICTION, T)
    estimate.tare()
    for _ in range(TARE_CYCLES):
        assert estimate.taring
        estimate.read(reading(NO_FORCE, load, at, off), load, direct(PUMA_560, at))
    assert not estimate.taring
    assert estimate.wrench == pytest.approx(NO_FORCE, abs=1e-10)
    estimate.read(reading(pushed, load, later, off), load, direct(PUMA_560, later))
    assert estimate.wrench == pytest.approx(pushed, abs=1e-9)
    assert estimate.sensed


def test_a_tare_is_the_mean_of_its_readings() -> None:
    estimate, rng = WrenchEstimate(FRICTION, T), np.random.default_rng(2)
    noise = rng.normal(0.0, 0.5, size=(TARE_CYCLES, 6))
    estimate.tare()
    for values in noise.tolist():
        estimate.read(values, NOTHING, direct(PUMA_560, PUMA_560.park))
    estimate.read([0.0] * 6, NOTHING, direct(PUMA_560, PUMA_560.park))
    assert estimate.wrench == pytest.approx((-noise.mean(axis=0)).tolist())


def test_another_tare_forgets_the_first() -> None:
    estimate, T6 = WrenchEstimate(FRICTION, T), direct(PUMA_560, PUMA_560.park)
    for off in (3.0, -2.0):
        estimate.tare()
        for _ in range(TARE_CYCLES):
            estimate.read([off] * 6, NOTHING, T6)
        estimate.read([off + 1.0] * 6, NOTHING, T6)
        assert estimate.wrench == pytest.approx((1.0,) * 6)


# --- without one -------------------------------------------------------------------------------


@given(six, st.tuples(*[st.floats(-2.0, 2.0)] * 6), st.tuples(*[st.floats(-5.0, 5.0)] * 6))
def test_a_guess_is_exact_where_there_is_no_friction(
    pushed: tuple[float, ...], rates: tuple[float, ...], accelerations: tuple[float, ...]
) -> None:
    dynamics = make_dynamics(PUMA_560, "full")
    dynamics.update((0.3, 0.4, -2.0, 0.2, 0.9, 0.1))
    J, M, g = dynamics.J, dynamics.M, dynamics.g
    torques = J.T @ pushed + g + M @ accelerations
    estimate = WrenchEstimate(NONE, T)
    for _ in range(300):
        estimate.estimate(torques.tolist(), rates, accelerations, J, M, g)
    assert estimate.wrench == pytest.approx(pushed, abs=1e-7)
    assert not estimate.sensed


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_known_friction_of_moving_joints_is_no_force(sign: float) -> None:
    dynamics = make_dynamics(PUMA_560, "full")
    dynamics.update(PUMA_560.park)
    J, M, g = dynamics.J, dynamics.M, dynamics.g
    rates = np.array([0.5, -0.2, 0.3, 0.1, -0.4, 0.2]) * sign
    rubs = [
        f.viscous * w + (f.coulomb_positive if w > 0 else -f.coulomb_negative)
        for f, w in zip(FRICTION, rates, strict=True)
    ]
    estimate = WrenchEstimate(FRICTION, T)
    estimate.estimate((g + rubs).tolist(), rates.tolist(), NO_FORCE, J, M, g)
    assert estimate.wrench == pytest.approx(NO_FORCE, abs=1e-9)


@given(st.tuples(*[st.floats(-1.0, 1.0)] * 6))
def test_what_rests_hides_no_more_than_the_uncertainty_says(share: tuple[float, ...]) -> None:
    """Any friction torque within the stiction of resting joints looks like a force within it."""
    dynamics = make_dynamics(PUMA_260, "full")
    dynamics.update((0.3, 1.2, -2.9, 0.4, -0.9, 0.2))
    J, M, g = dynamics.J, dynamics.M, dynamics.g
    friction = friction_set(PUMA_260, "corke")
    estimate = WrenchEstimate(friction, T)
    size = [max(f.coulomb_positive, f.coulomb_negative) for f in friction]
    hidden = np.array(size) * share
    for _ in range(300):
        estimate.estimate((g + hidden).tolist(), NO_FORCE, NO_FORCE, J, M, g)
    assert (
        np.abs(estimate.wrench)
        <= estimate.friction_uncertainty(J, Transform.identity()) * (1.0 + 1e-9)
    ).all()


def test_the_uncertainty_is_reached() -> None:
    """The worst signs give it, direction by direction: the bound is none too many."""
    dynamics = make_dynamics(PUMA_260, "full")
    dynamics.update((0.3, 1.2, -2.9, 0.4, -0.9, 0.2))
    J = dynamics.J
    estimate = WrenchEstimate(friction_set(PUMA_260, "corke"), T)
    size = [max(f.coulomb_positive, f.coulomb_negative) for f in friction_set(PUMA_260, "corke")]
    inverse = np.linalg.inv(J.T)
    worst = [float(inverse[i] @ (np.sign(inverse[i]) * size)) for i in range(6)]
    assert estimate.friction_uncertainty(J, Transform.identity()).tolist() == pytest.approx(
        worst, rel=1e-6
    )


def test_a_guess_is_filtered_and_forgotten_with_the_move_it_was_for() -> None:
    dynamics = make_dynamics(PUMA_560, "full")
    dynamics.update(PUMA_560.park)
    J, M, g = dynamics.J, dynamics.M, dynamics.g
    torques = (J.T @ [0.0, 0.0, 30.0, 0.0, 0.0, 0.0] + g).tolist()
    estimate = WrenchEstimate(NONE, T)
    estimate.estimate(torques, NO_FORCE, NO_FORCE, J, M, g)
    assert estimate.wrench[2] == pytest.approx(30.0 * 0.004 / 0.044)
    for _ in range(300):
        estimate.estimate(torques, NO_FORCE, NO_FORCE, J, M, g)
    estimate.discard()
    assert estimate.wrench == NO_FORCE
    estimate.estimate(g.tolist(), NO_FORCE, NO_FORCE, J, M, g)
    assert estimate.wrench == pytest.approx(NO_FORCE, abs=1e-9)


def test_what_a_sensor_has_read_is_not_forgotten() -> None:
    estimate = WrenchEstimate(NONE, T)
    estimate.read([1.0] * 6, NOTHING, direct(PUMA_560, PUMA_560.park))
    estimate.discard()
    assert estimate.wrench == (1.0,) * 6

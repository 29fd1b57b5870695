"""Dry friction that sticks: the boxed problem against an exact oracle, and what joints feel."""

from itertools import product

import numpy as np
import numpy.typing as npt
import pytest

from rfms_can.arm import JOINT_COUNT, PUMA_260, PUMA_560, Arm, JointFriction
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.errors import PlantError
from rfms_can.plant.arm_model import NO_BRAKES, ArmModel
from rfms_can.plant.friction import DryFriction

Array = npt.NDArray[np.float64]
FREE_RANGE = ((-1e9, 1e9),) * JOINT_COUNT
ALL_BRAKES = (True,) * JOINT_COUNT


def random_problem(seed: int) -> tuple[Array, Array, list[JointFriction]]:
    """A response matrix W (symmetric, positive definite), speeds v* and friction bounds."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(JOINT_COUNT, JOINT_COUNT))
    W = 1e-3 * (root @ root.T + 0.3 * np.eye(JOINT_COUNT))
    bounds = rng.uniform(0.0, 3.0, size=(JOINT_COUNT, 2))
    friction = [JointFriction(float(low), float(high), 0.0) for low, high in bounds]
    return W, rng.normal(scale=5e-3, size=JOINT_COUNT), friction


def oracle(W: Array, v_star: Array, friction: list[JointFriction]) -> Array:
    """Try all 3^6 cases (slip up, slip down, stick) for the one that satisfies every law."""
    for case in product((-1, 0, 1), repeat=JOINT_COUNT):
        signs = np.array(case)
        p = np.array(
            [
                -f.coulomb_positive if s > 0 else f.coulomb_negative
                for f, s in zip(friction, case, strict=True)
            ]
        )
        stuck = signs == 0
        p[stuck] = 0.0
        if stuck.any():
            p[stuck] = np.linalg.solve(W[np.ix_(stuck, stuck)], -(v_star + W @ p)[stuck])
        v: Array = v_star + W @ p
        inside = all(
            -f.coulomb_positive <= p[i] <= f.coulomb_negative for i, f in enumerate(friction)
        )
        if inside and (v[~stuck] * signs[~stuck] > 0.0).all():
            return v
    raise AssertionError("no case satisfies the friction laws")


def solved(W: Array, v_star: Array, friction: list[JointFriction]) -> tuple[Array, DryFriction]:
    dry = DryFriction(friction, (0.0,) * JOINT_COUNT, FREE_RANGE, 1e-3)
    dry.prepare(W.tolist(), NO_BRAKES)
    speed, q = v_star.tolist(), [0.0] * JOINT_COUNT
    dry.advance(speed, q)
    assert q == pytest.approx([1e-3 * v for v in speed])
    return np.array(speed), dry


@pytest.mark.parametrize("seed", range(25))
def test_sweeps_find_what_trying_every_case_finds(seed: int) -> None:
    W, v_star, friction = random_problem(seed)
    v, dry = solved(W, v_star, friction)
    np.testing.assert_allclose(v, oracle(W, v_star, friction), rtol=0, atol=1e-9)
    np.testing.assert_allclose(v, v_star + W @ np.array(dry.torque), rtol=0, atol=1e-9)


@pytest.mark.parametrize("seed", range(25))
def test_friction_never_adds_kinetic_energy(seed: int) -> None:
    W, v_star, friction = random_problem(seed)
    v, _ = solved(W, v_star, friction)
    assert v @ np.linalg.solve(W, v) <= v_star @ np.linalg.solve(W, v_star) * (1 + 1e-12)


@pytest.mark.parametrize("seed", range(25))
def test_near_its_stops_every_joint_obeys_friction_or_stop(seed: int) -> None:
    """Ranges of the size of one step: some joints reach a stop, some stick, some slide."""
    step_s, W, v_star, friction = 1e-3, *random_problem(seed)
    rng = np.random.default_rng(1000 + seed)
    limits = [(-float(low), float(up)) for low, up in rng.uniform(0.0, 3e-6, size=(JOINT_COUNT, 2))]
    limits[0] = (-5e-324, 1.0)  # as good as on its stop
    dry = DryFriction(friction, (0.0,) * JOINT_COUNT, limits, step_s)
    dry.prepare(W.tolist(), NO_BRAKES)
    v, q = v_star.tolist(), [0.0] * JOINT_COUNT
    dry.advance(v, q)
    torque = np.linalg.solve(W, np.array(v) - v_star)
    for i, (f, (lower, upper)) in enumerate(zip(friction, limits, strict=True)):
        assert lower <= q[i] <= upper
        low, high = -f.coulomb_positive, f.coulomb_negative
        if torque[i] < low - 1e-6:
            assert v[i] == pytest.approx(upper / step_s, abs=1e-9)
        elif torque[i] > high + 1e-6:
            assert v[i] == pytest.approx(lower / step_s, abs=1e-9)
        elif v[i] != 0.0:
            assert torque[i] == pytest.approx(low if v[i] > 0.0 else high, abs=1e-6)


def test_a_matrix_that_is_no_inertia_is_refused() -> None:
    W = np.full((JOINT_COUNT, JOINT_COUNT), 2.0) - np.eye(JOINT_COUNT)  # eigenvalues -1 and 11
    with pytest.raises(PlantError, match=r"do not settle.*not positive definite"):
        solved(
            W, np.arange(1.0, 1.0 + JOINT_COUNT), [JointFriction(1e300, 1e300, 0.0)] * JOINT_COUNT
        )


def loaded(arm: Arm, part: float, joint: int | None = None) -> tuple[ArmModel, list[float]]:
    """The parked arm, and torques that hold it plus ``part`` of the dry friction (signed)."""
    friction = arm.friction_sets["corke"]
    model = ArmModel(arm, friction)
    torque = model.holding_torque()
    for i, f in enumerate(friction):
        if joint is None or joint == i:
            torque[i] += part * (f.coulomb_positive if part > 0.0 else f.coulomb_negative)
    return model, torque


@pytest.mark.parametrize("arm", [PUMA_260, PUMA_560], ids=lambda arm: arm.name)
@pytest.mark.parametrize("part", [0.99, -0.99])
def test_a_joint_loaded_below_its_stiction_does_not_creep_in_ten_seconds(
    arm: Arm, part: float
) -> None:
    model, torque = loaded(arm, part)
    model.step(torque, steps=10_000)
    assert model.q == list(arm.park)  # not one bit
    assert model.qd == [0.0] * JOINT_COUNT


@pytest.mark.parametrize("joint", range(JOINT_COUNT))
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_a_joint_breaks_away_at_its_friction_of_that_direction(
    joint: int, direction: float
) -> None:
    model, torque = loaded(PUMA_260, 0.999 * direction, joint)
    model.step(torque, steps=50)
    assert model.qd[joint] == 0.0
    model, torque = loaded(PUMA_260, 1.001 * direction, joint)
    model.step(torque, steps=50)
    assert model.qd[joint] * direction > 0.0


@pytest.mark.parametrize("speed", [0.5, -0.5])
def test_coulomb_and_viscous_torque_keep_a_speed_constant(speed: float) -> None:
    friction = PUMA_260.friction_sets["thesis"][0]
    coulomb = friction.coulomb_positive if speed > 0.0 else -friction.coulomb_negative
    model = ArmModel(PUMA_260, PUMA_260.friction_sets["thesis"])
    model.reset(PUMA_260.park, [speed, 0.0, 0.0, 0.0, 0.0, 0.0])  # joint 1 feels no gravity
    torque = [coulomb + friction.viscous * speed, 0.0, 0.0, 0.0, 0.0, 0.0]
    model.step(torque, (False, True, True, True, True, True), steps=1000)
    assert model.qd[0] == pytest.approx(speed, rel=1e-9)
    assert model.q[0] == pytest.approx(PUMA_260.park[0] + speed, rel=1e-9)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_brakes_hold_against_full_torque(direction: float) -> None:
    model = ArmModel(PUMA_260, PUMA_260.friction_sets["corke"])
    torque = [direction * drive.torque_limit for drive in PUMA_260.drives]
    model.step(torque, ALL_BRAKES, steps=1000)
    assert model.q == list(PUMA_260.park)
    model.step(torque, steps=10)
    assert all(qd * direction > 0.0 for qd in model.qd[:1])  # released, they let go


def test_brakes_stop_a_moving_arm() -> None:
    model = ArmModel(PUMA_260, PUMA_260.friction_sets["none"])
    model.reset(PUMA_260.park, PUMA_260.speed_limits)
    model.step([0.0] * JOINT_COUNT, ALL_BRAKES, steps=100)
    assert model.qd == [0.0] * JOINT_COUNT


@pytest.mark.parametrize("friction", ["none", "corke"])
def test_energy_of_an_undriven_arm_never_grows(friction: str) -> None:
    arm = PUMA_260
    model, dynamics = ArmModel(arm, arm.friction_sets[friction], 1e-4), ArmDynamics(arm)
    model.reset(arm.park, (1.0, -0.5, 0.8, 3.0, -2.0, 4.0))

    def kinetic() -> float:
        model.step([0.0] * JOINT_COUNT)
        speed = np.array(model.qd)
        return float(0.5 * speed @ np.array(model.inertia_matrix()) @ speed)

    before, energy, work = kinetic(), [], 0.0
    for _ in range(500):
        q = np.array(model.q)
        now = kinetic()
        moved = np.array(model.q) - q
        work += float(dynamics.gravity(q + moved / 2.0) @ moved)
        energy.append(now + work)
    drops = np.diff(np.array([before, *energy]))
    tolerance = 2e-5 if friction == "none" else 0.0  # the integrator's own, without dissipation
    assert drops.max() <= tolerance
    assert energy[-1] < before + (1e-2 if friction == "none" else -0.5 * before)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_hard_stops_are_never_passed_and_end_the_motion(direction: float) -> None:
    arm = PUMA_260
    model = ArmModel(arm, arm.friction_sets["corke"])
    torque = [direction * drive.torque_limit for drive in arm.drives]
    for _ in range(600):
        model.step(torque, steps=5)
        for angle, (lower, upper) in zip(model.q, arm.hard_stops, strict=True):
            assert lower <= angle <= upper
    stops = [upper if direction > 0.0 else lower for lower, upper in arm.hard_stops]
    assert model.q == pytest.approx(stops, abs=1e-12)
    assert model.qd == pytest.approx([0.0] * JOINT_COUNT, abs=1e-9)
    model.step([-t for t in torque], steps=5)
    assert all(direction * (stop - q) > 0.0 for q, stop in zip(model.q, stops, strict=True))

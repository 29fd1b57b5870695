"""Eq. 4.9, 4.11, 4.12 as corrected: against golden constants and the full model, both conventions.

Convention A of Chapter IV is checked from its own kinematic chain, not by our map.
"""

import math
import random
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.golden import golden

from rfms_can.arm import ARMS, PUMA_560, Arm, Load, known_load, load_alone
from rfms_can.dynamics.fitted import fitted_constants, random_poses
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.dynamics.simplified import SimplifiedDynamics
from rfms_can.dynamics.terms import (
    CONSTANTS,
    from_convention_a,
    gravity_row,
    in_other_convention,
    inertia_row,
    value,
)
from rfms_can.errors import ArmError
from rfms_can.kinematics import direct, jacobian

GOLDEN: dict[str, Any] = golden("simplified_model_constants")
arms = pytest.mark.parametrize("arm", list(ARMS.values()), ids=list(ARMS))


def constants_of(key: str, actuators: str) -> dict[str, float]:
    """Golden constants by our names: with Ia, and the wrist's part of c32 taken out."""
    constants = dict(GOLDEN[key])
    constants["c22"] = constants.pop("c22_S2")
    constants["c32"] -= constants["c50"]
    for joint, inertia in enumerate(GOLDEN[actuators], start=1):
        constants[f"b{joint}0"] += inertia
    return constants


@pytest.mark.parametrize(
    ("arm", "key", "actuators"),
    [
        (PUMA_560, "puma560_convention_B", "Ia_560_corke"),
        (ARMS["puma260"], "puma260_provisional_convention_B", "Ia_260"),
    ],
)
def test_golden_constants(arm: Arm, key: str, actuators: str) -> None:
    ours, theirs = fitted_constants(ArmDynamics(arm)), constants_of(key, actuators)
    for name in CONSTANTS:
        assert ours[name] == pytest.approx(theirs[name], rel=2e-3, abs=2.5e-3), name
    in_a = constants_of(key.replace("_B", "_A"), actuators)
    for name in CONSTANTS:
        assert in_other_convention(ours)[name] == pytest.approx(in_a[name], rel=2e-3, abs=3e-3), (
            name
        )


def convention_a_pose(arm: Arm, q: list[float]) -> np.ndarray[Any, Any]:
    """Position of the wrist by Chapter IV's chain: alpha and a3 with the other sign."""
    pose = np.eye(4)
    for theta, (alpha, a, d) in zip(q, arm.dh, strict=True):
        a_, alpha_ = (-a if a == arm.a3 else a), -alpha
        c, s, ca, sa = math.cos(theta), math.sin(theta), math.cos(alpha_), math.sin(alpha_)
        pose = pose @ np.array(
            [
                [c, -s * ca, s * sa, a_ * c],
                [s, c * ca, -c * sa, a_ * s],
                [0.0, sa, ca, d],
                [0.0, 0.0, 0.0, 1.0],
            ]
        )
    return pose


def test_the_map_between_the_conventions_keeps_the_pose() -> None:
    draw = random.Random(4)
    for _ in range(50):
        q_a = [draw.uniform(-3.0, 3.0) for _ in range(6)]
        ours = np.array(direct(PUMA_560, from_convention_a(q_a)).rows())
        theirs = convention_a_pose(PUMA_560, q_a)
        np.testing.assert_allclose(ours[:3, 3], theirs[:3, 3], atol=1e-12)
        np.testing.assert_allclose(ours[:3, 2], theirs[:3, 2], atol=1e-12)


@arms
def test_the_same_equations_hold_in_either_convention(arm: Arm) -> None:
    constants = fitted_constants(ArmDynamics(arm))
    draw = random.Random(5)
    for _ in range(50):
        q_a = [draw.uniform(-3.0, 3.0) for _ in range(6)]
        q_b = from_convention_a(q_a)
        for joint in range(1, 7):
            for row in (gravity_row, inertia_row):
                in_a = value(row(joint, q_a), in_other_convention(constants))
                assert in_a == pytest.approx(value(row(joint, q_b), constants), abs=1e-12)


@arms
def test_gravity_is_exact(arm: Arm) -> None:
    """With c22 and the wrist's part of D2 and D3 nothing is left to approximate."""
    full = ArmDynamics(arm)
    simple = SimplifiedDynamics(arm, fitted_constants(full))
    for q in random_poses(arm, 50, 2):
        simple.update(q)
        np.testing.assert_allclose(simple.g, full.gravity(q), atol=1e-9)


@arms
def test_effective_inertias_and_d23_are_near_the_full_ones(arm: Arm) -> None:
    full = ArmDynamics(arm)
    simple = SimplifiedDynamics(arm, fitted_constants(full))
    for q in random_poses(arm, 100, 3):
        simple.update(q)
        M = full.inertia_matrix(q)
        np.testing.assert_allclose(np.diag(simple.M), np.diag(M), rtol=0.02)
        assert simple.M[1, 2] == pytest.approx(M[1, 2], abs=0.02 * M[2, 2])
        assert simple.M[1, 2] == simple.M[2, 1]
        np.testing.assert_allclose(simple.J, jacobian(arm, q))


def test_a_missing_constant_is_named() -> None:
    constants = fitted_constants(ArmDynamics(PUMA_560))
    del constants["b14"], constants["c50"]
    with pytest.raises(ArmError, match="lack c50, b14"):
        SimplifiedDynamics(PUMA_560, constants)


@arms
def test_newton_euler_and_the_regressor_say_the_same(arm: Arm) -> None:
    full = ArmDynamics(arm)
    draw = random.Random(6)
    armature = np.array([drive.armature for drive in arm.drives])
    for q in random_poses(arm, 20, 4):
        qd = [draw.uniform(-2.0, 2.0) for _ in range(6)]
        qdd = [draw.uniform(-9.0, 9.0) for _ in range(6)]
        torque = full.torque(q, qd, qdd)
        by_row = full.regressor(q, qd, qdd) @ full.parameters.ravel() + armature * qdd
        np.testing.assert_allclose(by_row, torque, atol=1e-9)
        at_rest = full.torque(q, [0.0] * 6, qdd)
        full.update(q)
        np.testing.assert_allclose(at_rest, full.M @ qdd + full.g, atol=1e-9)


def test_inertial_parameters_in_the_place_of_links() -> None:
    full = ArmDynamics(PUMA_560)
    heavier = ArmDynamics(PUMA_560, 2.0 * full.parameters, [0.0] * 6)
    q = PUMA_560.park
    np.testing.assert_allclose(heavier.gravity(q), 2.0 * full.gravity(q), atol=1e-12)


@arms
def test_a_load_adds_what_a_heavier_last_link_would(arm: Arm) -> None:
    """Link 6 without its own mass, so that the load takes its place."""
    load = Load(0.7, (0.01, -0.02, 0.05), (1e-3, 2e-3, 2.5e-3))
    with_load = load_alone(arm, load).links[-1]
    bare = replace(arm, links=(*arm.links[:-1], replace(with_load, mass=0.0, inertia=(0, 0, 0))))
    loaded = replace(arm, links=(*arm.links[:-1], with_load))
    alone = ArmDynamics(load_alone(arm, load))
    for q in random_poses(arm, 10, 7):
        alone.update(q)
        gain = ArmDynamics(loaded).inertia_matrix(q) - ArmDynamics(bare).inertia_matrix(q)
        np.testing.assert_allclose(alone.M, gain, atol=1e-12)
        gain = ArmDynamics(loaded).gravity(q) - ArmDynamics(bare).gravity(q)
        np.testing.assert_allclose(alone.g, gain, atol=1e-12)


@arms
def test_the_known_load_turns_every_joint_but_the_first_by_its_weight(arm: Arm) -> None:
    alone = ArmDynamics(load_alone(arm, known_load(arm)))
    most = np.max([np.abs(alone.gravity(q)) for q in random_poses(arm, 300, 8)], axis=0)
    limits = [drive.torque_limit for drive in arm.drives]
    assert most[0] < 1e-12
    assert (most[1:] > 0.09 * np.array(limits[1:])).all()

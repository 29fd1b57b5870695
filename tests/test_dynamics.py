"""Pinocchio's model of each arm against golden data, and identities between its functions."""

import numpy as np
import pytest
from support.golden import golden

from rfms_can.arm import ARMS, Arm
from rfms_can.dynamics.rigid_body import ArmDynamics

arms = pytest.mark.parametrize("arm", list(ARMS.values()), ids=list(ARMS))


@arms
def test_golden_jacobian_inertia_and_gravity(arm: Arm) -> None:
    data, dynamics = golden(f"{arm.name}_dynamics"), ArmDynamics(arm)
    for case in data["cases"]:
        dynamics.update(case["q"])
        M = np.array(case["M_links"]) + np.diag(data["armature"])
        np.testing.assert_allclose(dynamics.J, case["J_T6"], rtol=0, atol=1e-9)
        np.testing.assert_allclose(dynamics.M, M, rtol=0, atol=1e-9)
        np.testing.assert_allclose(dynamics.g, case["gravity"], rtol=0, atol=1e-9)


@arms
def test_gravity_holds_an_outstretched_arm_up(arm: Arm) -> None:
    """The sign: lifting the horizontal upper arm (conv. B: q2 grows) takes positive torque."""
    forearm_forward = [0.0, 0.0, -np.pi / 2, 0.0, 0.0, 0.0]
    assert ArmDynamics(arm).gravity(forearm_forward)[1] > 0.0


@arms
def test_inertia_is_symmetric_and_positive_with_at_least_the_armature(arm: Arm) -> None:
    dynamics = ArmDynamics(arm)
    for case in golden(f"{arm.name}_dynamics")["cases"][:20]:
        M = dynamics.inertia_matrix(case["q"])
        assert (M == M.T).all()
        links = M - np.diag([drive.armature for drive in arm.drives])
        assert min(np.linalg.eigvalsh(links)) > -1e-12


@arms
def test_kept_arrays_survive_the_next_update(arm: Arm) -> None:
    dynamics = ArmDynamics(arm)
    kept = dynamics.jacobian(arm.park)
    before = kept.copy()
    dynamics.update([0.0] * 6)
    assert (kept == before).all() and (before != dynamics.J).any()


@arms
def test_torque_limits_carry_the_acceleration_limits_everywhere(arm: Arm) -> None:
    """One joint at its acceleration limit, against gravity, friction and its speed, anywhere."""
    dynamics = ArmDynamics(arm)
    for case in golden(f"{arm.name}_dynamics")["cases"]:
        dynamics.update(case["q"])
        for i, drive in enumerate(arm.drives):
            friction = arm.friction_sets["corke"][i]
            coulomb = max(friction.coulomb_positive, friction.coulomb_negative)
            needed = (
                dynamics.M[i, i] * arm.acceleration_limits[i]
                + abs(dynamics.g[i])
                + coulomb
                + friction.viscous * arm.speed_limits[i]
            )
            assert needed < drive.torque_limit, f"joint {i + 1}"

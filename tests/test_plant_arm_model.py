"""The MuJoCo arm against golden data, one step against its equation, and warnings as errors."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.golden import golden

from rfms_can.arm import ARMS, JOINT_COUNT, PUMA_260, PUMA_560, Arm
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.errors import PlantError
from rfms_can.plant.arm_model import ArmModel

arms = pytest.mark.parametrize("arm", list(ARMS.values()), ids=list(ARMS))


def golden_within_limits(arm: Arm) -> tuple[list[dict[str, Any]], list[float]]:
    data = golden(f"{arm.name}_dynamics")
    cases = [
        case
        for case in data["cases"]
        if all(lo <= q <= hi for q, (lo, hi) in zip(case["q"], arm.joint_limits, strict=True))
    ]
    assert len(cases) > 20
    return cases, data["armature"]


@arms
def test_golden_pose_gravity_and_inertia(arm: Arm) -> None:
    """Inertia differs from the published one by the named correction of link 3 and nothing else.

    Its y axis is the axis of joint 3, parallel to that of joint 2.
    """
    cases, armature = golden_within_limits(arm)
    model = ArmModel(arm, arm.friction_sets["none"])
    correction = np.zeros((JOINT_COUNT, JOINT_COUNT))
    correction[1:3, 1:3] = arm.links[2].physical_inertia[1] - arm.links[2].inertia[1]
    assert correction[1, 1] < 0.0
    for case in cases:
        model.reset(case["q"])
        M = np.array(case["M_links"]) + np.diag(armature) + correction
        np.testing.assert_allclose(model.wrist_pose(), case["T6"], rtol=0, atol=1e-9)
        np.testing.assert_allclose(model.holding_torque(), case["gravity"], rtol=0, atol=1e-9)
        np.testing.assert_allclose(model.inertia_matrix(), M, rtol=0, atol=1e-9)


@arms
def test_one_step_is_backward_euler_in_viscous_friction(arm: Arm) -> None:
    """(M + h B) v = h (tau - g) from rest, without dry friction."""
    step_s = 1e-3
    friction = tuple(
        replace(f, coulomb_positive=0.0, coulomb_negative=0.0) for f in arm.friction_sets["corke"]
    )
    model = ArmModel(arm, friction, step_s)
    M, g = np.array(model.inertia_matrix()), ArmDynamics(arm).gravity(arm.park)
    torque = 0.5 * np.array([drive.torque_limit for drive in arm.drives])
    model.step(torque.tolist())
    B = np.diag([f.viscous for f in friction])
    v = np.linalg.solve(M + step_s * B, step_s * (torque - g))
    np.testing.assert_allclose(model.qd, v, rtol=1e-9)
    np.testing.assert_allclose(model.q, np.array(arm.park) + step_s * v, rtol=1e-12)


def test_runs_repeat_bit_by_bit() -> None:
    runs = []
    for _ in range(2):
        model = ArmModel(PUMA_560, PUMA_560.friction_sets["corke"])
        for cycle in range(50):
            model.step(
                [40.0 * np.sin(0.1 * cycle + joint) for joint in range(JOINT_COUNT)], steps=4
            )
        runs.append((model.q, model.qd))
    assert runs[0] == runs[1]
    assert runs[0][0] != list(PUMA_560.park)


@pytest.mark.parametrize("torque", [float("nan"), 1e30])
def test_a_mujoco_warning_stops_the_run_with_its_text(
    torque: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    model = ArmModel(PUMA_260, PUMA_260.friction_sets["corke"])
    with pytest.raises(PlantError, match=r"MuJoCo warned before .* s: Nan.* QACC at DOF 0"):
        model.step([torque] + [0.0] * 5, steps=4)
    assert not list(tmp_path.iterdir())  # and no log file beside the user's program


def test_mujoco_refuses_the_published_link_3_with_its_text() -> None:
    links = tuple(
        replace(link, correction=None) if i == 2 else link for i, link in enumerate(PUMA_560.links)
    )
    arm = replace(PUMA_560, links=links)
    with pytest.raises(PlantError, match=r"MuJoCo refuses the model of puma560: .*inertia"):
        ArmModel(arm, arm.friction_sets["none"])


def test_a_pose_outside_the_range_is_refused_by_joint_value_and_bound() -> None:
    model = ArmModel(PUMA_260, PUMA_260.friction_sets["none"])
    with pytest.raises(PlantError, match=r"joint 2 cannot start at 5\.0000 rad.*to 4\.4506 rad"):
        model.reset([0.0, 5.0, 0.0, 0.0, 0.0, 0.0])

"""Direct kinematics, the Jacobian and its inverse: reference poses and what must hold of them."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray
from support.golden import ARMS, distance, golden, homogeneous, matrix

from rfms_can.arm import PUMA_260, PUMA_560, Arm
from rfms_can.errors import SingularityError
from rfms_can.kinematics import (
    REGULAR_BOUNDS,
    Joints,
    direct,
    inverse_jacobian,
    jacobian,
    singularity_margins,
)
from rfms_can.transform import Transform

each_arm = pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
poses = st.tuples(*(st.floats(-math.pi, math.pi),) * 6)


def motion_between(before: Transform, after: Transform) -> NDArray[np.float64]:
    """The differential change from one pose to a near one, in the first one's axes."""
    delta = np.linalg.inv(homogeneous(before)) @ homogeneous(after)
    turned = (delta[:3, :3] - delta[:3, :3].T) / 2.0
    return np.array([*delta[:3, 3], turned[2, 1], turned[0, 2], turned[1, 0]])


def numeric_jacobian(arm: Arm, q: Joints, step: float = 1e-6) -> NDArray[np.float64]:
    here = direct(arm, q)
    columns = []
    for joint in range(6):
        ahead, behind = ([*q], [*q])
        ahead[joint] += step
        behind[joint] -= step
        forth, back = (motion_between(here, direct(arm, p)) for p in (ahead, behind))
        columns.append((forth - back) / (2.0 * step))
    return np.array(columns).T


@each_arm
def test_poses_and_jacobians_are_the_reference(arm: Arm) -> None:
    cases = golden(f"{arm.name}_kinematics")["cases"]
    assert len(cases) == 200
    for case in cases:
        t6 = direct(arm, case["q"])
        assert distance(t6, Transform.from_rows(case["T6"])) < 1e-12
        assert t6.is_rigid(1e-14)
        assert np.abs(matrix(jacobian(arm, case["q"])) - matrix(case["J_T6"])).max() < 1e-12


@pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
@given(q=poses)
def test_the_jacobian_is_the_derivative(arm: Arm, q: Joints) -> None:
    assert np.abs(matrix(jacobian(arm, q)) - numeric_jacobian(arm, q)).max() < 1e-8


@pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
@given(q=poses)
def test_the_determinant_is_the_three_margins(arm: Arm, q: Joints) -> None:
    elbow, shoulder, wrist = singularity_margins(arm, q)
    volume = arm.a2 * math.hypot(arm.a3, arm.d4) * elbow * shoulder * wrist
    assert np.linalg.det(matrix(jacobian(arm, q))) == pytest.approx(volume, abs=1e-14)


@pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
@given(q=poses)
def test_the_inverse_undoes_the_jacobian(arm: Arm, q: Joints) -> None:
    elbow, shoulder, wrist = (abs(margin) for margin in singularity_margins(arm, q))
    worst = min(elbow, shoulder / arm.a2, wrist)
    assume(worst > 1e-4)
    product = matrix(inverse_jacobian(arm, q)) @ matrix(jacobian(arm, q))
    assert np.abs(product - np.eye(6)).max() < 1e-13 / worst**2


@given(q=poses, rates=poses, force=poses)
def test_joint_torques_do_the_work_of_the_force(q: Joints, rates: Joints, force: Joints) -> None:
    """tau = J^T F, tau . d theta = F . dx with dx the motion of the pose itself."""
    step = 1e-6
    moved = [angle + step * rate for angle, rate in zip(q, rates, strict=True)]
    dx = motion_between(direct(PUMA_260, q), direct(PUMA_260, moved)) / step
    torque = matrix(jacobian(PUMA_260, q)).T @ matrix(force)
    assert torque @ matrix(rates) == pytest.approx(matrix(force) @ dx, abs=1e-3)


def test_columns_belong_to_the_joints_and_not_to_theta23() -> None:
    """A.22 printed: column 2 moves with theta23 held. Corrected, theta2 alone turns the forearm."""
    j = matrix(jacobian(PUMA_260, (0.1, 0.9, -0.4, 0.3, 0.8, -0.2)))
    assert np.array_equal(j[3:, 1], j[3:, 2]) and np.linalg.norm(j[3:, 1]) == pytest.approx(1.0)


STRAIGHT_560 = math.atan2(-PUMA_560.d4, PUMA_560.a3)
"""theta3 that stretches the 560's arm: its a3 takes it off -90 degrees."""


@pytest.mark.parametrize(
    ("arm", "q", "name"),
    [
        (PUMA_260, (0.3, 0.8, math.pi / 2, 0.1, 0.7, 0.2), "elbow"),
        (PUMA_260, (0.3, 0.8, -math.pi / 2, 0.1, 0.7, 0.2), "elbow"),
        (PUMA_560, (0.3, 0.8, STRAIGHT_560, 0.1, 0.7, 0.2), "elbow"),
        (PUMA_260, (0.3, 0.4, math.asin(math.cos(0.4)) - 0.4, 0.1, 0.7, 0.2), "shoulder"),
        (PUMA_260, (0.3, 0.8, 0.1, 0.1, 0.0, 0.2), "wrist"),
        (PUMA_560, (0.3, 0.8, 0.1, 0.1, math.pi, 0.2), "wrist"),
    ],
)
def test_singular_poses_are_refused_by_name(arm: Arm, q: Joints, name: str) -> None:
    assert abs(getattr(singularity_margins(arm, q), name)) < 1e-15
    with pytest.raises(SingularityError, match=rf"{arm.name}: {name} singularity.*1e-06"):
        inverse_jacobian(arm, q)


def test_just_outside_the_bound_the_inverse_still_holds() -> None:
    q = (0.3, 0.8, 0.1, 0.1, 2.0 * REGULAR_BOUNDS.wrist, 0.2)
    product = matrix(jacobian(PUMA_260, q)) @ matrix(inverse_jacobian(PUMA_260, q))
    assert np.abs(product - np.eye(6)).max() < 1e-8

"""Words, frames and the other laws; the thesis' two-link arm (Fig. 5.6, as corrected)."""

from collections.abc import Sequence
from math import cos, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from rfms_can.arm import PUMA_260, PUMA_560
from rfms_can.compliance import (
    Selection,
    SelectionError,
    cartesian_error,
    cartesian_part,
    compliance_jacobian,
    free_damping,
    free_joint_rows,
    hybrid_rows,
    match_joints,
    matched_stiffness,
    position_rows,
    stiffness_rows,
)
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.errors import TransformError
from rfms_can.kinematics import direct
from rfms_can.transform import Transform

Matrix = NDArray[np.float64]
PEG = Selection.parse("fx fy rx ry")
AT_T6 = Transform.identity()


def model(q: Sequence[float], frame: Transform = AT_T6) -> tuple[Matrix, Matrix]:
    dynamics = ArmDynamics(PUMA_560)
    dynamics.update(q)
    return compliance_jacobian(dynamics.J, frame), dynamics.M


def test_the_word_of_the_peg_in_hole() -> None:
    assert PEG == (True, True, False, True, True, False)  # (5.2)
    assert PEG.word == "fx fy rx ry"
    assert PEG.size == 4


@pytest.mark.parametrize(
    ("word", "complaint"),
    [("", "names no direction"), ("fx fw", "'fw' is not a direction"), ("fx fx", "fx twice")],
)
def test_impossible_words_are_refused_by_name(word: str, complaint: str) -> None:
    with pytest.raises(SelectionError, match=complaint) as caught:
        Selection.parse(word)
    assert repr(word) in str(caught.value)


@given(st.tuples(*[st.booleans()] * 6))
def test_words_come_back(selected: tuple[bool, ...]) -> None:
    selection = Selection.of(selected)
    assert not any(selection) or Selection.parse(selection.word) == selection


def test_comply_and_lock() -> None:
    both = Selection.parse("fx").with_(Selection.parse("ry fx"))
    assert both.word == "fx ry"
    assert both.without(Selection.parse("fx")).word == "ry"
    with pytest.raises(SelectionError, match="fz does not comply"):
        PEG.without(Selection.parse("fx fz rx ry"))  # the misprint of the thesis' program


@given(
    st.tuples(*[st.floats(-1.0, 1.0)] * 3),
    st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    st.integers(0, 5),
)
def test_the_frames_jacobian_is_the_motion_of_the_frame(
    p: tuple[float, float, float], angles: tuple[float, float, float], joint: int
) -> None:
    frame = Transform.translation(*p) @ Transform.rpy(*angles)
    q, step = np.array(PUMA_560.park), 1e-6
    J, _ = model(q.tolist(), frame)
    turned = q.copy()
    turned[joint] += step
    before, after = direct(PUMA_560, q.tolist()), direct(PUMA_560, turned.tolist())
    moved = cartesian_error(after, before, frame) / step
    np.testing.assert_allclose(moved, J[:, joint], rtol=0, atol=1e-5)


def test_a_compliance_frame_that_is_none_is_refused() -> None:
    with pytest.raises(TransformError, match="compliance frame"):
        compliance_jacobian(np.eye(6), Transform(*(0.0,) * 12))


def two_link(theta2: float) -> Matrix:
    """The errata's Jacobian of Fig. 5.6, in the axes of link 2."""
    return np.array([[sin(theta2), 0.0], [1.0 + cos(theta2), 1.0]])


@pytest.mark.parametrize("theta2", [0.5, 0.1, 1e-2, 1e-3])
def test_two_link_arm_stiffness_goes_hybrid_stays(theta2: float) -> None:
    """x2 in position, y2 in force: J^T K J vanishes with theta2, J^-1 (I-S) J does not."""
    J, kx, k = two_link(theta2), 1000.0, np.diag([30.0, 20.0])
    joint_stiffness = J.T @ np.diag([kx, 0.0]) @ J
    np.testing.assert_allclose(joint_stiffness, [[kx * sin(theta2) ** 2, 0.0], [0.0, 0.0]])
    C = np.linalg.inv(J) @ np.diag([1.0, 0.0]) @ J
    np.testing.assert_allclose(C, [[1.0, 0.0], [-(1.0 + cos(theta2)), 0.0]], atol=1e-12)
    small = abs(theta2) ** 2
    np.testing.assert_allclose(k @ C, [[30.0, 0.0], [-40.0, 0.0]], atol=20.0 * small)
    both = J.T @ np.diag([kx, 500.0]) @ J  # (1,1): t2^2 kx + 4 ky
    assert both[0, 0] == pytest.approx(kx * theta2**2 + 4.0 * 500.0, rel=theta2**2 + 1e-9)


@pytest.mark.parametrize("theta2", [1.2, 0.3, 1e-3])
def test_two_link_arm_jacobian_is_the_motion_of_its_tip(theta2: float) -> None:
    """Unit links: the tip by its angles, differenced, seen along and across link 2."""

    def tip(t1: float, t2: float) -> Matrix:
        return np.array([cos(t1) + cos(t1 + t2), sin(t1) + sin(t1 + t2)])

    theta1, h = 0.4, 1e-6
    c, s = cos(theta1 + theta2), sin(theta1 + theta2)
    axes = np.array([[c, s], [-s, c]])
    columns = [
        (tip(theta1 + h, theta2) - tip(theta1 - h, theta2)) / (2 * h),
        (tip(theta1, theta2 + h) - tip(theta1, theta2 - h)) / (2 * h),
    ]
    np.testing.assert_allclose(axes @ np.array(columns).T, two_link(theta2), atol=1e-9)
    inverse = np.array([[1.0 / sin(theta2), 0.0], [-(1.0 + cos(theta2)) / sin(theta2), 1.0]])
    np.testing.assert_allclose(np.linalg.inv(two_link(theta2)), inverse, rtol=1e-9)
    if theta2 < 0.01:
        small = [[1.0 / theta2, 0.0], [-2.0 / theta2, 1.0]]
        np.testing.assert_allclose(inverse, small, rtol=1e-5)


def test_two_link_arm_at_its_singularity_what_restores_a_displaced_joint() -> None:
    """Fig. 5.6: Salisbury's torque goes with the square of theta2, the hybrid one stays."""
    k1, k2, kx, d1 = 30.0, 20.0, 1000.0, 0.01
    stiff, hybrid = [], []
    for theta2 in (1e-2, 1e-4, 1e-6):
        J = two_link(theta2)
        stiff.append((J.T @ np.diag([kx, 0.0]) @ J @ [d1, 0.0])[0])
        C = hybrid_rows(embedded(theta2), Selection.parse("fy"), np.eye(6)).errors[:2, :2]
        hybrid.append((np.diag([k1, k2]) @ C @ [d1, 0.0]).tolist())
    assert stiff == pytest.approx([kx * d1 * t * t for t in (1e-2, 1e-4, 1e-6)], rel=1e-4)
    for torque in hybrid:
        assert torque == pytest.approx([k1 * d1, -2.0 * k2 * d1], rel=1e-4)


def embedded(theta2: float) -> Matrix:
    """The two-link arm as joints 1 and 2 of six, the others each a direction of their own."""
    J = np.eye(6)
    J[:2, :2] = two_link(theta2)
    return J


@pytest.mark.parametrize("theta2", [0.5, 1e-2, 1e-5])
def test_two_link_arm_through_the_laws(theta2: float) -> None:
    J, M, selection = embedded(theta2), np.eye(6), Selection.parse("fy")
    hybrid = hybrid_rows(J, selection, M).errors[:2, :2]
    np.testing.assert_allclose(hybrid, [[1.0, 0.0], [-(1.0 + cos(theta2)), 0.0]], atol=1e-9)
    rows = stiffness_rows(J, (1000.0, 0.0, 1.0, 1.0, 1.0, 1.0), M, (10.0,) * 6)
    torque = 10.0 * rows.errors[:2, :2]
    np.testing.assert_allclose(torque, [[1000.0 * sin(theta2) ** 2, 0.0], [0.0, 0.0]], atol=1e-9)


def test_position_rows_are_each_joint_its_own() -> None:
    _, M = model(PUMA_560.park)
    rows = position_rows(M)
    assert (rows.errors == np.eye(6)).all()
    assert (rows.weighted == M).all()


def test_stiffness_rows_make_the_torque_of_a_spring() -> None:
    J, M = model(PUMA_560.park)
    Kp, K = np.array([90.0, 80.0, 70.0, 5.0, 4.0, 3.0]), (1e3, 2e3, 0.0, 5.0, 0.0, 9.0)
    rows = stiffness_rows(J, K, M, Kp.tolist())
    e = np.array([0.01, -0.02, 0.03, 0.01, 0.02, -0.01])
    force = np.array(K) * (J @ e)
    np.testing.assert_allclose(Kp * (rows.errors @ e), J.T @ force, rtol=1e-12)


def test_matched_stiffness_is_that_of_a_mass_moving_along_one_direction() -> None:
    J, M = model(PUMA_560.park)
    values = matched_stiffness(J, PEG, M, 30.0)
    assert [v > 0.0 for v in values] == [not s for s in PEG]
    force = np.zeros(6)
    force[2] = 1.0
    acceleration = (J @ np.linalg.solve(M, J.T @ force))[2]
    assert values[2] == pytest.approx(900.0 / acceleration)


def test_rotation_about_the_approach_is_joint_six_and_nothing_else() -> None:
    """The perfect match of the thesis: z of T6 is the axis of joint 6."""
    J, M = model(PUMA_560.park)
    selection = Selection.parse("rz")
    matching = match_joints(J, selection, PUMA_560.a2)
    assert matching.joints == (5,)
    assert matching.abilities[0] == pytest.approx(1.0)
    rows = free_joint_rows(J, selection, matching.joints, M)
    np.testing.assert_allclose(rows.errors, np.diag([1, 1, 1, 1, 1, 0]), atol=1e-12)


def test_free_joints_hear_nothing_and_the_others_take_their_errors_over() -> None:
    J, M = model(PUMA_560.park)
    matching = match_joints(J, PEG, PUMA_560.a2)
    assert len(set(matching.joints)) == 4
    C = free_joint_rows(J, PEG, matching.joints, M).errors
    assert (C[list(matching.joints)] == 0.0).all()
    np.testing.assert_allclose(C @ C, C, atol=1e-9)
    e = np.array([0.01, -0.02, 0.03, 0.01, 0.02, -0.01])
    rigid = J[~PEG.mask]
    np.testing.assert_allclose(rigid @ C @ e, rigid @ e, atol=1e-9)  # the same errors ...
    assert np.abs(J[PEG.mask] @ C @ e).max() > 1e-4  # ... corrected across the compliant ones
    with_c_theta = hybrid_rows(J, PEG, M).errors
    np.testing.assert_allclose(J[PEG.mask] @ with_c_theta @ e, 0.0, atol=1e-9)


def test_the_matching_is_the_best_of_all() -> None:
    """Against the greedy way: never a smaller sum."""
    for q in ((0.3, 1.0, -2.5, 0.4, 0.9, 0.2), (0.1, 0.8, -3.0, -0.7, 1.2, -1.0)):
        J, _ = model(q)
        scaled = J / np.repeat([PUMA_560.a2, 1.0], 3)[:, np.newaxis]
        ability = np.abs(scaled / np.linalg.norm(scaled, axis=0))[PEG.mask]
        free, greedy = set(range(6)), 0.0
        for row in ability:
            joint = max(free, key=lambda j: row[j])
            free.remove(joint)
            greedy += row[joint]
        assert sum(match_joints(J, PEG, PUMA_560.a2).abilities) >= greedy - 1e-9


def test_raibert_and_craig_differ_in_second_order() -> None:
    frame = Transform.translation(0.0, 0.0, 0.2)
    q = np.array(PUMA_560.park)
    J, M = model(q.tolist(), frame)
    C = hybrid_rows(J, PEG, M).errors
    sizes = []
    for scale in (1e-2, 1e-3):
        e = scale * np.array([1.0, -2.0, 1.5, 2.0, -1.0, 0.5])
        dx = cartesian_error(
            direct(PUMA_560, (q + e).tolist()), direct(PUMA_560, q.tolist()), frame
        )
        part = cartesian_part(J, C, dx, e)
        expected = np.linalg.solve(J, np.where(PEG.mask, 0.0, dx))  # J^-1 (I-S) dx (5.8)
        np.testing.assert_allclose(C @ e + part, expected, atol=1e-12)
        sizes.append(np.abs(part).max())
    assert sizes[0] > 1e-6
    assert sizes[1] == pytest.approx(sizes[0] / 100.0, rel=0.1)


def test_the_cartesian_error_measures_large_turns() -> None:
    here = direct(PUMA_260, PUMA_260.park)
    for angle in (1e-9, 0.5, 3.0):
        turned = here @ Transform.rotation((0.0, 0.6, 0.8), angle)
        error = cartesian_error(turned, here, Transform.identity())
        np.testing.assert_allclose(error, [0, 0, 0, 0, 0.6 * angle, 0.8 * angle], atol=1e-12)


def test_free_damping_brakes_nothing_that_is_held() -> None:
    J, M = model(PUMA_560.park)
    rows = hybrid_rows(J, PEG, M)
    damping = free_damping(rows, M)
    np.testing.assert_allclose(damping @ rows.errors, 0.0, atol=1e-9)
    moved = np.linalg.inv(J) @ np.array([0.1, 0.0, 0.0, 0.0, 0.0, 0.0])  # along fx: free
    assert moved @ damping @ moved > 0.0

"""C_theta: equal to its definition where that is tame, bounded and a projector everywhere."""

from collections.abc import Iterator
from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from support.golden import golden

from rfms_can.arm import ARMS, PUMA_260, PUMA_560, Arm
from rfms_can.compliance import (
    COUPLING_LIMIT,
    Selection,
    bounded_projector,
    compliance_jacobian,
    conflicts,
    hybrid_rows,
    largest_element,
    largest_norm,
    metric_norm,
    out_of_reach,
    regular_pose,
)
from rfms_can.compliance.projector import OVERSHOOT, damped
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.kinematics import REGULAR_BOUNDS, singularity_margins
from rfms_can.transform import Transform

Matrix = NDArray[np.float64]
WORDS = ("fx", "rx", "fx fy", "fz rz", "fx fy rx ry", "fx fy fz", "rx ry rz", "fx fy fz rx ry")
arms = pytest.mark.parametrize("arm", list(ARMS.values()), ids=list(ARMS))


def by_definition(J: Matrix, selection: Selection) -> Matrix:
    """J^-1 (I-S) J (5.10b)."""
    product: Matrix = np.linalg.inv(J) @ np.diag(~selection.mask) @ J
    return product


def model(arm: Arm, q: tuple[float, ...], tool: float = 0.0) -> tuple[Matrix, Matrix]:
    """Jacobian of the compliance frame and inertia."""
    dynamics = ArmDynamics(arm)
    dynamics.update(regular_pose(arm, q))
    return compliance_jacobian(dynamics.J, Transform.translation(0.0, 0.0, tool)), dynamics.M


def through(arm: Arm, name: str, reach: float, points: int) -> Iterator[tuple[float, ...]]:
    """theta5 or theta3 from -reach to reach about a singularity, the other joints fixed."""
    elbow = float(np.arctan2(arm.a3, arm.d4)) - pi / 2
    for angle in np.linspace(-reach, reach, points).tolist():
        if name == "wrist":
            yield (0.1, 1.4, -3.0, 0.8, angle, 0.4)
        else:
            yield (0.1, 0.5, elbow + angle, 0.8, -1.2, 0.4)


def test_golden_matrices() -> None:
    dynamics = ArmDynamics(PUMA_260)
    for pose in golden("puma260_compliance")["poses"]:
        dynamics.update(pose["q"])
        for case in pose["cases"]:
            J = compliance_jacobian(dynamics.J, Transform.translation(0.0, 0.0, case["tool"]))
            selection = Selection.of(s == "1" for s in case["word"])
            rows = hybrid_rows(J, selection, dynamics.M)
            np.testing.assert_allclose(rows.errors, case["C"], rtol=0, atol=1e-7)
            np.testing.assert_allclose(rows.weighted, dynamics.M @ case["C"], rtol=0, atol=1e-7)


@arms
@given(data=st.data())
def test_it_is_the_definition_away_from_singularities(arm: Arm, data: st.DataObject) -> None:
    angle = st.floats(-pi, pi)
    q = tuple(data.draw(angle) for _ in range(6))
    selection = Selection.of(data.draw(st.tuples(*[st.booleans()] * 6)))
    J, M = model(arm, q, data.draw(st.sampled_from([0.0, 0.1])))
    rows = hybrid_rows(J, selection, M)
    C = rows.errors
    bounded = bounded_projector(J[selection.mask], J[~selection.mask], M)  # the long way
    np.testing.assert_allclose(C, bounded.matrix, rtol=0, atol=1e-6)
    if max(bounded.couplings, default=0.0) <= COUPLING_LIMIT and np.linalg.cond(J) < 1e4:
        np.testing.assert_allclose(C, by_definition(J, selection), rtol=0, atol=1e-9)
    np.testing.assert_allclose(C @ C, C, rtol=0, atol=1e-9)
    assert np.trace(C) == pytest.approx(6 - selection.size, abs=1e-9)
    # what is corrected moves no compliant direction, damped or not
    np.testing.assert_allclose(J[selection.mask] @ C, 0.0, rtol=0, atol=1e-9)
    assert metric_norm(C, M) <= largest_norm() + 1e-6
    assert np.abs(C).max(initial=0.0) <= largest_element(M)


@arms
@pytest.mark.parametrize("word", WORDS)
@pytest.mark.parametrize("name", ["wrist", "elbow"])
def test_it_passes_singularities_without_a_jump(arm: Arm, word: str, name: str) -> None:
    """Steps of C shrink with the steps of the joint, down to the singular pose itself."""
    selection, largest = Selection.parse(word), []
    for points in (201, 1601):
        before: Matrix | None = None
        steps = [0.0]
        for q in through(arm, name, 0.01, points):
            C = hybrid_rows(*model_of(arm, q, selection)).errors
            assert np.abs(C @ C - C).max() < 1e-9
            if before is not None:
                steps.append(float(np.abs(C - before).max()))
            before = C
        largest.append(max(steps))
    assert largest[1] < 0.25 * largest[0] + 2e-3  # the last: across the bound of regular_pose


_DYNAMICS = {arm.name: ArmDynamics(arm) for arm in ARMS.values()}


def model_of(
    arm: Arm, q: tuple[float, ...], selection: Selection
) -> tuple[Matrix, Selection, Matrix]:
    dynamics = _DYNAMICS[arm.name]
    dynamics.update(regular_pose(arm, q))
    return dynamics.J, selection, dynamics.M


def test_the_definition_grows_without_limit_where_ours_does_not() -> None:
    """As sharply as 1 / S5: 40 at one degree, 4000 at a hundredth (word rx, PUMA 260)."""
    selection = Selection.parse("rx")
    bare, ours = [], []
    for degrees in (1.0, 0.01):
        J, M = model(PUMA_260, (0.1, 1.4, -3.3, 0.1, float(np.radians(degrees)), 0.1))
        bare.append(np.abs(by_definition(J, selection)).max())
        ours.append(np.abs(hybrid_rows(J, selection, M).errors).max())
    assert bare[1] == pytest.approx(100.0 * bare[0], rel=0.01)
    assert bare[0] > 30.0
    assert max(ours) < 25.0


def test_where_a_force_lets_the_arm_go_at_the_singularity() -> None:
    """There the ignored motion is M^-1 J^T S f: C is the orthogonal projector of the metric."""
    selection = Selection.parse("rx")
    J, M = model(PUMA_560, (0.1, 1.4, -3.0, 0.8, 0.0, 0.4))
    C = hybrid_rows(J, selection, M).errors
    motion = np.linalg.solve(M, J[3])
    assert np.abs(C @ motion).max() < 1e-3 * np.abs(motion).max()
    np.testing.assert_allclose(M @ C, (M @ C).T, rtol=0, atol=1e-3)


@given(st.floats(0.0, 1e6), st.floats(0.5, 50.0))
def test_damped_couplings_stay_near_the_limit(coupling: float, limit: float) -> None:
    assert 0.0 <= damped(coupling, limit) <= OVERSHOOT * limit
    assert damped(coupling, limit) == coupling or coupling > limit


def test_damping_begins_smoothly() -> None:
    above, below = damped(8.0 + 1e-6, 8.0), damped(8.0 - 1e-6, 8.0)
    assert above - below == pytest.approx(2e-6, rel=1e-3)
    assert damped(1e12, 8.0) < 1e-9


def test_conflicts_name_the_directions() -> None:
    selection = Selection.parse("rx")
    J, M = model(PUMA_260, (0.1, 1.4, -3.3, 0.1, 0.001, 0.1))
    rows = hybrid_rows(J, selection, M)
    assert rows.projection is not None
    (conflict,) = conflicts(rows.projection, J, selection)
    assert conflict.compliant == ("rx",)
    assert conflict.coupling > COUPLING_LIMIT
    assert "cannot be held" in str(conflict)
    tame, M = model(PUMA_260, PUMA_260.park)
    calm = hybrid_rows(tame, selection, M).projection
    assert calm is not None
    assert conflicts(calm, tame, selection) == ()


def test_a_direction_the_arm_cannot_move_in_is_named() -> None:
    stretched = (0.1, 0.4, -pi / 2, 0.1, -1.2, 0.1)
    J, _ = model(PUMA_260, stretched)
    assert out_of_reach(J, Selection.parse("fx fy fz"), PUMA_260.a2) != ()
    J, _ = model(PUMA_260, PUMA_260.park)
    assert out_of_reach(J, Selection.parse("fx fy fz"), PUMA_260.a2) == ()
    assert out_of_reach(J, Selection(), PUMA_260.a2) == ()


@arms
def test_regular_pose_leaves_regular_poses_alone_and_moves_singular_ones_a_millionth(
    arm: Arm,
) -> None:
    assert regular_pose(arm, arm.park) == arm.park
    elbow = float(np.arctan2(arm.a3, arm.d4)) - pi / 2
    for q in ((0.1, 0.4, elbow, 0.1, 0.0, 0.1), (0.1, 1.4, -3.3, 0.1, pi, 0.1)):
        moved = regular_pose(arm, q)
        assert 0.0 < np.abs(np.subtract(moved, q)).max() < 1e-5
        margins = singularity_margins(arm, moved)
        for margin, bound in zip(margins, REGULAR_BOUNDS, strict=True):
            assert abs(margin) > 0.999 * bound


def test_a_shoulder_singularity_is_left_too() -> None:
    """The wrist centre on the joint-1 axis: V114 = 0."""
    q3 = -1.0
    s3, c3 = np.sin(q3), np.cos(q3)
    q2 = float(np.arctan2(PUMA_260.a2 - PUMA_260.d4 * s3, PUMA_260.d4 * c3))
    q = (0.1, q2, q3, 0.1, -1.0, 0.1)
    assert abs(singularity_margins(PUMA_260, q).shoulder) < 1e-9
    moved = singularity_margins(PUMA_260, regular_pose(PUMA_260, q)).shoulder
    assert abs(moved) == pytest.approx(REGULAR_BOUNDS.shoulder, rel=1e-3)

"""Transforms against 4x4 matrices; the wire's o, a, p; differential motion and virtual work."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.golden import distance, homogeneous, matrix

from rfms_can.errors import KinematicsError
from rfms_can.transform import (
    Transform,
    Vector6,
    differential_operator,
    differential_transform,
)

angles = st.floats(-math.pi, math.pi)
metres = st.floats(-2.0, 2.0)
transforms = st.builds(
    lambda phi, theta, psi, x, y, z: (
        Transform.translation(x, y, z) @ Transform.euler(phi, theta, psi)
    ),
    *(angles,) * 3,
    *(metres,) * 3,
)
vectors = st.tuples(*(st.floats(-10.0, 10.0),) * 6)


@given(transforms, transforms)
def test_composition_and_inverse_are_those_of_the_matrices(a: Transform, b: Transform) -> None:
    assert np.allclose(homogeneous(a @ b), homogeneous(a) @ homogeneous(b), atol=1e-14)
    assert distance(a @ a.inverse(), Transform.identity()) < 1e-14
    assert a.apply((b.px, b.py, b.pz)) == pytest.approx((a @ b)[3::4], abs=1e-14)


def test_rotations_follow_paul() -> None:
    x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 2.0)
    turn = Transform.rotation
    quarter_about_z = turn(z, math.pi / 2)
    assert quarter_about_z.apply((1.0, 0.0, 0.0)) == pytest.approx((0.0, 1.0, 0.0))
    rpy = turn(z, 0.3) @ turn(y, -0.5) @ turn(x, 0.7)
    assert distance(Transform.rpy(0.3, -0.5, 0.7), rpy) < 1e-15
    euler = turn(z, 0.3) @ turn(y, -0.5) @ turn(z, 0.7)
    assert distance(Transform.euler(0.3, -0.5, 0.7), euler) < 1e-15
    with pytest.raises(KinematicsError, match="no direction"):
        turn((0.0, 0.0, 0.0), 0.1)


def test_a_transform_is_its_value() -> None:
    t = Transform.translation(0.1, 0.2, 0.3)
    assert t == Transform.from_rows(t.rows()) and t != Transform.identity()
    assert {t: "found"}[Transform.translation(0.1, 0.2, 0.3)] == "found"
    with pytest.raises(KinematicsError, match=r"3 rows of 4.*\[4, 4\]"):
        Transform.from_rows(t.rows()[:2])


def test_composition_leaves_the_right_hand_side_a_say() -> None:
    class Expression:
        def __rmatmul__(self, left: Transform) -> str:
            return "a position equation"

    assert Transform.identity() @ Expression() == "a position equation"
    with pytest.raises(TypeError):
        Transform.identity() @ tuple(Transform.identity())  # type: ignore[operator]


@given(transforms)
def test_a_pose_survives_float32_on_the_wire(t: Transform) -> None:
    o, a, p = (np.array(t[column::4], np.float32).tolist() for column in (1, 2, 3))
    received = Transform.from_o_a_p(o, a, p)
    assert received.is_rigid(1e-15)
    assert distance(received, t) < 3e-7
    exact = Transform.from_o_a_p(t[1::4], t[2::4], t[3::4])
    assert distance(exact, t) < 1e-14


@pytest.mark.parametrize(
    ("o", "a"),
    [
        ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
        ((0.0, 0.0, 1.0), (0.0, 0.0, 1.0)),
        ((0.0, 1.0, 0.0), (0.0, 2e-5, 1.0)),
        ((0.0, 1.0, 0.0), (0.0, 0.0, math.nan)),
        ((0.0, math.inf, 0.0), (0.0, 0.0, 1.0)),
    ],
)
def test_what_is_no_rotation_on_the_wire_is_nan_and_raises_nothing(
    o: tuple[float, ...], a: tuple[float, ...]
) -> None:
    assert all(map(math.isnan, Transform.from_o_a_p(o, a, (0.1, 0.2, 0.3))))


def test_rigidity_is_measured() -> None:
    t = Transform.rpy(0.1, 0.2, 0.3)
    assert t.rigidity_error() < 1e-15
    for element in range(12):
        if element % 4 != 3:
            bent = Transform(*(e + 1e-3 * (i == element) for i, e in enumerate(t)))
            assert not bent.is_rigid() and bent.is_rigid(3e-3)
        lost = Transform(*(math.nan if i == element else e for i, e in enumerate(t)))
        assert lost.rigidity_error() == math.inf
    mirrored = Transform(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0)
    assert mirrored.rigidity_error() == 2.0


@given(transforms, vectors)
def test_the_differential_operator_moves_frames(t: Transform, change: Vector6) -> None:
    """(2.17): Delta T = T (T^Delta), with 0 where the thesis prints 1."""
    seen = differential_transform(t) @ matrix(change)
    x, y, z, rx, ry, rz = (float(component) for component in seen)
    left = matrix(differential_operator(change)) @ homogeneous(t)
    right = homogeneous(t) @ matrix(differential_operator((x, y, z, rx, ry, rz)))
    assert np.allclose(left, right, atol=1e-12)


@given(transforms, vectors, vectors)
def test_forces_do_the_same_work_in_both_frames(
    t: Transform, velocity: Vector6, force: Vector6
) -> None:
    """(2.20): F = X^T (cF) with the X of (2.11)."""
    x = matrix(differential_transform(t))
    assert matrix(force) @ (x @ velocity) == pytest.approx((x.T @ force) @ velocity, abs=1e-9)
    turn = homogeneous(t)[:3, :3]
    f, m = matrix(force[:3]), matrix(force[3:])
    outer = np.concatenate([turn @ f, turn @ m + np.cross(t[3::4], turn @ f)])
    assert np.allclose(x.T @ force, outer, atol=1e-12)


def test_small_changes_add() -> None:
    """(2.18) as corrected: prod(I + Delta_i) = I + sum Delta_i to first order."""
    changes = np.random.default_rng(1).uniform(-1e-4, 1e-4, (3, 6))
    deltas = [matrix(differential_operator(tuple(change))) for change in changes]
    product = np.linalg.multi_dot([np.eye(4) + delta for delta in deltas])
    assert np.abs(product - np.eye(4) - sum(deltas)).max() < 2e-7


# --- squaring up -------------------------------------------------------------------------------


@given(transforms, st.integers(3, 7))
def test_rounded_digits_are_squared_up_to_the_nearest_rotation(exact: Transform, k: int) -> None:
    rounded = Transform(*(round(element, k) for element in exact))
    found, correction = Transform.nearest_rotation(rounded)
    assert found.rigidity_error() < 1e-14
    assert found[3::4] == rounded[3::4]
    assert correction == max(abs(x - y) for x, y in zip(found, rounded, strict=True))
    assert correction <= 2.0 * 0.5 * 10.0**-k
    u, _, vt = np.linalg.svd(homogeneous(rounded)[:3, :3])
    assert np.allclose(homogeneous(found)[:3, :3], u @ vt, atol=1e-14)


def test_a_matrix_of_any_usual_shape_is_squared_up() -> None:
    exact = Transform.translation(0.3, 0.1, 0.2) @ Transform.rpy(0.3, -0.5, 0.7)
    for rows in (homogeneous(exact).tolist(), exact.rows(), exact):
        found, correction = Transform.nearest_rotation(rows)
        assert distance(found, exact) < 1e-15 and correction < 1e-15
    alone, _ = Transform.nearest_rotation(homogeneous(exact)[:3, :3].tolist())
    assert distance(alone, exact._replace(px=0.0, py=0.0, pz=0.0)) < 1e-15


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        ([[1, 0], [0, 1]], r"3 rows.*\[2, 2\]"),
        ([[1, 0, 0], [0, 1, 0], [0, 0, -1]], "left-handed"),
        ([[0, 0, 0]] * 3, "no rotation is within 0.05"),
        ([[1, 0, 0], [0, 1, 0], [0, 0, 2]], "no rotation is within 0.05"),
        ([[1, 0, 0], [0, 1, 0], [0, 0, 1e200]], "no rotation is within 0.05"),
        ([[1, 0, 0], [0, 1, 0], [0, 0, math.nan]], "not finite"),
        ([[1, 0, 0], [1, 0, 0], [0, 0, 1]], "no rotation is within 0.05"),
        ([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [1, 2, 3, 1]], "last row"),
    ],
)
def test_what_more_is_wrong_with_than_rounding_is_refused(
    rows: list[list[float]], told: str
) -> None:
    with pytest.raises(KinematicsError, match=told):
        Transform.nearest_rotation(rows)


@pytest.mark.parametrize("angle", [math.inf, -math.inf, math.nan])
def test_an_angle_that_is_not_finite_is_refused(angle: float) -> None:
    turns: list[Callable[[], Transform]] = [
        lambda: Transform.rotation((0.0, 0.0, 1.0), angle),
        lambda: Transform.rpy(0.0, angle, 0.0),
        lambda: Transform.euler(angle, 0.0, 0.0),
    ]
    for turned in turns:
        with pytest.raises(KinematicsError, match=r"angle -?(inf|nan).*give radians"):
            turned()
    with pytest.raises(KinematicsError, match="three numbers"):
        Transform.rotation((0.0, 1.0), 0.1)

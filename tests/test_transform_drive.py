"""The drive transform against reference segments, up to and at a half turn."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.golden import distance, golden

from rfms_can.transform import DriveTransform, Transform

CASES = golden("drive_transform")["cases"]
components = st.floats(-1.0, 1.0)
unit_axes = (
    st.tuples(components, components, components)
    .filter(lambda axis: math.hypot(*axis) > 0.1)
    .map(lambda axis: tuple(component / math.hypot(*axis) for component in axis))
)


@pytest.mark.parametrize("case", CASES, ids=[f"{i}-{c['tag'][:12]}" for i, c in enumerate(CASES)])
def test_segments_follow_the_reference(case: dict[str, object]) -> None:
    left, right, start = (Transform.from_rows(case[k]) for k in ("L", "R", "B"))  # type: ignore[arg-type]
    drive = DriveTransform.between(left, start, right)
    parameters = case["params"]
    assert isinstance(parameters, dict)
    x, y, z, psi = (parameters[k] for k in ("x", "y", "z", "psi"))
    assert drive.p == pytest.approx((x, y, z), abs=1e-12)
    assert drive.psi == pytest.approx(psi, abs=1e-12)
    assert isinstance(case["r"], list) and isinstance(case["D"], list)
    assert isinstance(case["T6"], list)
    for r, d, t6 in zip(case["r"], case["D"], case["T6"], strict=True):
        assert distance(drive.at(r), Transform.from_rows(d)) < 1e-10
        assert distance(left @ drive.at(r) @ right, Transform.from_rows(t6)) < 1e-10
    if psi > 1e-6:
        axis = case["axis"]
        assert isinstance(axis, list)
        assert drive.axis == pytest.approx(axis, abs=1e-12 / min(psi, math.sin(psi) + 0.1))


def test_it_starts_at_the_start_and_ends_at_the_goal() -> None:
    start = Transform.translation(0.1, -0.2, 0.3) @ Transform.rpy(0.4, -0.5, 0.6)
    drive = DriveTransform(start)
    assert drive.at(0.0) == Transform.identity()
    assert distance(drive.at(1.0), start) < 1e-15
    half_way = Transform.rotation(drive.axis, 0.5 * drive.psi)._replace(px=0.05, py=-0.1, pz=0.15)
    assert distance(drive.at(0.5), half_way) < 1e-15


@given(unit_axes, st.one_of(st.floats(0.0, math.pi), st.floats(0.0, 1e-6)))
def test_angle_and_axis_come_back_at_every_angle(
    axis: tuple[float, float, float], below: float
) -> None:
    for psi in (below, math.pi - below):
        drive = DriveTransform(Transform.rotation(axis, psi))
        assert drive.psi == pytest.approx(psi, abs=2e-10)
        assert distance(drive.at(1.0), Transform.rotation(axis, psi)) < 1e-9
        assert math.hypot(*drive.axis) == pytest.approx(1.0, abs=1e-12)
        if 1e-3 < psi < math.pi - 1e-6:
            assert drive.axis == pytest.approx(axis, abs=1e-9)


def test_an_exact_half_turn_keeps_its_axis() -> None:
    """The printed formulas lose it: 0.49 off at D(1)."""
    half_turn = Transform.from_rows([[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0]])
    drive = DriveTransform(half_turn)
    assert (drive.psi, drive.axis) == (math.pi, (1.0, 0.0, 0.0))
    assert distance(drive.at(1.0), half_turn) < 1e-15
    assert (drive.phi, drive.theta) == (0.0, math.pi / 2)


def test_no_rotation_is_about_z() -> None:
    drive = DriveTransform(Transform.translation(0.1, 0.2, 0.3))
    assert (drive.psi, drive.axis, drive.phi, drive.theta) == (0.0, (0.0, 0.0, 1.0), 0.0, 0.0)
    assert drive.at(0.5) == Transform.translation(0.05, 0.1, 0.15)


def test_the_axis_downwards_has_theta_pi() -> None:
    drive = DriveTransform(Transform.rotation((0.0, 0.0, -1.0), 0.7))
    assert drive.theta == math.pi

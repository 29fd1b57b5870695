"""COMPLY: what the arm is let go by, held to exact poses found another way; and its way back."""

import math
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from rfms_can.arm import PUMA_260, PUMA_560
from rfms_can.compliance import Selection, compliance_jacobian
from rfms_can.kinematics import direct, jacobian
from rfms_can.master.force.comply import MAX_DISPLACEMENT, MAX_ROTATION, Comply
from rfms_can.master.force.fade import Fade
from rfms_can.transform import Transform, differential_operator

Matrix = NDArray[np.float64]
Q = (0.3, 1.2, -2.9, 0.4, -0.9, 0.2)
TOOL = Transform.translation(0.02, -0.01, 0.12) @ Transform.rpy(0.4, -0.7, 1.1)
ALL = Selection(*(True,) * 6)
LIMITS = ((0.01, 0.002),) * 6
"""Speed and acceleration the way back may take, rad per cycle and cycle^2."""


def frame_jacobian(q: Sequence[float], E: Transform) -> Matrix:
    return compliance_jacobian(np.array(jacobian(PUMA_260, q)), E)


def exponential(change: Matrix) -> Matrix:
    """exp of a small Delta, by its series."""
    total = term = np.eye(4)
    for k in range(1, 12):
        term = term @ change / k
        total = total + term
    return np.asarray(total, dtype=np.float64)


def four(pose: Transform) -> Matrix:
    return np.array([*pose.rows(), [0.0, 0.0, 0.0, 1.0]])


def angles(q: Sequence[float]) -> tuple[float, float, float, float, float, float]:
    q1, q2, q3, q4, q5, q6 = q
    return (q1, q2, q3, q4, q5, q6)


# --- what is let go ----------------------------------------------------------------------------


def test_an_arm_pushed_where_it_complies_is_followed_by_its_set_point() -> None:
    """The thesis leaves the sign open. The arm is where it was pushed to, beside its set-point."""
    pushed = 0.004 * np.linalg.solve(frame_jacobian(Q, TOOL), [1.0, 0, 0, 0, 0, 0])
    comply = Comply(PUMA_260, math.inf)
    J = frame_jacobian((np.array(Q) + pushed).tolist(), TOOL)
    comply.accumulate((-pushed).tolist(), J, Selection.parse("fx"), TOOL)  # set-point less encoder
    assert comply.follow(Q) == pytest.approx(pushed.tolist(), rel=0.03, abs=1e-3)
    assert comply.amount(TOOL) == pytest.approx((0.004, 0, 0, 0, 0, 0), abs=1e-5)


def test_an_arm_pushed_where_it_is_rigid_is_not_followed() -> None:
    pushed = 0.004 * np.linalg.solve(frame_jacobian(Q, TOOL), [0.0, 1.0, 0, 0, 0, 0])
    comply = Comply(PUMA_260, math.inf)
    comply.accumulate((-pushed).tolist(), frame_jacobian(Q, TOOL), Selection.parse("fx rz"), TOOL)
    assert comply.follow(Q) == pytest.approx((0.0,) * 6, abs=1e-9)


def test_the_set_point_comes_to_the_arm_and_stays_there() -> None:
    """Errors taken again and again, as cycles do: nothing is left of them, nothing is added."""
    pushed = np.array([0.02, -0.015, 0.03, -0.02, 0.025, 0.03])
    comply = Comply(PUMA_260, math.inf)
    actual = np.array(Q) + pushed
    J = frame_jacobian(actual.tolist(), TOOL)
    for _ in range(8):
        displaced = np.array(Q) + np.array(comply.follow(Q))
        comply.accumulate((displaced - actual).tolist(), J, ALL, TOOL)
    assert comply.follow(Q) == pytest.approx(pushed.tolist(), abs=1e-12)
    seen = direct(PUMA_260, Q) @ comply.transform  # the other way: T6 = T_cmd X
    assert seen == pytest.approx(direct(PUMA_260, angles(actual.tolist())), abs=1e-12)


@given(st.tuples(*[st.floats(-1e-3, 1e-3)] * 6), st.integers(0, 63))
@settings(max_examples=40)
def test_what_is_added_is_the_exponential_of_delta_with_0_in_its_corner(
    errors: tuple[float, ...], bits: int
) -> None:
    """(2.16) prints a 1 there; COMPLY (I + Delta) would then lose its rotation."""
    selection = Selection.of(bool(bits >> i & 1) for i in range(6))
    comply, J = Comply(PUMA_260, math.inf), frame_jacobian(Q, TOOL)
    expected = np.eye(4)
    E = four(TOOL)
    for _ in range(3):
        comply.accumulate(errors, J, selection, TOOL)
        dx, dy, dz, rx, ry, rz = np.where(selection.mask, -(J @ errors), 0.0).tolist()
        delta = np.array(differential_operator((dx, dy, dz, rx, ry, rz)))
        assert delta[3, 3] == 0.0
        expected = expected @ E @ exponential(delta) @ np.linalg.inv(E)
    size = max(abs(J @ errors))
    assert four(comply.transform) == pytest.approx(expected, abs=4.0 * size * size + 1e-12)


def test_a_hundred_thousand_steps_leave_it_a_rotation() -> None:
    comply, J = Comply(PUMA_260, math.inf), frame_jacobian(Q, TOOL)
    rng = np.random.default_rng(1)
    for step in rng.normal(scale=1e-3, size=(100_000, 6)).tolist():
        comply.accumulate(step, J, ALL, TOOL)
    assert comply.transform.rigidity_error() < 1e-14


@given(st.tuples(*[st.floats(-0.08, 0.08)] * 3), st.tuples(*[st.floats(-0.3, 0.3)] * 3))
@settings(max_examples=40)
def test_inverse_and_direct_kinematics_meet(
    shift: tuple[float, ...], turn: tuple[float, ...]
) -> None:
    """Joint displacements on the wire put T6 where COMPLY says: T6 = T_cmd X."""
    comply = Comply(PUMA_260, math.inf)
    comply.transform = Transform.translation(*shift) @ Transform.rpy(*turn)
    moved = [a + b for a, b in zip(Q, comply.follow(Q), strict=True)]
    assert direct(PUMA_260, angles(moved)) == pytest.approx(
        direct(PUMA_260, Q) @ comply.transform, abs=1e-11
    )


def test_along_a_commanded_way_the_tool_keeps_what_it_was_let_go_by() -> None:
    comply = Comply(PUMA_260, math.inf)
    comply.transform = Transform.translation(0.01, 0.0, -0.02) @ Transform.rpy(0.05, 0.1, 0.0)
    before = np.array(comply.follow(Q))
    for k in range(1, 50):
        theta = angles([a + 0.004 * k for a in Q])
        displaced = np.array(comply.follow(theta))
        assert np.abs(displaced - before).max() < 2e-3  # no joint jumps to another branch
        before = displaced
        moved = angles((np.array(theta) + displaced).tolist())
        assert direct(PUMA_260, moved) == pytest.approx(
            direct(PUMA_260, theta) @ comply.transform, abs=1e-11
        )


@given(st.tuples(*[st.floats(-0.02, 0.02)] * 3), st.tuples(*[st.floats(-0.1, 0.1)] * 3))
@settings(max_examples=30)
def test_it_is_told_along_the_axes_of_any_compliance_frame(
    shift: tuple[float, ...], turn: tuple[float, ...]
) -> None:
    """How the frame itself moves, seen from where it was, against COMPLY seen from T6."""
    comply = Comply(PUMA_260, math.inf)
    moved = Transform.translation(*shift) @ Transform.rotation((1.0, 2.0, -1.0), turn[0])
    comply.transform = TOOL @ moved @ TOOL.inverse()
    x, y, z, rx, ry, rz = comply.amount(TOOL)
    assert (x, y, z) == pytest.approx(shift, abs=1e-12)
    axis = np.array([1.0, 2.0, -1.0]) / math.sqrt(6.0)
    assert (rx, ry, rz) == pytest.approx((turn[0] * axis).tolist(), abs=2e-4)


def test_a_pose_that_cannot_be_reached_is_not_followed() -> None:
    comply = Comply(PUMA_260, 0.004)
    comply.transform = Transform.translation(0.0, 0.0, 0.9)
    assert comply.follow(Q) == (0.0,) * 6


@pytest.mark.parametrize(
    ("gone", "words"),
    [
        (
            Transform.translation(0.0, -1.01 * MAX_DISPLACEMENT, 0.0),
            r"0\.202 m and 0\.00 rad",
        ),
        (Transform.rotation((0, 1, 0), 1.01 * MAX_ROTATION), r"0\.000 m and 0\.61 rad"),
    ],
)
def test_gone_too_far_is_said_with_the_bound_and_a_way_out(gone: Transform, words: str) -> None:
    comply = Comply(PUMA_260, math.inf)
    comply.transform = gone
    assert comply.limit_violation() is not None
    with pytest.raises(AssertionError, match=words + r", 0\.2 m and 0\.6 rad at most: comply only"):
        raise AssertionError(comply.limit_violation())
    comply.transform = Transform.translation(
        0.0, 0.99 * MAX_DISPLACEMENT, 0.0
    ) @ Transform.rotation((0, 0, 1), 0.99 * MAX_ROTATION)
    assert comply.limit_violation() is None


# --- the way back ------------------------------------------------------------------------------


@given(st.tuples(*[st.floats(-0.4, 0.4)] * 6), st.integers(1, 200))
@settings(max_examples=40)
def test_a_fade_keeps_the_limits_and_ends_at_zero_exactly(
    displacement: tuple[float, ...], least: int
) -> None:
    fade = Fade(displacement, LIMITS, least)
    way = [displacement]
    while not fade.over:
        way.append(fade.step())
    assert len(way) - 1 >= least
    assert way[-1] == (0.0,) * 6
    q = np.array([displacement] * 3 + way + [(0.0,) * 6] * 3)
    speed, acceleration = (np.abs(np.diff(q, n=n, axis=0)).max(axis=0) for n in (1, 2))
    assert (speed <= LIMITS[0][0] * 1.001).all()
    assert (acceleration <= LIMITS[0][1] * 1.001).all()
    assert (np.diff(np.abs(q), axis=0) <= 1e-15).all()  # never away from zero


def test_a_fade_begins_and_ends_without_a_jump_of_its_acceleration() -> None:
    fade = Fade((0.3,) * 6, LIMITS, 100)
    way = [0.3] * 4 + [fade.step()[0] for _ in range(100)]
    way += [0.0] * 4
    jerk = np.abs(np.diff(way, n=3))
    inside = jerk[8:-8].max()
    assert jerk.max() < 1.6 * inside  # a quintic's largest jerk is at its ends, and finite
    assert jerk.max() < 60.0 * 0.3 / 100.0**3 * 1.1


def let_go(comply: Comply, theta: Sequence[float] = Q) -> tuple[float, ...]:
    """Let the arm be displaced by a centimetre and a tenth of a radian; joint displacements."""
    comply.transform = Transform.translation(0.01, -0.005, 0.01) @ Transform.rpy(0.1, 0.0, 0.05)
    return comply.follow(angles(theta))


def test_faded_it_is_gone() -> None:
    comply = Comply(PUMA_260, math.inf)
    let_go(comply)
    comply.fade(LIMITS, 10)
    comply.fade(LIMITS, 10)  # asked for every cycle: it began with the first
    steps = 0
    while comply.active:
        last = comply.follow(Q)
        steps += 1
    assert last == (0.0,) * 6
    assert 10 <= steps < 60
    assert comply.transform == Transform.identity()


def test_on_its_way_back_it_is_what_is_left() -> None:
    """Transform and joint displacement say the same, also in the middle of a fade."""
    comply = Comply(PUMA_260, math.inf)
    let_go(comply)
    comply.fade(LIMITS, 20)
    theta = Q
    for k in range(12):
        theta = angles([a + 0.003 * k for a in Q])
        displacement = comply.follow(theta)
        moved = angles([a + b for a, b in zip(theta, displacement, strict=True)])
        assert direct(PUMA_260, theta) @ comply.transform == pytest.approx(
            direct(PUMA_260, moved), abs=1e-12
        )
    assert abs(comply.amount(Transform.identity())[0]) < 0.006


def test_complying_again_on_the_way_back_goes_on_from_there() -> None:
    comply = Comply(PUMA_260, math.inf)
    first = np.array(let_go(comply))
    comply.fade(LIMITS, 40)
    for _ in range(20):
        half = np.array(comply.follow(Q))
    assert np.abs(half).max() < 0.6 * np.abs(first).max()
    comply.accumulate((0.0,) * 6, frame_jacobian(Q, TOOL), ALL, TOOL)
    assert comply.follow(Q) == pytest.approx(half.tolist(), abs=1e-12)
    assert comply.follow(Q) == pytest.approx(half.tolist(), abs=1e-12)  # no fade goes on


def test_an_arm_that_was_not_let_go_has_no_way_back() -> None:
    comply = Comply(PUMA_560, math.inf)
    comply.fade(LIMITS, 10)
    assert not comply.active
    assert comply.follow(Q) == (0.0,) * 6

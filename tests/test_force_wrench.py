"""Wrenches between frames, and the weight of a load: each against another way to a number."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfms_can.arm import PUMA_560, Load
from rfms_can.compliance import compliance_jacobian
from rfms_can.dynamics.model import make_dynamics
from rfms_can.dynamics.rigid_body import GRAVITY
from rfms_can.kinematics import direct, jacobian
from rfms_can.master.force.wrench import in_frame, weight
from rfms_can.transform import Transform, differential_transform

six = st.tuples(*[st.floats(-50.0, 50.0)] * 6)
three = st.tuples(*[st.floats(-1.0, 1.0)] * 3)
angles = st.tuples(*[st.floats(-3.0, 3.0)] * 6)


@given(six, three, three)
def test_it_is_the_transpose_of_the_differential_transform_of_the_way_back(
    wrench: tuple[float, ...], p: tuple[float, ...], turn: tuple[float, ...]
) -> None:
    """(2.20): F = X^T (cF), X takes velocities of the outer frame to the inner one."""
    E = Transform.translation(*p) @ Transform.rpy(*turn)
    inner = in_frame(wrench, E)
    X = np.array(differential_transform(E))
    assert (X.T @ inner).tolist() == pytest.approx(wrench, abs=1e-9)
    back = np.array(differential_transform(E.inverse())).T @ wrench
    assert inner == pytest.approx(back.tolist(), abs=1e-9)


@given(six, six, three, three)
def test_power_is_the_same_in_both_frames(
    wrench: tuple[float, ...],
    velocity: tuple[float, ...],
    p: tuple[float, ...],
    turn: tuple[float, ...],
) -> None:
    E = Transform.translation(*p) @ Transform.rpy(*turn)
    there = np.array(differential_transform(E)) @ velocity
    assert np.dot(in_frame(wrench, E), there) == pytest.approx(np.dot(wrench, velocity), abs=1e-8)


@given(six, six, three)
def test_joints_feel_the_same_torques_of_it(
    q: tuple[float, ...], wrench: tuple[float, ...], p: tuple[float, ...]
) -> None:
    """Virtual work through the joints: J^T f is one torque, whatever frame f is told in."""
    E = Transform.translation(*p) @ Transform.rpy(0.3, -0.4, 0.5)
    J = np.array(jacobian(PUMA_560, q))
    there = compliance_jacobian(J, E).T @ in_frame(wrench, E)
    assert there.tolist() == pytest.approx((J.T @ wrench).tolist(), abs=1e-8)


def test_a_force_beside_a_frame_turns_it() -> None:
    """10 N along y at T6; half a metre along x from it that is -5 N m about z, seen turned."""
    E = Transform.translation(0.5, 0.0, 0.0) @ Transform.rotation((1, 0, 0), np.pi / 2)
    assert in_frame((0, 10.0, 0, 0, 0, 0), E) == pytest.approx((0, 0, -10.0, 0, -5.0, 0))


@given(angles, st.floats(0.1, 8.0), three)
def test_a_load_weighs_what_the_model_holds(
    q: tuple[float, ...], mass: float, centre: tuple[float, ...]
) -> None:
    """The wrench the plain way, and Pinocchio's gravity torques of the loaded arm."""
    load = Load(mass, (centre[0], centre[1], centre[2]))
    dynamics = make_dynamics(PUMA_560, "full")
    dynamics.update(q)
    bare = dynamics.g.copy()
    dynamics.carry(load)
    dynamics.update(q)
    held = dynamics.g - bare
    T6 = direct(PUMA_560, q)
    felt = -np.array(jacobian(PUMA_560, q)).T @ weight(load, T6)
    assert held.tolist() == pytest.approx(felt.tolist(), abs=1e-8)
    x, y, z, *_ = weight(load, T6)
    assert np.hypot(np.hypot(x, y), z) == pytest.approx(mass * GRAVITY)

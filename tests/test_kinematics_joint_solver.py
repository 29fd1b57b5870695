"""A joint node's own solution: the full one's digits, alone, and never an exception."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from support.golden import ARMS, distance, golden

from rfms_can.arm import PUMA_260, PUMA_560, Arm
from rfms_can.errors import JointLimitError, KinematicsError, UnreachableError
from rfms_can.kinematics import (
    CONFIGURATIONS,
    EXACT,
    Configuration,
    InverseKinematics,
    Joints,
    JointSolver,
    configuration_of,
    direct,
    singularity_margins,
    within_limits,
)
from rfms_can.transform import Transform

poses = st.tuples(*(st.floats(-math.pi, math.pi),) * 6)
each_arm = pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)


def nodes(arm: Arm) -> list[JointSolver]:
    return [JointSolver(arm, joint) for joint in range(1, 7)]


def on_the_wire(t6: Transform) -> Transform:
    """T6 as a node receives it."""
    o, a, p = (np.array(t6[column::4], np.float32).tolist() for column in (1, 2, 3))
    return Transform.from_o_a_p(o, a, p)


@pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
@given(q=poses, configuration=st.sampled_from(CONFIGURATIONS))
def test_six_nodes_find_what_the_full_solution_finds_to_the_last_digit(
    arm: Arm, q: Joints, configuration: Configuration
) -> None:
    t6 = direct(arm, q)
    try:
        expected = InverseKinematics(arm).solve(t6, configuration, q)
    except KinematicsError:
        assume(False)
    alone = [JointSolver(arm, joint, EXACT) for joint in range(1, 7)]
    for solver in alone[3:]:
        solver.hold(q[3])
    assert [s.solve(t6, configuration, p) for s, p in zip(alone, q, strict=True)] == [*expected]


@each_arm
def test_float32_set_points_give_the_pose_to_a_tenth_of_a_count(arm: Arm) -> None:
    for case in golden(f"{arm.name}_kinematics")["cases"]:
        q = case["q"]
        margins = singularity_margins(arm, q)
        if min(abs(margins.elbow), abs(margins.shoulder) / arm.a2, abs(margins.wrist)) < 0.05:
            continue
        if not all(within_limits(arm, q)):
            continue
        t6, configuration = on_the_wire(direct(arm, q)), configuration_of(arm, q)
        angles = [s.solve(t6, configuration, p) for s, p in zip(nodes(arm), q, strict=True)]
        assert distance(angles, q) < 1e-5


@each_arm
def test_nodes_told_theta4_hold_it_at_a_singular_wrist(arm: Arm) -> None:
    compared = 0
    for case in golden(f"{arm.name}_kinematics")["wrist_singular"]:
        t6 = on_the_wire(Transform.from_rows(case["T6"]))
        expected = case["q_expected"]
        if not all(within_limits(arm, expected)):
            continue
        compared += 1
        configuration = Configuration.parse(case["configuration"])
        six = nodes(arm)
        for solver in six:
            solver.hold(expected[3])
        angles = [s.solve(t6, configuration, p) for s, p in zip(six, expected, strict=True)]
        assert angles[3] == pytest.approx(expected[3], abs=1e-15)
        assert distance(angles, expected) < 2e-5
    assert compared >= 5


def test_nodes_pass_through_a_singular_wrist_together() -> None:
    """Joint 5 swings through zero: theta4 stays, theta6 stays, the pose is the one commanded."""
    six = nodes(PUMA_260)
    q = [0.3, 1.1, -0.7, 0.5, 0.2, -0.4]
    for step in range(1, 201):
        wanted = [*q[:4], 0.2 - 2e-3 * step, q[5]]
        noflip = wanted[4] > -1e-9
        t6 = direct(PUMA_260, wanted)
        configuration = configuration_of(PUMA_260, wanted)._replace(noflip=noflip)
        angles = [s.solve(t6, configuration, p) for s, p in zip(six, wanted, strict=True)]
        assert distance(angles, wanted) < 1e-9


def test_the_held_theta4_is_refreshed_by_every_pose_but_a_lost_one() -> None:
    q = (0.3, 1.1, -0.7, 0.5, 0.4, -0.4)
    configuration = configuration_of(PUMA_260, q)
    singular = direct(PUMA_260, (0.3, 1.1, -0.7, 0.0, 0.0, 0.1))
    lost = direct(PUMA_260, q)._replace(px=math.nan)
    far = direct(PUMA_260, q)._replace(pz=9.0)
    node6 = JointSolver(PUMA_260, 6)
    assert node6.solve(singular, configuration, 0.0) == pytest.approx(0.1)  # holds zero
    node6.solve(direct(PUMA_260, q), configuration, 0.0)
    for nothing in (lost, far):
        assert math.isnan(node6.solve(nothing, configuration, 0.0))
    assert node6.solve(singular, configuration, 0.0) == pytest.approx(0.1 - 0.5)


@pytest.mark.parametrize("joint", range(1, 7))
@given(
    elements=st.lists(st.floats(width=64), min_size=12, max_size=12),
    configuration=st.sampled_from(CONFIGURATIONS),
    previous=st.floats(),
)
def test_a_node_never_raises_on_what_the_bus_sends(
    joint: int, elements: list[float], configuration: Configuration, previous: float
) -> None:
    for arm in ARMS:
        solver = JointSolver(arm, joint)
        angle = solver.solve(Transform(*elements), configuration, previous)
        low, high = arm.joint_limits[joint - 1]
        assert math.isnan(angle) or low - 1e-5 <= angle <= high + 1e-5


def test_a_node_says_why_it_has_no_angle() -> None:
    q = (0.3, 1.1, -0.7, 0.5, 0.4, -0.4)
    t6, configuration = direct(PUMA_260, q), configuration_of(PUMA_260, q)
    node1, node5 = JointSolver(PUMA_260, 1), JointSolver(PUMA_260, 5)
    assert node1.refusal(t6, configuration) is None
    assert isinstance(node1.refusal(t6._replace(pz=9.0), configuration), UnreachableError)
    folded = direct(PUMA_260, (*q[:4], 2.5, q[5]))
    assert math.isnan(node5.solve(folded, configuration, 0.4))
    refusal = node5.refusal(folded, configuration)
    assert isinstance(refusal, JointLimitError) and "joint 5" in str(refusal)


@each_arm
def test_what_the_master_accepts_at_the_border_the_nodes_accept(arm: Arm) -> None:
    """Stretched arm and joint at its stop, sent as float32."""
    stretched = math.atan2(-arm.d4, arm.a3)
    stop = arm.joint_limits[0][1]
    accepted = 0
    for theta2 in np.linspace(-0.5, 1.0, 40):
        q = (stop, float(theta2), stretched, 0.3, 0.7, 0.2)
        t6 = direct(arm, q)
        for configuration in CONFIGURATIONS[:4]:
            try:
                InverseKinematics(arm).solve(t6, configuration, q)
            except KinematicsError:
                continue
            accepted += 1
            for solver, previous in zip(nodes(arm)[:3], q[:3], strict=True):
                assert not math.isnan(solver.solve(on_the_wire(t6), configuration, previous))
    assert accepted > 40


def test_every_turn_of_joint_4_is_followed() -> None:
    """Once round and on, past +-pi, without a jump."""
    node4 = JointSolver(PUMA_560, 4)
    low, high = PUMA_560.joint_limits[3]
    theta4 = low + 0.01
    while theta4 < high:
        q = (0.3, 1.1, -0.7, theta4, 0.4, -0.4)
        found = node4.solve(direct(PUMA_560, q), configuration_of(PUMA_560, q), theta4 - 0.02)
        assert found == pytest.approx(theta4, abs=1e-12)
        theta4 += 0.02

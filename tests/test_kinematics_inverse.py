"""The inverse solution: eight branches, round trips, refusals by name, turns and limits."""

import math
from dataclasses import replace

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from support.golden import ARMS, distance, golden, turned_distance

from rfms_can.arm import PUMA_260, PUMA_560, Arm
from rfms_can.errors import JointLimitError, KinematicsError, UnreachableError
from rfms_can.kinematics import (
    CONFIGURATIONS,
    Configuration,
    InverseKinematics,
    Joints,
    configuration_of,
    direct,
    inverse,
    inverse_all,
    nearest_turn,
    singularity_margins,
    within_limits,
)
from rfms_can.transform import Transform

OTHER = replace(PUMA_560, name="other", a2=0.31, a3=-0.07, d2=0.02, d3=-0.11, d4=0.44)
"""The same structure with none of the PUMAs' lengths: a3 and the offset negative."""

THREE_ARMS = (*ARMS, OTHER)
each_arm = pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
poses = st.tuples(*(st.floats(-math.pi, math.pi),) * 6)
LEFT_UP = Configuration(left=True, up=True, noflip=True)


def least_margin(arm: Arm, q: Joints) -> float:
    elbow, shoulder, wrist = (abs(margin) for margin in singularity_margins(arm, q))
    return min(elbow, shoulder / arm.a2, wrist)


def nearest_to_zero(arm: Arm, q: Joints) -> list[float]:
    return [nearest_turn(a, 0.0, *limits) for a, limits in zip(q, arm.joint_limits, strict=True)]


@each_arm
def test_all_eight_branches_are_the_reference(arm: Arm) -> None:
    compared = 0
    for case in golden(f"{arm.name}_kinematics")["reachable"]:
        t6 = Transform.from_rows(case["T6"])
        branches = inverse_all(arm, t6)
        assert len(case["branches"]) == 8
        for branch in case["branches"]:
            q = branches[Configuration.parse(branch["configuration"])]
            # T6 is given to 1e-13: what a singularity near by makes of that is not ours.
            assert turned_distance(q, branch["q"]) < 1e-9 + 1e-12 / least_margin(arm, q)
            assert distance(direct(arm, q), t6) < 2e-12
            assert str(configuration_of(arm, q)) == branch["configuration"]
            assert [*map(math.isfinite, nearest_to_zero(arm, q))] == branch["within_limits"]
            compared += least_margin(arm, q) > 1e-3
    assert compared > 750


@pytest.mark.parametrize("arm", THREE_ARMS, ids=lambda arm: arm.name)
@given(q=poses)
def test_every_pose_comes_back_in_every_configuration(arm: Arm, q: Joints) -> None:
    assume(least_margin(arm, q) > 1e-3)
    t6 = direct(arm, q)
    branches = inverse_all(arm, t6)
    for configuration, solution in branches.items():
        assert distance(direct(arm, solution), t6) < 1e-11
        if least_margin(arm, solution) > 1e-3:
            assert configuration_of(arm, solution) == configuration
    assert turned_distance(branches[configuration_of(arm, q)], q) < 1e-9


@pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
@given(share=st.tuples(*(st.floats(0.0, 1.0),) * 6))
def test_a_pose_within_limits_is_found_again_from_where_it_stood(arm: Arm, share: Joints) -> None:
    q = tuple(
        low + part * (high - low) for part, (low, high) in zip(share, arm.joint_limits, strict=True)
    )
    q1, q2, q3, q4, q5, q6 = q
    assume(least_margin(arm, (q1, q2, q3, q4, q5, q6)) > 1e-3)
    assert distance(inverse(arm, direct(arm, q), configuration_of(arm, q), q), q) < 1e-9


@each_arm
def test_unreachable_poses_are_refused_by_reason_number_and_bound(arm: Arm) -> None:
    reasons = set()
    for case in golden(f"{arm.name}_kinematics")["unreachable"]:
        t6 = Transform.from_rows(case["T6"])
        if case["reason"] == "joint_limits":
            continue
        reasons.add(case["reason"])
        for configuration in CONFIGURATIONS:
            with pytest.raises(UnreachableError, match=f"{arm.name}: {case['reason']}: ") as error:
                inverse(arm, t6, configuration)
        for number in (case["value"], case["limit"]) if case["value"] else ():
            assert f"{number:.3g}" in str(error.value) or f"{number:.9g}" in str(error.value)
    assert {"shoulder_cylinder", "too_far"} < reasons
    assert len(reasons) == 3  # and shoulder_point on the 260, too_near on the 560


@each_arm
def test_a_joint_out_of_range_is_named_with_angle_and_range(arm: Arm) -> None:
    seen = 0
    for case in golden(f"{arm.name}_kinematics")["unreachable"]:
        if case["reason"] != "joint_limits":
            continue
        t6 = Transform.from_rows(case["T6"])
        for configuration, q in inverse_all(arm, t6).items():
            turns = nearest_to_zero(arm, q)
            joints = [joint for joint, angle in enumerate(turns, 1) if math.isnan(angle)]
            seen += 1
            with pytest.raises(JointLimitError) as error:
                inverse(arm, t6, configuration)
            angle = math.remainder(q[joints[0] - 1], math.tau)
            low, high = arm.joint_limits[joints[0] - 1]
            for part in (
                *(f"joint {joints[0]} ", f"{angle:.6g} rad", f"{math.degrees(angle):.4g} deg"),
                *(f"[{low:.6g}, {high:.6g}] rad", f"{math.degrees(high):.4g}] deg"),
            ):
                assert part in str(error.value)
    assert seen == 24


@each_arm
def test_a_singular_wrist_holds_theta4_and_says_so(arm: Arm) -> None:
    solver = InverseKinematics(arm)
    for case in golden(f"{arm.name}_kinematics")["wrist_singular"]:
        t6 = Transform.from_rows(case["T6"])
        configuration = Configuration.parse(case["configuration"])
        expected = case["q_expected"]
        held = (math.cos(expected[3]), math.sin(expected[3]))
        for noflip in (True, False):
            branch = configuration._replace(noflip=noflip)
            assert turned_distance(solver.branch(t6, branch, held), expected) < 1e-9
            if all(within_limits(arm, expected)):
                q = solver.solve(t6, branch, expected)
                assert q[3] == pytest.approx(expected[3], abs=1e-15)
                assert distance(q, expected) < 1e-9
            said = str(solver.wrist_singularity(t6, branch))
            assert said.startswith(f"{arm.name}: wrist singularity") and "1e-05" in said


@pytest.mark.parametrize(("theta5", "sign"), [(0.0, 1.0), (math.pi, -1.0)])
def test_theta6_takes_the_sum_or_with_the_hand_folded_back_the_difference(
    theta5: float, sign: float
) -> None:
    """Folded back is beyond the 260's range: the branch itself is asked."""
    t6 = direct(PUMA_260, (0.2, 1.0, -0.5, 0.7, theta5, -0.3))
    held = 0.25
    q = InverseKinematics(PUMA_260).branch(t6, LEFT_UP, (math.cos(held), math.sin(held)))
    assert q[3] == pytest.approx(held)
    assert abs(q[4]) == pytest.approx(theta5)
    assert q[5] == pytest.approx(-0.3 + sign * (0.7 - held))


def test_away_from_the_singularity_there_is_nothing_to_say() -> None:
    q = (0.2, 1.0, -0.5, 0.7, 2e-5, -0.3)
    solver = InverseKinematics(PUMA_260)
    assert solver.wrist_singularity(direct(PUMA_260, q), configuration_of(PUMA_260, q)) is None


def test_the_border_of_the_reach_belongs_to_it() -> None:
    """Stretched arm: acos would need luck, the triangle's square root does not."""
    for q in ((0.3, 0.8, -math.pi / 2, 0.1, 0.7, 0.2), (0.3, 0.5, -math.pi / 2, 0.1, 0.7, 0.2)):
        t6 = direct(PUMA_260, q)
        for configuration in CONFIGURATIONS:
            solution = InverseKinematics(PUMA_260).branch(t6, configuration)
            assert distance(direct(PUMA_260, solution), t6) < 1e-8
    too_far = t6._replace(pz=t6.pz + 1e-6)
    with pytest.raises(UnreachableError, match="too_far"):
        inverse(PUMA_260, too_far, LEFT_UP)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_refused(bad: float) -> None:
    t6 = direct(PUMA_260, (0.2, 1.0, -0.5, 0.7, 0.4, -0.3))
    for element in range(12):
        broken = Transform(*(bad if i == element else e for i, e in enumerate(t6)))
        with pytest.raises(KinematicsError, match="not finite"):
            inverse(PUMA_260, broken, LEFT_UP)
    with pytest.raises(UnreachableError, match="too_far"):
        inverse(PUMA_260, t6._replace(pz=1e308), LEFT_UP)


def test_a_previous_that_is_not_finite_is_refused() -> None:
    t6 = direct(PUMA_260, (0.2, 1.0, -0.5, 0.7, 0.4, -0.3))
    with pytest.raises(KinematicsError, match=r"previous .* not finite"):
        inverse(PUMA_260, t6, LEFT_UP, (0.0, 0.0, 0.0, math.nan, 0.0, 0.0))


class TestTurns:
    """Joints 4 and 6 turn more than once round: which turn is meant."""

    def test_the_nearest_to_the_previous(self) -> None:
        assert nearest_turn(-3.0, 3.2, -5.4, 5.4) == pytest.approx(-3.0 + math.tau)
        assert nearest_turn(3.0, -3.2, -5.4, 5.4) == pytest.approx(3.0 - math.tau)
        assert nearest_turn(1.0, 1.5, -5.4, 5.4) == 1.0

    def test_the_nearest_inside_the_range_when_the_nearest_is_not(self) -> None:
        assert nearest_turn(-0.8, 5.3, -5.4, 5.4) == pytest.approx(-0.8)  # 5.483 is beyond
        assert nearest_turn(0.8, -5.3, -5.4, 5.4) == pytest.approx(0.8)

    def test_none(self) -> None:
        assert math.isnan(nearest_turn(3.0, 0.0, -2.0, 2.0))
        assert math.isnan(nearest_turn(math.nan, 0.0, -2.0, 2.0))
        assert math.isnan(nearest_turn(0.0, math.inf, -2.0, 2.0))

    @given(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0))
    def test_no_turn_inside_the_range_is_nearer(self, angle: float, previous: float) -> None:
        taken = nearest_turn(angle, previous, -5.4, 5.4)
        candidates = [angle + k * math.tau for k in range(-5, 6)]
        inside = [c for c in candidates if -5.4 <= c <= 5.4]
        nearest = min(abs(c - previous) for c in inside)
        assert abs(taken - previous) == pytest.approx(nearest, abs=1e-12)


class TestConfiguration:
    def test_words_in_any_order(self) -> None:
        for configuration in CONFIGURATIONS:
            words = str(configuration).split()
            assert Configuration.parse(" ".join(reversed(words))) == configuration
            assert Configuration.from_code(configuration.code) == configuration
        assert [c.code for c in CONFIGURATIONS] == list(range(8))
        assert str(CONFIGURATIONS[0]) == "left up noflip"

    @pytest.mark.parametrize(
        "text",
        ["", "left up", "left up flip noflip", "left right up", "left up flap", "LEFT up flip"],
    )
    def test_the_error_lists_the_words(self, text: str) -> None:
        with pytest.raises(KinematicsError, match=r"left\|right, up\|down, flip\|noflip"):
            Configuration.parse(text)

"""Poles, determinants and counts of Chapter V.6 against an independent implementation."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from support.golden import golden

from rfms_can.analysis.stability import (
    Verdict,
    growth,
    pid_loop,
    poles,
    random_poses,
    state_matrix,
    verdict,
    weighted_loop,
)
from rfms_can.analysis.stability.characteristic import (
    delta_by_blocks,
    delta_by_columns,
    delta_by_joints,
    delta_by_state,
    delta_closed,
)
from rfms_can.arm import PUMA_260, PUMA_560
from rfms_can.compliance import Selection, compliance_jacobian, hybrid_rows
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.kinematics import singularity_margins
from rfms_can.transform import Transform

Matrix = NDArray[np.float64]

NATURAL = {
    "uniform_wn25_zeta1": (25.0,) * 6,
    "mixed_wn_zeta1": (12.0, 12.0, 15.0, 30.0, 35.0, 40.0),
}
"""The gains' natural frequencies: with gains of ten digits, double poles would part by 1e-3."""

STATISTICS_WORDS = (
    *("100000", "010000", "001000", "110000", "110110"),
    *("001001", "111000", "000111", "011100", "111110"),
)


def selection_of(word: str) -> Selection:
    return Selection.of(s == "1" for s in word)


def frame_jacobian(dynamics: ArmDynamics, tool: float) -> Matrix:
    return compliance_jacobian(dynamics.J, Transform.translation(0.0, 0.0, tool))


def farthest(a: NDArray[np.complex128], b: NDArray[np.complex128]) -> float:
    """Largest distance of a pole from the nearest of the other spectrum, both ways."""
    apart = np.abs(a[:, np.newaxis] - b)
    return float(max(apart.min(axis=0).max(), apart.min(axis=1).max()))


def test_golden_poles() -> None:
    data: dict[str, Any] = golden("puma260_compliance")
    dynamics, unstable = ArmDynamics(PUMA_260), 0
    for pose in data["poses"]:
        dynamics.update(pose["q"])
        for case in pose["cases"]:
            selection = selection_of(case["word"])
            C = hybrid_rows(frame_jacobian(dynamics, case["tool"]), selection, dynamics.M).errors
            for name, natural in NATURAL.items():
                d = np.array(data["gains"][name]["D"])
                wn = np.array(natural)
                loop = pid_loop(np.diag(d), C, d * wn**2, 2.0 * d * wn, selection.size)
                expected = np.array(case[f"eig_{name}"]) @ np.array([1.0, 1.0j])
                assert farthest(poles(loop), expected) < 5e-5  # double ones: rounding's root
                assert (verdict(loop) is Verdict.UNSTABLE) == (expected.real.max() > 1e-5)
                unstable += verdict(loop) is Verdict.UNSTABLE
    assert unstable == 29  # mixed gains with a tool; none without


def test_golden_poles_are_those_of_the_state_matrix() -> None:
    """The reduction leaves out poles at 0 and changes no other."""
    data: Any = golden("stability_special_case")
    worst = data["instability_statistics"]["unequal_D_equal_Kp|tool=0.0"]["worst"]
    g = data["gains"]["unequal_D_equal_Kp"]
    dynamics = ArmDynamics(PUMA_260)
    dynamics.update(worst["q"])
    selection = selection_of(worst["word"])
    C = hybrid_rows(frame_jacobian(dynamics, worst["tool"]), selection, dynamics.M).errors
    loop = pid_loop(np.diag(g["D"]), C, g["Kp"], g["Kd"], selection.size)
    whole = np.linalg.eigvals(state_matrix(loop)).astype(np.complex128)
    assert farthest(poles(loop), whole) < 1e-4
    assert growth(poles(loop)) == pytest.approx(worst["max_real"], rel=1e-5)


@pytest.mark.parametrize("key", ["arm_wn10_wrist_wn40|tool=0.1", "unequal_D_equal_Kp|tool=0.1"])
def test_the_worst_poses_are_as_unstable_as_reported(key: str) -> None:
    data: Any = golden("stability_special_case")
    worst, g = (
        data["instability_statistics"][key]["worst"],
        data["gains"][key.split("|", maxsplit=1)[0]],
    )
    dynamics = ArmDynamics(PUMA_260)
    dynamics.update(worst["q"])
    selection = selection_of(worst["word"])
    J = frame_jacobian(dynamics, worst["tool"])
    C = hybrid_rows(J, selection, dynamics.M, limit=1e6).errors  # the thesis' own, undamped
    loop = pid_loop(np.diag(g["D"]), C, g["Kp"], g["Kd"], selection.size)
    assert growth(poles(loop)) == pytest.approx(worst["max_real"], rel=1e-5)


def test_golden_determinants_of_the_special_case() -> None:
    """(5.22), (5.23), (5.24), (5.30) and (5.35), with the factor |D| |J^-1| between them."""
    data: Any = golden("stability_special_case")
    s = complex(*data["lambda_test"])
    dynamics = ArmDynamics(PUMA_260)
    names = sorted(data["gains"])
    for case in data["cases"]:
        dynamics.update(case["q"])
        J, selection = dynamics.J, selection_of(case["word"])
        C = np.linalg.inv(J) @ np.diag(~selection.mask) @ J
        reference = complex(*case["delta_5_22"])
        for name in names:
            g = data["gains"][name]
            D, Kp, Kd = g["D"], g["Kp"], g["Kd"]
            state = delta_by_state(s, state_matrix(pid_loop(np.diag(D), C, Kp, Kd, selection.size)))
            assert delta_by_joints(s, J, selection, D, Kp, Kd) == pytest.approx(state, rel=1e-6)
            factor = complex(np.prod(D) / np.linalg.det(J))
            columns = delta_by_columns(s, J, selection, D, Kp, Kd)
            assert columns == pytest.approx(factor * state, rel=1e-6)
            assert delta_by_blocks(s, J, selection, D, Kp, Kd) == pytest.approx(columns, rel=1e-6)
            if name == "unequal_D_equal_Kp":
                continue
            assert delta_closed(s, J, selection, D, Kp, Kd) == pytest.approx(columns, rel=1e-6)
            if state == pytest.approx(reference, rel=1e-6):
                assert columns == pytest.approx(complex(*case["delta_5_24"]), rel=1e-6)
                assert factor == pytest.approx(complex(*case["ratio_5_24_over_5_22"]), rel=1e-6)
                break
        else:
            pytest.fail(f"no gains give the determinant of {case['word']} at {case['q']}")


def regular_poses(count: int) -> list[tuple[float, ...]]:
    """Poses as far from singular as those of the reference."""
    drawn = random_poses(PUMA_260, 10 * count, seed=1)
    bounds = (0.42, 0.04, 0.19)  # elbow, shoulder (m), wrist
    return [
        q
        for q in drawn
        if all(abs(m) > b for m, b in zip(singularity_margins(PUMA_260, q), bounds, strict=True))
    ][:count]


def count(gains: dict[str, list[float]], tool: float) -> tuple[int, int]:
    """Unstable and all cases over 200 poses and ten words."""
    unstable = total = 0
    dynamics = ArmDynamics(PUMA_260)
    for q in regular_poses(200):
        dynamics.update(q)
        J = frame_jacobian(dynamics, tool)
        for word in STATISTICS_WORDS:
            selection = selection_of(word)
            C = hybrid_rows(J, selection, np.diag(gains["D"])).errors
            loop = pid_loop(np.diag(gains["D"]), C, gains["Kp"], gains["Kd"], selection.size)
            unstable += verdict(loop) is Verdict.UNSTABLE
            total += 1
    return unstable, total


def test_the_statistics_of_instability() -> None:
    """On other poses than the reference's, whose counts are 0, 169; 0, 0; 60, 143 of 2000."""
    gains: Any = golden("stability_special_case")["gains"]
    found = {(name, tool): count(gains[name], tool) for name in gains for tool in (0.0, 0.1)}
    assert {total for _, total in found.values()} == {2000}
    assert found["arm_wn10_wrist_wn40", 0.0][0] == 0
    assert found["same_wn20", 0.0][0] == found["same_wn20", 0.1][0] == 0
    assert found["arm_wn10_wrist_wn40", 0.1][0] == pytest.approx(169, rel=0.3)
    assert 20 <= found["unequal_D_equal_Kp", 0.0][0] <= 100
    assert found["unequal_D_equal_Kp", 0.1][0] == pytest.approx(143, rel=0.3)


def test_weighted_by_inertia_nothing_is_unstable() -> None:
    """0 of 1330 in the reference; here too, with the poles the projector promises."""
    dynamics = ArmDynamics(PUMA_560)
    expected = np.array([-20.0, 0.0])
    for pose in golden("puma560_kinematics")["cases"][:133]:
        dynamics.update(pose["q"])
        for word in STATISTICS_WORDS:
            selection = selection_of(word)
            M = dynamics.M
            C = hybrid_rows(frame_jacobian(dynamics, 0.1), selection, M).errors
            values = poles(weighted_loop(M, M, C, 20.0, 1.0, selection.size))
            assert growth(values) == 0.0
            apart = np.abs(values[:, np.newaxis] - expected).min(axis=1)
            assert apart.max() < 2e-2  # double poles: the square root of rounding

"""The arms' data: derived quantities, published anchors, and errors that list what exists."""

import importlib
import pkgutil
from math import pi

import pytest

import rfms_can.arm
from rfms_can.arm import ARMS, JOINT_COUNT, PUMA_260, PUMA_560, Arm, arm_by_name, friction_set
from rfms_can.errors import ArmError

arms = pytest.mark.parametrize("arm", list(ARMS.values()), ids=list(ARMS))


def test_counts_per_radian_and_armature_follow_from_the_gear() -> None:
    counts = [round(abs(drive.counts_per_radian)) for drive in PUMA_560.drives]
    assert counts == [9965, 17159, 8548, 12102, 11447, 12205]
    assert PUMA_260.drives[3].counts_per_radian == pytest.approx(800 * 43.5111 / (2 * pi))
    assert PUMA_560.drives[0].counts_per_radian < 0.0  # the motor turns against the joint
    assert PUMA_560.drives[0].armature == pytest.approx(0.784, abs=1e-3)


def test_currents_at_the_torque_limit_are_those_of_the_amplifiers() -> None:
    currents = [round(drive.current_limit, 1) for drive in PUMA_560.drives]
    assert currents == [7.0, 7.6, 6.9, 4.6, 3.9, 4.2]
    assert max(drive.current_limit for drive in PUMA_260.drives) < 5.0


def test_the_260_is_the_560_scaled_with_two_corrections() -> None:
    s = 8 / 17
    for small, large in zip(PUMA_260.links, PUMA_560.links, strict=True):
        assert small.mass == pytest.approx(s**2 * large.mass)
        assert small.inertia == pytest.approx([s**4 * i for i in large.inertia])
    assert PUMA_260.links[1].com == pytest.approx((-0.1712, 0.002824, -0.0635), abs=1e-6)
    assert PUMA_260.links[2].com[0] == 0.0
    friction = PUMA_260.friction_sets["corke"][0]
    assert friction.coulomb_positive < friction.coulomb_negative
    assert (friction.coulomb_positive + friction.coulomb_negative) / 2 == pytest.approx(
        2.708, abs=1e-3
    )


def test_thesis_friction_is_table_4_1() -> None:
    offsets = [(f.coulomb_positive, f.coulomb_negative) for f in friction_set(PUMA_560, "thesis")]
    assert offsets[0] == pytest.approx((14.24, 12.71), abs=5e-3)
    assert offsets[5] == pytest.approx((0.678, 0.621), abs=5e-4)


@arms
def test_published_inertias_are_kept_and_corrections_make_them_possible(arm: Arm) -> None:
    for link in arm.links:
        x, y, z = link.physical_inertia
        assert x + y >= z and y + z >= x and x + z >= y
        assert link.physical_mass > 0.0


@pytest.mark.parametrize("arm", [PUMA_260, PUMA_560], ids=lambda arm: arm.name)
def test_a_pumas_links_1_and_3_are_corrected_with_a_reason(arm: Arm) -> None:
    assert [link.correction is not None for link in arm.links] == [True, False, True] + [False] * 3
    correction = arm.links[2].correction
    assert correction is not None and "exceeds xx + zz" in correction.reason
    assert arm.links[2].inertia[1] > correction.inertia[1]


def test_every_arm_that_is_written_down_exists_under_its_name() -> None:
    written: list[Arm] = []
    for module in pkgutil.iter_modules(rfms_can.arm.__path__, "rfms_can.arm."):
        values = vars(importlib.import_module(module.name)).values()
        written += [value for value in values if isinstance(value, Arm)]
    assert {arm.name for arm in written} == set(ARMS), "an Arm that is not in ARMS"
    assert all(ARMS[arm.name] is arm for arm in written)
    assert len({arm.arm_id for arm in ARMS.values()}) == len(ARMS), "arm_id given twice"


@arms
def test_park_is_inside_the_limits_with_room_to_home(arm: Arm) -> None:
    for q, (lower, upper), drive in zip(arm.park, arm.joint_limits, arm.drives, strict=True):
        assert lower + 2 * drive.index_interval < q < upper - 2 * drive.index_interval


@arms
@pytest.mark.parametrize("joint", range(JOINT_COUNT))
def test_board_scale_spans_torque_speed_and_range(arm: Arm, joint: int) -> None:
    scale, drive = arm.board_scale(joint), arm.drives[joint]
    assert abs(scale.torque_per_dac_code) * 2048 == pytest.approx(drive.torque_limit)
    assert (scale.torque_per_dac_code > 0) == (drive.gear_ratio > 0)
    assert abs(scale.speed_per_adc_code) * 2048 > arm.speed_limits[joint]
    lower, upper = arm.joint_limits[joint]
    assert scale.coarse_zero < lower
    assert scale.coarse_zero + 4095 * scale.angle_per_coarse_code > upper
    assert scale.coarse_error < drive.index_interval / 4


def test_unknown_names_are_answered_with_the_known_ones() -> None:
    assert arm_by_name("puma560") is PUMA_560
    with pytest.raises(ArmError, match=f"no arm 'puma700'; there are: {', '.join(ARMS)}"):
        arm_by_name("puma700")
    with pytest.raises(ArmError, match=r"puma260 has no friction set 'ice'.*corke, thesis, none"):
        friction_set(PUMA_260, "ice")

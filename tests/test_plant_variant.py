"""Plants that differ from the data sheet: names, Table 4.1, errors of the boards."""

import random
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfms_can.arm import PUMA_260, PUMA_560, JointFriction, known_load
from rfms_can.arm.puma import OUNCE_INCH
from rfms_can.arm.torque_law import TABLE_4_1, TorqueLaw, table_4_1
from rfms_can.errors import PlantError, RfmsError
from rfms_can.plant.board import Board
from rfms_can.plant.imperfect_board import BoardErrors, ImperfectBoard
from rfms_can.plant.physics import PlantPhysics
from rfms_can.plant.variant import make_variant
from rfms_can.rig.settings import RunSettings

codes = st.floats(-2048.0, 2047.0)


NO_PLANTS = """/table42/perturbed/perturbed:/perturbed:x/perturbed:-1/nominal:1/perturbed:²/table41+
/table41+load+load/rewired:1:2/table41 +load""".replace("\n", "")


@pytest.mark.parametrize("name", NO_PLANTS.split("/"))
def test_a_plant_that_does_not_exist_is_refused_with_those_that_do(name: str) -> None:
    with pytest.raises(PlantError, match=r"no plant .*perturbed:SEED"):
        make_variant(name, PUMA_560, "corke")
    with pytest.raises(RfmsError):
        RunSettings(arm="puma560", plant=name)


def test_table_4_1_in_si() -> None:
    first = table_4_1(PUMA_560)[0]
    assert first.slope_positive == pytest.approx(0.0640, abs=5e-5)
    assert first.offset_positive == pytest.approx(-14.2, abs=0.05)
    assert table_4_1(PUMA_260)[0].slope == pytest.approx(first.slope * (8 / 17) ** 3)


@given(codes, st.sampled_from((-1.0, 1.0)), st.integers(0, 5))
def test_a_law_is_a_motor_and_a_friction_that_grows_with_its_torque(
    current: float, speed: float, joint: int
) -> None:
    law = table_4_1(PUMA_560)[joint]
    a_p, b_p, a_n, b_n = (OUNCE_INCH * number for number in TABLE_4_1[joint])
    slope, offset = (a_p, b_p) if speed > 0.0 else (a_n, b_n)
    assert law.torque(current, speed) == pytest.approx(
        slope * current + offset - law.viscous * speed
    )
    again = TorqueLaw.of(law.slope, law.friction)
    assert again.torque(current, speed) == pytest.approx(law.torque(current, speed))
    motor = law.slope * current
    for coulomb in (law.friction.coulomb_positive, law.friction.coulomb_negative):
        assert coulomb + law.friction.load * motor > 0.0


@pytest.mark.parametrize("speed", [0.5, -0.5])
def test_joint_1_of_the_plant_accelerates_by_the_law(speed: float) -> None:
    """Joint 1 feels no gravity: its acceleration is the law's torque over the inertia."""
    variant = make_variant("table41", PUMA_560, "corke")
    physics = PlantPhysics(PUMA_560, "corke", 250.0, variant=variant)
    model = physics.model
    model.reset(PUMA_560.park, [speed, 0.0, 0.0, 0.0, 0.0, 0.0])
    law, inertia = variant.laws[0], model.inertia_matrix()
    code = -700 if speed > 0.0 else 700  # the gear of joint 1 is negative
    brakes = [False, *[True] * 5]
    physics.step_period([code, 0, 0, 0, 0, 0], [0] * 6, brakes)
    gain = physics.true_qd[0] - speed
    assert gain == pytest.approx(
        law.torque(-code, speed + gain / 2.0) / inertia[0][0] * 4e-3, rel=2e-3
    )


def test_the_same_seed_makes_the_same_arm_and_another_one_another() -> None:
    one, same, other = (make_variant(f"perturbed:{seed}", PUMA_560, "corke") for seed in (1, 1, 2))
    assert [link.mass for link in one.arm.links] == [link.mass for link in same.arm.links]
    assert [link.mass for link in one.arm.links] != [link.mass for link in other.arm.links]
    assert one.board_errors == same.board_errors


@given(st.integers(0, 10_000))
def test_perturbed_arms_stay_in_their_bounds(seed: int) -> None:
    nominal = make_variant("nominal", PUMA_560, "corke")
    variant = make_variant(f"perturbed:{seed}", PUMA_560, "corke")
    for ours, theirs in zip(variant.arm.links, nominal.arm.links, strict=True):
        assert 0.7 <= ours.mass / theirs.physical_mass <= 1.3
        assert ours.com == theirs.com
    for friction, before in zip(variant.friction, nominal.friction, strict=True):
        for field in ("coulomb_positive", "coulomb_negative", "viscous"):
            assert 0.5 <= getattr(friction, field) / getattr(before, field) <= 1.5
    signs = [board_errors.encoder_sign for board_errors in variant.board_errors]
    offsets = [board_errors.current_offset for board_errors in variant.board_errors]
    assert sorted(signs) == [-1, 1, 1, 1, 1, 1]
    assert sum(map(bool, offsets)) == 1
    assert not offsets[signs.index(-1)]
    rewired = make_variant(f"rewired:{seed}", PUMA_560, "corke")
    assert all(board_errors.encoder_sign == 1 for board_errors in rewired.board_errors)
    assert [w.current_offset for w in rewired.board_errors] == offsets


def test_a_load_in_the_hand_weighs_what_it_weighs() -> None:
    bare = PlantPhysics(PUMA_560, "none", 250.0)
    variant = make_variant("nominal+load", PUMA_560, "none")
    loaded = PlantPhysics(PUMA_560, "none", 250.0, variant=variant)
    for physics in (bare, loaded):
        physics.model.reset([0.0] * 6)
    gain = loaded.model.holding_torque()[1] - bare.model.holding_torque()[1]
    load = known_load(PUMA_560)
    reach = PUMA_560.a2 + PUMA_560.a3 + load.com[0]  # forearm and hand point up
    assert gain == pytest.approx(load.mass * 9.81 * reach, rel=1e-6)


def test_a_board_with_its_channels_exchanged_counts_backwards() -> None:
    right = Board(PUMA_560, 2, 0.3)
    wrong = ImperfectBoard(PUMA_560, 2, 0.3, BoardErrors(encoder_sign=-1), random.Random(0))
    for q in (0.31, 0.5, 0.45, 0.7):
        right.observe(q, 0.1)
        wrong.observe(q, 0.1)
        (counts, current, speed, seen), other = right.sample(), wrong.sample()
        assert other == (-counts, current, speed, seen)
        assert wrong.coarse(q) == right.coarse(q)
        if right.latched_index_counts is not None:
            assert wrong.latched_index_counts == -right.latched_index_counts


def test_an_amplifier_with_a_current_of_its_own_says_so_in_the_adc() -> None:
    board_errors = BoardErrors(current_offset=40, adc_slope=0.5, adc_offset=3.0)
    board = ImperfectBoard(PUMA_560, 1, 0.0, board_errors, random.Random(0))
    torque = board.set_dacs(100)
    assert torque == pytest.approx(140 * PUMA_560.board_scale(1).torque_per_dac_code)
    assert board.sample()[1] == 73


def test_the_noise_of_the_converters_has_the_size_asked_for() -> None:
    board_errors = replace(BoardErrors(), current_noise=2.0, velocity_noise=1.5)
    board = ImperfectBoard(PUMA_560, 0, 0.0, board_errors, random.Random(1))
    samples = [board.sample() for _ in range(2000)]
    for column, deviation in ((1, 2.0), (2, 1.5)):
        values = [float(sample[column]) for sample in samples]
        mean = sum(values) / len(values)
        spread = (sum((v - mean) ** 2 for v in values) / len(values)) ** 0.5
        assert abs(mean) < 0.2
        assert spread == pytest.approx((deviation**2 + 1 / 12) ** 0.5, rel=0.05)


def test_friction_sets_carry_no_load_dependence() -> None:
    """Nominal arms are as they were."""
    assert JointFriction(1.0, 2.0, 3.0).load == 0.0
    for arm in (PUMA_260, PUMA_560):
        assert all(joint.load == 0.0 for joints in arm.friction_sets.values() for joint in joints)

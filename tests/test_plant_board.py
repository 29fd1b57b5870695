"""The joint's board: converters that saturate, an encoder that is lost until it sees an index."""

from math import floor, pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfms_can.arm import ARMS, JOINT_COUNT, PUMA_260, PUMA_560, Arm
from rfms_can.plant.board import Board

arms = pytest.mark.parametrize("arm", list(ARMS.values()), ids=list(ARMS))
joints = pytest.mark.parametrize("joint", range(JOINT_COUNT))


@arms
@joints
def test_dac_codes_become_the_drives_torque(arm: Arm, joint: int) -> None:
    board, drive = Board(arm, joint, 0.0), arm.drives[joint]
    torque = board.set_dacs(-2048)
    assert board.current == pytest.approx(-drive.current_limit)
    assert torque == pytest.approx(drive.gear_ratio * drive.torque_constant * board.current)
    assert abs(torque) == pytest.approx(drive.torque_limit)


@arms
@joints
def test_a_force_code_is_a_quarter_of_a_current_code_and_both_add_up(arm: Arm, joint: int) -> None:
    board, scale = Board(arm, joint, 0.0), arm.board_scale(joint)
    assert scale.torque_per_force_code == scale.torque_per_dac_code / 4.0
    alone = board.set_dacs(0, 6)
    assert alone == pytest.approx(1.5 * scale.torque_per_dac_code)
    assert board.set_dacs(100, 0) + alone == pytest.approx(board.set_dacs(100, 6))
    assert board.current == pytest.approx(101.5 * scale.ampere_per_dac_code)
    assert board.set_dacs(2000, -2000) == board.set_dacs(1500)


def test_each_converter_saturates_at_its_rails() -> None:
    board = Board(PUMA_260, 0, 0.0)
    assert board.set_dacs(5000) == board.set_dacs(2047)
    assert board.set_dacs(-5000) == board.set_dacs(-2048)
    assert board.set_dacs(0, 9999) == board.set_dacs(0, 2047)
    assert board.set_dacs(0, -9999) == board.set_dacs(0, -2048)
    # before they are added: the far side of a rail is not borrowed from the other channel
    assert board.set_dacs(5000, -2048) == board.set_dacs(2047 - 512)


def test_the_amplifier_gives_no_more_than_the_drives_limit() -> None:
    board = Board(PUMA_260, 0, 0.0)
    assert board.set_dacs(1900, 2047) == board.set_dacs(2047)
    assert board.sample()[1] == 2047
    assert abs(board.set_dacs(-2048, -2048)) == pytest.approx(PUMA_260.drives[0].torque_limit)


def test_the_current_adc_reads_what_flows() -> None:
    board = Board(PUMA_260, 0, 0.0)
    for force, reading in ((40, 310), (42, 311), (-41, 290)):  # half a code rounds up
        board.set_dacs(300, force)
        assert board.sample()[1] == reading


@pytest.mark.parametrize(
    ("slope", "offset", "dac", "adc"),
    [(1.0, 0.0, 1234, 1234), (0.5, -10.0, 1000, 490), (5.74, -61.3, 2047, 2047), (0.5, 0.0, 3, 2)],
)
def test_current_adc_is_equation_4_14_up_to_its_rails(
    slope: float, offset: float, dac: int, adc: int
) -> None:
    board = Board(PUMA_260, 0, 0.0, slope, offset)
    board.set_dacs(dac)
    assert board.sample()[1] == adc


@joints
def test_velocity_adc_reads_the_motors_direction_and_saturates(joint: int) -> None:
    board = Board(PUMA_260, joint, 0.0)
    limit = PUMA_260.speed_limits[joint]
    sign = 1 if PUMA_260.drives[joint].gear_ratio > 0 else -1
    board.observe(0.0, limit)
    code = board.sample()[2]
    assert code * sign == pytest.approx(2048 / 1.5, abs=1)
    assert code * PUMA_260.board_scale(joint).speed_per_adc_code == pytest.approx(limit, rel=1e-3)
    board.observe(0.0, 10.0 * sign * limit)
    assert board.sample()[2] == 2047


@arms
@joints
def test_encoder_counts_from_power_up_in_the_motors_direction(arm: Arm, joint: int) -> None:
    start = arm.park[joint]
    board = Board(arm, joint, start)
    assert board.sample()[0] == 0
    board.observe(start + 0.3, 0.0)
    assert board.sample()[0] == pytest.approx(0.3 * arm.drives[joint].counts_per_radian, abs=1)
    board.observe(start, 0.0)
    assert board.sample()[0] == 0


@given(
    arm=st.sampled_from(list(ARMS.values())),
    joint=st.integers(0, JOINT_COUNT - 1),
    start=st.floats(-2.0, 2.0),
    moves=st.lists(st.floats(-0.3, 0.3), max_size=8),
)
def test_every_index_pulse_between_two_samples_is_seen_and_the_last_one_latched(
    arm: Arm, joint: int, start: float, moves: list[float]
) -> None:
    drive = arm.drives[joint]
    board, q = Board(arm, joint, start), start
    for move in moves:
        before, q = q, q + move
        board.observe(q, 0.0)
        counts, _, _, index_seen = board.sample()
        old, new = (angle * drive.gear_ratio / (2 * pi) for angle in (before, q))
        crossed = floor(old) != floor(new)
        assert index_seen == crossed
        if crossed:
            pulse = floor(new) if new > old else floor(new) + 1
            latched = board.latched_index_counts
            assert latched is not None
            away = (new - pulse) * drive.counts_per_revolution
            assert counts - latched == pytest.approx(away, abs=0.5001)
    assert not board.sample()[3]  # every sample clears the flag


@arms
@joints
def test_index_and_coarse_position_find_the_joint_angle_within_a_count(
    arm: Arm, joint: int
) -> None:
    """The homing sum, anywhere in the range."""
    drive, scale = arm.drives[joint], arm.board_scale(joint)
    lower, upper = arm.joint_limits[joint]
    for part in (0.05, 0.3, 0.62, 0.9):
        start = lower + part * (upper - lower)
        board = Board(arm, joint, start)
        q = start + 1.05 * drive.index_interval
        board.observe(q, 0.0)
        counts, _, _, index_seen = board.sample()
        assert index_seen and board.latched_index_counts is not None
        coarse = scale.coarse_zero + board.coarse(q) * scale.angle_per_coarse_code
        assert abs(coarse - q) <= scale.coarse_error
        since_index = counts - board.latched_index_counts
        motor = coarse * drive.gear_ratio / (2 * pi) - since_index / drive.counts_per_revolution
        found = (round(motor) * drive.counts_per_revolution + since_index) / drive.counts_per_radian
        assert found == pytest.approx(q, abs=0.51 / abs(drive.counts_per_radian))


def test_coarse_position_stays_on_its_rails() -> None:
    board = Board(PUMA_560, 0, 0.0)
    assert board.coarse(-10.0) == 0
    assert board.coarse(10.0) == 4095

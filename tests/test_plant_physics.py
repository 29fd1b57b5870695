"""The plant between two SYNCs: rates that fit, codes in, codes out, homing data that is true."""

from math import pi
from random import Random

import pytest

from rfms_can.arm import ARMS, JOINT_COUNT, PUMA_260, PUMA_560, Arm
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.errors import ArmError, PlantError
from rfms_can.plant.physics import RATES_HZ, PlantPhysics, physics_steps

arms = pytest.mark.parametrize("arm", list(ARMS.values()), ids=list(ARMS))
ZERO = (0,) * JOINT_COUNT
BRAKED = (True,) * JOINT_COUNT


@pytest.mark.parametrize(
    ("rate_hz", "steps", "step_s"),
    [(250, 4, 1e-3), (200, 5, 1e-3), (500, 2, 1e-3), (400, 5, 5e-4), (1000, 1, 1e-3),
     (800, 5, 2.5e-4), (2000, 1, 5e-4), (625, 8, 2e-4), (10_000, 1, 1e-4)],
)  # fmt: skip
def test_period_is_a_whole_number_of_the_largest_step_that_fits(
    rate_hz: float, steps: int, step_s: float
) -> None:
    found_steps, found_step_s = physics_steps(rate_hz)
    assert found_steps == steps
    assert found_step_s == pytest.approx(step_s)


def test_every_rate_named_as_a_way_out_is_one() -> None:
    for rate_hz in RATES_HZ:
        steps, step_s = physics_steps(rate_hz)
        assert steps * step_s * rate_hz == pytest.approx(1.0, rel=1e-12)
        assert step_s <= 1e-3


@pytest.mark.parametrize("rate_hz", [300, 333, 60, 251, 249.9, 20_000, 0, -250])
def test_other_rates_are_refused_with_rates_that_fit(rate_hz: float) -> None:
    with pytest.raises(PlantError, match=rf"rate {rate_hz:g} Hz.*rates that fit: .*250"):
        PlantPhysics(PUMA_260, "corke", rate_hz)


def test_an_unknown_friction_set_is_refused_by_name() -> None:
    with pytest.raises(ArmError, match="corke, thesis, none"):
        PlantPhysics(PUMA_260, "butter", 250)


@arms
def test_gravity_codes_hold_the_parked_arm_still(arm: Arm) -> None:
    plant = PlantPhysics(arm, "thesis", 250)
    gravity = ArmDynamics(arm).gravity(arm.park)
    codes = [
        round(g / arm.board_scale(joint).torque_per_dac_code) for joint, g in enumerate(gravity)
    ]
    for _ in range(25):
        plant.step_period(codes, ZERO)
    assert plant.true_q == list(arm.park)
    assert plant.sample() == [(0, code, 0, False) for code in codes]


def test_codes_move_the_joint_their_sign_and_gear_say() -> None:
    plant = PlantPhysics(PUMA_560, "corke", 250)
    codes = (-1500, 0, 0, 0, 0, 0)  # joint 1: the motor turns against the joint
    for _ in range(25):
        plant.step_period(codes, ZERO, (False, True, True, True, True, True))
    counts, current, speed, _ = plant.sample()[0]
    assert plant.true_q[0] > PUMA_560.park[0] and plant.true_q[1:] == list(PUMA_560.park[1:])
    assert counts < 0 and speed < 0 and current == -1500
    moved = plant.true_q[0] - PUMA_560.park[0]
    assert counts == pytest.approx(moved * PUMA_560.drives[0].counts_per_radian, abs=1)
    assert plant.true_qd[0] > 0.0


def test_a_force_set_point_breaks_a_joint_free_as_the_same_torque_by_current_does() -> None:
    """Friction holds joint 4 up to 1.07 Nm; what is added to gravity is 1.6 Nm."""
    others = (True, True, True, False, True, True)
    scale = PUMA_560.board_scale(3)
    gravity = ArmDynamics(PUMA_560).gravity(PUMA_560.park)[3]
    holding, more = round(gravity / scale.torque_per_dac_code), round(1.6 / 0.0118)
    moved = []
    for current, force in ((holding, 0), (holding, 4 * more), (holding + more, 0)):
        plant = PlantPhysics(PUMA_560, "corke", 250)
        for _ in range(25):
            plant.step_period((0, 0, 0, current, 0, 0), (0, 0, 0, force, 0, 0), others)
        moved.append(plant.true_q[3] - PUMA_560.park[3])
    assert moved[0] == 0.0
    assert moved[1] == moved[2] > 0.01


@arms
def test_moving_joint_meets_an_index_that_tells_its_angle(arm: Arm) -> None:
    plant = PlantPhysics(arm, "corke", 250)
    drive, scale = arm.drives[0], arm.board_scale(0)
    assert plant.latched_index_counts(0) is None
    seen = False
    for _ in range(500):
        plant.step_period((900, 0, 0, 0, 0, 0), ZERO, (False, True, True, True, True, True))
        counts, _, _, seen = plant.sample()[0]
        if seen:
            break
    latched = plant.latched_index_counts(0)
    assert seen and latched is not None
    since_index = counts - latched
    coarse = scale.coarse_zero + plant.coarse(0) * scale.angle_per_coarse_code
    motor = coarse * drive.gear_ratio / (2 * pi) - since_index / drive.counts_per_revolution
    found = (round(motor) * drive.counts_per_revolution + since_index) / drive.counts_per_radian
    assert found == pytest.approx(plant.true_q[0], abs=0.51 / abs(drive.counts_per_radian))


def test_powered_off_arm_holds_on_its_brakes_and_gripper_runs_with_the_period() -> None:
    plant = PlantPhysics(PUMA_260, "none", 250, part_width=0.01)
    plant.jaw.set_motor_current(-2048)
    for _ in range(250):
        plant.step_period(ZERO, ZERO, BRAKED)
    assert plant.true_q == list(PUMA_260.park)
    assert plant.jaw.opening == 0.01


def test_initial_pose_is_taken_and_checked() -> None:
    pose = (0.2, 1.0, -3.0, 0.0, -1.0, 0.0)
    assert PlantPhysics(PUMA_260, "corke", 250, initial_q=pose).true_q == list(pose)
    with pytest.raises(PlantError, match="joint 5 cannot start at"):
        PlantPhysics(PUMA_260, "corke", 250, initial_q=(0.0, 1.0, -3.0, 0.0, 3.0, 0.0))


@arms
def test_any_codes_and_brakes_leave_the_arm_in_its_range(arm: Arm) -> None:
    plant, dice = PlantPhysics(arm, "thesis", 400), Random(1)
    for _ in range(100):
        codes = [dice.randint(-2048, 2047) for _ in range(JOINT_COUNT)]
        brakes = [dice.random() < 0.15 for _ in range(JOINT_COUNT)]
        for _ in range(10):
            plant.step_period(codes, ZERO, brakes)
            for q, (lower, upper) in zip(plant.true_q, arm.hard_stops, strict=True):
                assert lower <= q <= upper

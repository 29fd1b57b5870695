"""The joint servo, one term of Eq. 5.11 at a time, and torque to DAC code."""

import math
from collections.abc import Sequence
from operator import mul

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfms_can.arm import ARMS, Arm
from rfms_can.joint_nodes.compliance import RowSets
from rfms_can.joint_nodes.friction import REVERSAL_S, TRANSFER_FRACTION
from rfms_can.joint_nodes.servo import Servo
from rfms_can.joint_nodes.stop_ramp import StopRamp
from rfms_can.master.start_up.node_parameters import joint_parameters
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.vocabulary import Law, Parameter

T = 0.004

BARE: dict[Parameter, float] = {
    **dict.fromkeys(Parameter, 0.0),
    Parameter.PERIOD: T,
    Parameter.TORQUE_LIMIT: 50.0,
    Parameter.TORQUE_PER_CODE: 50.0 / 2048.0,
    Parameter.INTEGRAL_LIMIT: 10.0,
    Parameter.FRICTION_SPEED: 1e-3,
}
"""No gain at all: each test adds what it looks at."""

ZERO = (0.0,) * 6
UNIT = (0.0, 1.0, 0.0, 0.0, 0.0, 0.0)
"""Row of the identity: the joint's own error is the second."""


def servo_with(**values: float) -> Servo:
    return Servo({**BARE, **{Parameter[name]: value for name, value in values.items()}}, 2)


def torque(
    servo: Servo,
    *,
    e: Sequence[float] = ZERO,
    v: Sequence[float] = ZERO,
    a: Sequence[float] = ZERO,
    c: Sequence[float] = UNIT,
    mc: Sequence[float] = ZERO,
    law: Law = Law.PID,
    feedforward: float = 0.0,
    selection: int = 0,
    damping: float = 0.0,
    specification: int = 0,
) -> float:
    rows = RowSets(2)
    rows.law = law
    weighted = law is Law.WEIGHTED  # then c is M, and mc is M C_theta
    rows.inertia_row, rows.law_row = (tuple(c), tuple(mc)) if weighted else (tuple(mc), tuple(c))
    rows.selection, rows.damping, rows.specification = selection, damping, specification
    return servo.torque(e, v, a, rows, feedforward)


def own(value: float) -> tuple[float, ...]:
    """Six values of which the joint's own is not zero."""
    return tuple(value * unit for unit in UNIT)


# --- one term at a time ------------------------------------------------------------------------


def test_without_gains_there_is_no_torque() -> None:
    assert torque(servo_with(), e=own(1.0), v=own(1.0), a=own(1.0)) == 0.0


def test_proportional_term_is_newton_metres_per_radian_of_the_real_error() -> None:
    servo = servo_with(KP=20.0)
    assert torque(servo, e=own(0.1)) == pytest.approx(2.0)
    row = (1.0, 0.5, -2.0, 0.0, 3.0, 4.0)
    errors = (0.1, 0.2, 0.3, 0.4, -0.5, 0.0)
    real = 0.1 + 0.1 - 0.6 - 1.5
    assert torque(servo, e=errors, c=row) == pytest.approx(20.0 * real)


def test_derivative_term_damps_the_rate_it_is_given_whatever_the_period() -> None:
    for period in (0.001, 0.004, 0.02):
        servo = servo_with(KD=3.0, PERIOD=period)
        assert torque(servo, v=own(0.5)) == pytest.approx(1.5)


def test_derivative_is_the_derivative_of_the_error() -> None:
    """Along a sinusoidal error the D term is K_d de/dt: not its difference, not its integral."""
    servo = servo_with(KD=3.0)
    for k in range(50):
        e, rate = math.sin(7.0 * k * T), 7.0 * math.cos(7.0 * k * T)
        assert torque(servo, e=own(e), v=own(rate)) == pytest.approx(21.0 * math.cos(7.0 * k * T))


def test_derivative_too_is_that_of_the_real_error() -> None:
    servo = servo_with(KD=2.0)
    rates, row = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0), (0.5, 0.0, -1.0, 0.0, 0.0, 1.0)
    assert torque(servo, v=rates, c=row) == pytest.approx(2.0 * (0.5 - 3.0 + 6.0))


def test_inertia_term_is_weighted_row_times_all_accelerations() -> None:
    servo = servo_with()
    row, accelerations = (0.1, 0.9, 0.2, 0.0, -0.3, 0.01), (1.0, 2.0, -3.0, 9.0, 0.5, 10.0)
    assert torque(servo, a=accelerations, mc=row) == pytest.approx(
        sum(m * a for m, a in zip(row, accelerations, strict=True))
    )


def test_feedforward_is_added_as_it_is() -> None:
    assert torque(servo_with(KP=10.0), e=own(0.1), feedforward=-4.0) == pytest.approx(-3.0)


def test_weighted_law_needs_no_gains_of_its_own() -> None:
    servo = servo_with(NATURAL_FREQUENCY=30.0, DAMPING_RATIO=0.7, KP=99.0, KD=99.0)
    row = (0.05, 0.9, 0.2, 0.0, 0.1, 0.0)
    e, v = (0.01, 0.02, 0.0, 0.1, -0.01, 0.0), (0.1, 0.0, -0.2, 0.0, 0.0, 0.3)
    wanted = sum(
        m * (900.0 * ei + 2.0 * 0.7 * 30.0 * vi) for m, ei, vi in zip(row, e, v, strict=True)
    )
    assert torque(servo, e=e, v=v, mc=row, law=Law.WEIGHTED) == pytest.approx(wanted)
    assert servo.state.integral == 0.0


# --- integral ----------------------------------------------------------------------------------


def test_integral_grows_by_gain_times_real_error_times_period() -> None:
    servo = servo_with(KI=100.0)
    for k in range(1, 11):
        assert torque(servo, e=own(0.05)) == pytest.approx(100.0 * 0.05 * k * T)


def test_integral_is_of_the_real_error_not_the_joints_own() -> None:
    """Along a compliant direction the joint's own error stays; its integral must not wind up."""
    servo = servo_with(KI=100.0)
    for _ in range(100):
        assert torque(servo, e=own(0.5), c=ZERO, selection=1) == 0.0
    row = (1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    torque(servo, e=(0.1, 0.5, 0.0, 0.0, 0.0, 0.0), c=row, selection=1)
    assert servo.state.integral == pytest.approx(100.0 * 0.1 * T)


@pytest.mark.parametrize("error", [1e-3, -1e-3, 0.5e-3])
def test_integral_leaves_errors_in_the_dead_band_alone(error: float) -> None:
    servo = servo_with(KI=100.0, INTEGRAL_DEADBAND=1e-3)
    torque(servo, e=own(error))
    assert servo.state.integral == 0.0
    torque(servo, e=own(math.copysign(1.001e-3, error)))
    assert servo.state.integral == pytest.approx(math.copysign(100.0 * 1.001e-3 * T, error))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_integral_stops_at_its_limit_and_comes_back_at_once(sign: float) -> None:
    servo = servo_with(KI=1000.0, INTEGRAL_LIMIT=3.0)
    for _ in range(1000):
        torque(servo, e=own(0.1 * sign))
    assert servo.state.integral == 3.0 * sign
    torque(servo, e=own(-0.1 * sign))
    assert servo.state.integral == pytest.approx((3.0 - 0.4) * sign)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_integral_does_not_wind_up_against_the_torque_limit(sign: float) -> None:
    servo = servo_with(KP=1000.0, KI=100.0)  # 0.1 rad asks for 100 of 50 Nm
    for _ in range(100):
        assert torque(servo, e=own(0.1 * sign)) == 50.0 * sign
    assert servo.state.integral == 0.0
    torque(servo, e=own(-0.001 * sign))  # out of saturation it integrates again
    assert servo.state.integral == pytest.approx(-100.0 * 0.001 * T * sign)


def test_integral_may_unwind_while_the_torque_is_clamped() -> None:
    servo = servo_with(KI=100.0)
    torque(servo, e=own(0.1), feedforward=-90.0)  # clamped below, error pulls up
    assert servo.state.integral == pytest.approx(0.04)
    assert servo.state.at_limit


def test_reset_forgets_the_integral() -> None:
    servo = servo_with(KI=100.0)
    torque(servo, e=own(0.1))
    servo.reset()
    assert servo.state.integral == 0.0


def test_a_joint_on_its_own_is_the_pid_with_an_identity_row() -> None:
    alone, among = (servo_with(KP=20.0, KI=50.0, KD=2.0) for _ in range(2))
    for k in range(20):
        e, v = 0.1 * math.sin(k), 0.3 * math.cos(k)
        wanted = torque(among, e=own(e), v=own(v), feedforward=1.5)
        assert alone.alone(e, v, 1.5) == pytest.approx(wanted, rel=1e-12)


# --- while the arm complies ---------------------------------------------------------------------

M_ROW = (0.3, 1.1, -0.2, 0.05, 0.1, -0.02)
MC_ROW = (0.1, 0.6, -0.3, 0.02, 0.0, 0.05)
E, V, A = (
    (0.01, -0.02, 0.03, 0.1, -0.01, 0.05),
    (0.3, -0.1, 0.2, 0.0, 0.5, -0.4),
    (1.0, 2.0, -3.0, 4.0, 0.5, 9.0),
)


def dot(a: Sequence[float], b: Sequence[float]) -> float:
    return float(sum(map(mul, a, b)))


def test_the_weighted_law_feeds_the_whole_inertia_forward_and_servos_a_part_of_it() -> None:
    """tau = M a + M C (wn^2 e + 2 zeta wn e_dot): what complies still moves as commanded."""
    servo = servo_with(NATURAL_FREQUENCY=20.0, DAMPING_RATIO=0.8)
    got = torque(servo, e=E, v=V, a=A, c=M_ROW, mc=MC_ROW, law=Law.WEIGHTED, selection=3)
    wanted = dot(M_ROW, A) + 400.0 * dot(MC_ROW, E) + 32.0 * dot(MC_ROW, V)
    assert got == pytest.approx(wanted)


def test_its_damping_is_of_what_the_servo_leaves_alone() -> None:
    """mu (M - M C) e_dot, as the stability analysis has it."""
    servo = servo_with(NATURAL_FREQUENCY=20.0, DAMPING_RATIO=0.0)
    got = torque(servo, v=V, c=M_ROW, mc=MC_ROW, law=Law.WEIGHTED, selection=3, damping=12.0)
    assert got == pytest.approx(12.0 * (dot(M_ROW, V) - dot(MC_ROW, V)))


def test_damping_under_a_pid_is_by_the_inertia_its_gains_were_made_for() -> None:
    """mu d (I - C) e_dot with d = K_p / wn^2."""
    servo = servo_with(KP=180.0, NATURAL_FREQUENCY=30.0)
    row = (0.2, 0.7, 0.0, -0.1, 0.0, 0.3)
    got = torque(servo, v=V, c=row, mc=M_ROW, selection=3, damping=12.0)
    assert got == pytest.approx(12.0 * 0.2 * (V[1] - dot(row, V)))


def test_nothing_is_damped_where_the_set_says_so() -> None:
    """The stiffness law travels without: damping is none of its own."""
    servo = servo_with(KP=180.0, NATURAL_FREQUENCY=30.0)
    assert torque(servo, v=V, c=UNIT, selection=3) == 0.0


def test_the_integral_is_the_row_times_those_of_all_six_errors() -> None:
    servo, row = servo_with(KI=5.0), (0.5, 0.0, -1.0, 0.2, 0.0, 0.1)
    sums = [0.0] * 6
    for k in range(40):
        e = [0.1 * math.sin(k + j) for j in range(6)]
        sums = [s + 5.0 * T * x for s, x in zip(sums, e, strict=True)]
        assert torque(servo, e=e, c=row, selection=1) == pytest.approx(dot(row, sums))


def test_a_row_that_turns_takes_the_integral_with_it() -> None:
    """What was held along a direction that complies now is not pushed with any more."""
    servo = servo_with(KI=5.0)
    for _ in range(50):
        torque(servo, e=own(0.02), c=UNIT, selection=1)
    assert servo.state.integral > 0.0
    torque(servo, c=(1.0, 0.0, 0.0, 0.0, 0.0, 0.0), selection=2)
    assert servo.state.integral == 0.0


def test_the_weighted_integral_is_that_of_a_pid_on_the_rows_own_inertia() -> None:
    """K_i / K_p wn^2 M C: with M C = d I it is the PID's."""
    d, wn = 0.25, 20.0
    gains = {"KP": d * wn * wn, "KI": 8.0 * d * wn * wn, "NATURAL_FREQUENCY": wn}
    plain, weighted = servo_with(**gains), servo_with(**gains)
    for k in range(30):
        e = (0.0, 0.01 * math.cos(k), 0.0, 0.0, 0.0, 0.0)
        torque(plain, e=e, selection=1)
        torque(weighted, e=e, c=M_ROW, mc=own(d), law=Law.WEIGHTED, selection=1)
        assert weighted.state.integral == pytest.approx(plain.state.integral)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_integral_of_what_is_blocked_waits_and_comes_back_at_once(sign: float) -> None:
    servo = servo_with(KI=2000.0)  # its limit is 10 Nm; complying it may use 3
    for _ in range(1000):
        torque(servo, e=own(0.1 * sign), selection=1)
    assert servo.state.integral == pytest.approx(3.0 * sign)
    torque(servo, e=own(-0.1 * sign), selection=1)
    assert servo.state.integral == pytest.approx((3.0 - 0.8) * sign)


def test_rigid_again_only_the_own_integral_is_left() -> None:
    servo = servo_with(KI=5.0)
    for _ in range(20):
        torque(servo, e=E, c=(1.0, 1.0, 1.0, 1.0, 1.0, 1.0), selection=1)
    torque(servo, selection=0)
    assert servo.state.integral == pytest.approx(20 * 5.0 * T * E[1])
    torque(servo, c=(1.0, 0.0, 1.0, 1.0, 1.0, 1.0), selection=1)
    assert servo.state.integral == 0.0  # those of the others begin anew


# --- bumpless transfer -------------------------------------------------------------------------

six = st.tuples(*[st.floats(-2.0, 2.0)] * 6)


@given(
    st.lists(
        st.tuples(six, six, st.integers(0, 63), st.floats(-20.0, 20.0)), min_size=2, max_size=4
    ),
    st.tuples(*[st.floats(-0.2, 0.2)] * 6),
    six,
    six,
    st.sampled_from(Law),
)
def test_where_what_complies_changes_torque_goes_over_in_small_steps(
    sets: list[tuple[tuple[float, ...], tuple[float, ...], int, float]],
    e: tuple[float, ...],
    v: tuple[float, ...],
    a: tuple[float, ...],
    law: Law,
) -> None:
    """Any rows after any others, clamped torques too, a change in the middle of a transfer too."""
    servo = servo_with(KP=200.0, KD=20.0, NATURAL_FREQUENCY=30.0, DAMPING_RATIO=1.0)
    before = None
    for number, (c, mc, selection, gravity) in enumerate(sets, start=1):
        for _ in range(360 if number == len(sets) else 30):
            now = torque(
                servo, e=e, v=v, a=a, c=c, mc=mc, law=law, feedforward=gravity,
                selection=selection, damping=12.0, specification=number,
            )  # fmt: skip
            assert before is None or abs(now - before) <= TRANSFER_FRACTION * 50.0 * (1.0 + 1e-9)
            before = now
    fresh = servo_with(KP=200.0, KD=20.0, NATURAL_FREQUENCY=30.0, DAMPING_RATIO=1.0)
    arrived = torque(
        fresh, e=e, v=v, a=a, c=c, mc=mc, law=law, feedforward=gravity, damping=12.0,
        selection=selection,
    )  # fmt: skip
    assert before == pytest.approx(arrived, abs=1e-9)


def test_rows_of_the_same_specification_act_at_once() -> None:
    servo = servo_with(KP=20.0)
    torque(servo, e=own(0.5), specification=4)
    assert torque(servo, e=own(0.5), c=ZERO, specification=4) == 0.0


def test_an_error_that_changes_during_a_transfer_acts_at_once() -> None:
    servo = servo_with(KP=20.0)
    torque(servo, e=own(0.5), specification=1)
    first = torque(servo, e=own(0.5), c=ZERO, specification=2)
    assert first == pytest.approx(10.0 - TRANSFER_FRACTION * 50.0)
    assert torque(servo, e=own(0.5), feedforward=-4.0, c=ZERO, specification=2) == pytest.approx(
        10.0 - 2 * TRANSFER_FRACTION * 50.0 - 4.0
    )


# --- friction ----------------------------------------------------------------------------------

FRICTION = {"COULOMB_POSITIVE": 2.0, "COULOMB_NEGATIVE": 3.0, "VISCOUS": 0.5}


def test_friction_is_signed_by_the_desired_velocity() -> None:
    servo = servo_with(**FRICTION)
    assert servo.friction.rigid(1.0) == pytest.approx(2.5)
    assert servo.friction.rigid(-1.0) == pytest.approx(-3.5)


def test_friction_at_rest_stays_as_the_last_motion_left_it() -> None:
    servo = servo_with(**FRICTION)
    assert servo.friction.rigid(0.0) == 0.0  # after enabling nobody knows
    servo.friction.rigid(0.4)
    assert servo.friction.rigid(0.0) == 2.0
    assert servo.friction.rigid(-0.0009) == pytest.approx(2.0 - 0.5 * 0.0009)  # counts as rest
    servo.friction.rigid(-0.4)
    assert servo.friction.rigid(0.0009) == pytest.approx(-3.0 + 0.5 * 0.0009)


def test_friction_of_a_resting_joint_turns_to_its_error_before_the_integral_winds() -> None:
    servo = servo_with(**FRICTION, KI=100.0, INTEGRAL_DEADBAND=1e-4)
    servo.friction.rigid(1.0)
    codes = []
    for _ in range(math.ceil(REVERSAL_S / T)):
        codes.append(servo.friction.rigid(0.0))
        servo.alone(-1e-3, 0.0, 0.0)
    assert codes == sorted(codes, reverse=True)
    assert servo.friction.rigid(0.0) == pytest.approx(-3.0)
    assert servo.state.integral == 0.0
    servo.alone(-1e-3, 0.0, 0.0)
    assert servo.state.integral == pytest.approx(-100.0 * 1e-3 * T)


def test_friction_of_a_moving_joint_does_not_turn() -> None:
    servo = servo_with(**FRICTION, KI=100.0)
    servo.friction.rigid(1.0)
    servo.alone(-1e-3, 0.0, 0.0)
    assert servo.friction.rigid(0.0) == 2.0
    assert servo.state.integral < 0.0


# --- limits and codes --------------------------------------------------------------------------


@given(st.floats(-1e6, 1e6), st.floats(-1e3, 1e3))
def test_torque_never_exceeds_the_limit(error: float, feedforward: float) -> None:
    servo = servo_with(KP=100.0, KI=10.0)
    result = torque(servo, e=own(error), feedforward=feedforward)
    assert -50.0 <= result <= 50.0
    assert servo.state.at_limit == (abs(result) == 50.0 and abs(100.0 * error + feedforward) > 50.0)


@pytest.mark.parametrize("arm", ARMS.values(), ids=lambda arm: arm.name)
@pytest.mark.parametrize("joint", JOINTS)
def test_codes_are_the_boards_torques_rounded(arm: Arm, joint: int) -> None:
    servo = Servo(joint_parameters(arm, "corke", T)[joint], joint)
    scale = arm.board_scale(joint - 1).torque_per_dac_code
    assert scale * arm.drives[joint - 1].gear_ratio > 0.0  # signed like the gear
    for code in (-2048, -2047, -1, 0, 1, 2046, 2047):
        assert servo.code(code * scale) == code
        assert servo.code((code + 0.4) * scale) == min(code, 2047)
        assert servo.code((code - 0.4) * scale) == max(code, -2048)
    up, down = servo.code(servo.config.torque_limit), servo.code(-servo.config.torque_limit)
    assert (up, down) == ((2047, -2048) if scale > 0.0 else (-2048, 2047))
    assert servo.code(1e9 * scale) == 2047
    assert servo.code(-1e9 * scale) == -2048


def test_a_motor_that_turns_against_its_joint_gets_the_opposite_code() -> None:
    ahead, against = servo_with(), servo_with(TORQUE_PER_CODE=-50.0 / 2048.0)
    for newton_metres in (-20.0, -0.01, 0.3, 20.0):
        assert against.code(newton_metres) == -ahead.code(newton_metres)


# --- controlled stop ---------------------------------------------------------------------------


@given(st.floats(-3.0, 3.0), st.floats(-5.0, 5.0), st.floats(0.5, 50.0))
def test_a_controlled_stop_ends_at_rest_where_constant_deceleration_ends(
    position: float, speed: float, deceleration: float
) -> None:
    ramp = StopRamp(position, speed, deceleration, T)
    for _ in range(math.ceil(abs(speed) / (deceleration * T)) + 1):
        before = ramp.speed
        ramp.step()
        assert abs(ramp.speed) <= abs(before)
        assert abs(ramp.acceleration) <= deceleration * (1.0 + 1e-9)
    way = math.copysign(speed * speed / (2.0 * deceleration), speed)
    assert ramp.speed == 0.0
    assert ramp.position == pytest.approx(position + way, abs=deceleration * T * T)
    rest = ramp.position
    ramp.step()
    assert (ramp.position, ramp.speed, ramp.acceleration) == (rest, 0.0, 0.0)

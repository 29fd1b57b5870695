"""The bias force as joint torques: virtual work, slew, and the loop closed over the bus."""

import math
import random
from collections import deque
from collections.abc import Iterable, Sequence
from itertools import count
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from rfms_can.arm import PUMA_260
from rfms_can.compliance import Selection, compliance_jacobian
from rfms_can.kinematics import jacobian
from rfms_can.master.force.bias import (
    BIAS_FRACTION,
    CONTACT,
    DEAD_BAND,
    INTEGRAL_FADE_S,
    INTEGRAL_LIMIT,
    INTEGRAL_RATE,
    LOOP_DELAY_S,
    MOVING,
    MOVING_FADE_S,
    PROPORTIONAL,
    SLEW_FRACTION,
    BiasForce,
)
from rfms_can.master.force.wrench_estimate import TARE_CYCLES
from rfms_can.plant.wrist_sensor import GOOD
from rfms_can.transform import Transform

Matrix = NDArray[np.float64]
Q = (0.3, 1.2, -2.9, 0.4, -0.9, 0.2)
T = 0.004
LIMITS = [drive.torque_limit for drive in PUMA_260.drives]
ALL = Selection(*(True,) * 6)
NOTHING = (0.0,) * 6
FORCE = (4.0, -3.0, 10.0, 0.2, -0.1, 0.1)
GIVES_WAY = (1.01, 0.0, 0.0, 0.0, 0.0, 0.0)
"""Felt, N and N m, of what is barely touched and gives way to every force."""
six = st.tuples(*[st.floats(-20.0, 20.0)] * 6)


def at(q: tuple[float, ...] = Q) -> Matrix:
    E = Transform.translation(0.0, 0.02, 0.1) @ Transform.rpy(0.2, -0.3, 0.5)
    return compliance_jacobian(np.array(jacobian(PUMA_260, q)), E)


def settled(bias: BiasForce, J: Matrix, selection: Selection, force: tuple[float, ...]) -> Matrix:
    """The torque once it has slewed to where it goes."""
    for _ in range(3000):
        before = bias.torque
        bias.update(J, selection, force, NOTHING)
        if (bias.torque == before).all():
            return bias.torque
    raise AssertionError("it never came to rest")


# --- open loop ---------------------------------------------------------------------------------


@given(six, six, st.integers(0, 63))
@settings(max_examples=40)
def test_its_power_is_that_of_the_force_where_it_complies(
    force: tuple[float, ...], rates: tuple[float, ...], bits: int
) -> None:
    """Virtual work: tau . theta_dot = f . v, with v from the other side of the Jacobian."""
    selection, J = Selection.of(bool(bits >> i & 1) for i in range(6)), at()
    torque = settled(BiasForce([1e3] * 6, T, closed=False), J, selection, force)
    velocity = (J @ rates).tolist()
    power = sum(f * v for f, v, s in zip(force, velocity, selection, strict=True) if s)
    assert np.dot(torque, rates) == pytest.approx(power, abs=1e-9)


def test_a_force_too_strong_keeps_its_direction() -> None:
    strong = tuple(20.0 * f for f in FORCE)
    got = np.linalg.solve(at().T, settled(BiasForce(LIMITS, T, closed=False), at(), ALL, strong))
    assert (got / got[2]).tolist() == pytest.approx([f / FORCE[2] for f in FORCE])
    assert 0.0 < got[2] < strong[2]


@given(st.lists(st.tuples(six, st.booleans()), min_size=1, max_size=30))
@settings(max_examples=40)
def test_no_torque_changes_by_more_than_a_hundredth_of_its_limit_a_cycle(
    asked: list[tuple[tuple[float, ...], bool]],
) -> None:
    bias, J = BiasForce(LIMITS, T, closed=True), at()
    before = bias.torque
    for force, pushes in asked:
        if pushes:
            bias.update(J, ALL, force, NOTHING)
        else:
            bias.relax()
        step = np.abs(bias.torque - before)
        assert (step <= SLEW_FRACTION * np.array(LIMITS) * (1.0 + 1e-9)).all()
        before = bias.torque


def test_relaxed_it_is_gone_exactly() -> None:
    bias = BiasForce(LIMITS, T, closed=True)
    for _ in range(40):
        bias.update(at(), ALL, (10.0, -5.0, 20.0, 0.5, 0.0, -0.3), NOTHING)
    assert bias.active
    cycles = 0
    while bias.active:
        bias.relax()
        cycles += 1
    assert cycles <= 41
    assert bias.torque.tolist() == [0.0] * 6


def test_an_open_loop_does_not_ask_what_is_felt() -> None:
    J, force = at(), (0.0, 0.0, 12.0, 0.0, 0.0, 0.0)
    bias = BiasForce(LIMITS, T, closed=False)
    for k in range(200):
        bias.update(J, ALL, force, (5.0 * k,) * 6)
    assert bias.torque.tolist() == pytest.approx((J.T @ force).tolist())


# --- closed loop -------------------------------------------------------------------------------


class Contact:
    """What is stiff turns torque into force at once; friction keeps some, the bus is three late."""

    def __init__(self, hidden: tuple[float, ...] = NOTHING, delay: int = 3) -> None:
        self.J = at()
        self.hidden = np.array(hidden)
        self._displacement: deque[Matrix] = deque([np.zeros(6)] * (delay - 1))

    def felt(self, torque: Matrix) -> list[float]:
        """The force read now, of the torque some periods ago."""
        self._displacement.append(torque)
        force = np.linalg.solve(self.J.T, self._displacement.popleft())
        return [float(f) for f in force - self.hidden]


def run(bias: BiasForce, contact: Contact, force: tuple[float, ...], cycles: int) -> Matrix:
    """The force felt in each cycle, (n, 6)."""
    seen = []
    for _ in range(cycles):
        felt = contact.felt(bias.torque)
        seen.append(felt)
        bias.update(contact.J, ALL, force, felt)
    return np.array(seen)


def test_what_friction_keeps_is_made_up_for() -> None:
    hidden = (2.0, 1.0, -5.0, 0.05, 0.0, -0.1)
    open_, closed = (BiasForce(LIMITS, T, closed=c) for c in (False, True))
    far = run(open_, Contact(hidden), FORCE, 500)[-1]
    assert far.tolist() == pytest.approx([f - h for f, h in zip(FORCE, hidden, strict=True)])
    near = run(closed, Contact(hidden), FORCE, 1500)
    assert near[-1].tolist() == pytest.approx(FORCE, abs=1e-3)
    assert np.abs(near[125] - FORCE).max() < 1.0  # after half a second


def growth(proportional: float, rate: float, delay: int) -> float:
    """Largest pole, by size, of the loop on a plant of gain one with a delay of whole periods.

    u = F + k_p e + k_i sum e, y_k = u_(k-d): z^d (z - 1) + k_p (z - 1) + k_i T z = 0, where the
    integral takes the error of its own cycle first.
    """
    coefficients = [1.0, -1.0, *[0.0] * (delay - 1), 0.0]
    coefficients[-2] += proportional + rate * T
    coefficients[-1] -= proportional
    return float(np.abs(np.roots(coefficients)).max())


def largest_rate(delay: int) -> float:
    """The integral's rate at which the loop becomes unstable."""
    low, high = 0.0, 1000.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if growth(PROPORTIONAL, middle, delay) < 1.0 else (low, middle)
    return low


def test_the_gains_leave_the_loop_a_margin_of_9_at_three_periods_of_delay() -> None:
    assert growth(PROPORTIONAL, INTEGRAL_RATE, 3) < 1.0
    assert largest_rate(3) / INTEGRAL_RATE == pytest.approx(9.84, abs=0.05)
    assert largest_rate(12) / INTEGRAL_RATE > 2.0  # a bus four times as late


def test_the_loop_decays_as_its_poles_say() -> None:
    """The other way to the same number: the object itself on the plant."""
    bias, contact = BiasForce([1e6] * 6, T, closed=True), Contact((1.0,) * 6)
    missing = np.array(FORCE) - run(bias, contact, FORCE, 200)
    decay = (missing[150, 2] / missing[100, 2]) ** 0.02
    assert decay == pytest.approx(growth(PROPORTIONAL, INTEGRAL_RATE, 3), abs=1e-6)


@pytest.mark.parametrize("times", [0.9, 1.1])
def test_the_margin_is_where_it_is_said_to_be(
    times: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    rate = times * largest_rate(3)
    monkeypatch.setattr("rfms_can.master.force.bias.INTEGRAL_RATE", rate)
    monkeypatch.setattr("rfms_can.master.force.bias.INTEGRAL_LIMIT", (1e6,) * 6)
    bias, contact = BiasForce([1e6] * 6, T, closed=True), Contact((0.01,) * 6)
    missing = np.abs(run(bias, contact, FORCE, 600) - FORCE)[:, 2]
    grows = missing[-50:].max() > missing[200:250].max()
    assert grows == (times > 1.0)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_integral_of_a_force_that_cannot_be_has_a_limit(sign: float) -> None:
    """What is touched gives way: the correction has a bound, and goes back as soon as it may."""
    bias, J = BiasForce([1e6] * 6, T, closed=True), at()
    for _ in range(5000):
        bias.update(J, ALL, tuple(sign * f for f in FORCE), tuple(sign * f for f in GIVES_WAY))
    most = [abs(f) * (1.0 + PROPORTIONAL) + i for f, i in zip(FORCE, INTEGRAL_LIMIT, strict=True)]
    asked = np.linalg.solve(J.T, bias.torque)
    assert (np.abs(asked) <= np.array(most) + 1e-9).all()
    assert abs(asked[2]) == pytest.approx(most[2])
    bias.update(J, ALL, tuple(sign * f for f in FORCE), tuple(2.0 * sign * f for f in FORCE))
    assert (np.abs(np.linalg.solve(J.T, bias.torque)) < np.abs(asked)).all()


def test_no_joint_is_asked_for_more_than_its_part_and_the_force_keeps_its_direction() -> None:
    """What is touched gives way: the integral stops where the first joint gives what it can."""
    bias, J = BiasForce(LIMITS, T, closed=True), at()
    for _ in range(5000):
        bias.update(J, ALL, FORCE, GIVES_WAY)
        assert (np.abs(bias.torque) <= BIAS_FRACTION * np.array(LIMITS) * (1.0 + 1e-9)).all()
    share = np.abs(bias.torque) / LIMITS
    assert share.max() == pytest.approx(BIAS_FRACTION)
    bias.update(J, ALL, FORCE, tuple(1.5 * f for f in FORCE))
    cycles = 0
    while share.max() > 0.5 * BIAS_FRACTION:  # and comes back at once, as fast as it may
        bias.update(J, ALL, FORCE, tuple(1.5 * f for f in FORCE))
        share = np.abs(bias.torque) / LIMITS
        cycles += 1
    assert cycles < 250


def test_what_is_rigid_is_not_corrected() -> None:
    bias, J, selection = BiasForce(LIMITS, T, closed=True), at(), Selection.parse("fz")
    for _ in range(500):
        bias.update(J, selection, (0, 0, 5.0, 0, 0, 0), (9.0, -9.0, 5.0, 1.0, 1.0, 1.0))
    assert bias.torque.tolist() == pytest.approx((J.T @ [0, 0, 5.0, 0, 0, 0]).tolist())


def test_another_specification_begins_without_the_integral_of_the_last() -> None:
    bias, J = BiasForce(LIMITS, T, closed=True), at()
    for _ in range(500):
        bias.update(J, ALL, FORCE, NOTHING)
    bias.begin()
    for _ in range(300):
        bias.update(J, ALL, FORCE, FORCE)
    assert bias.torque.tolist() == pytest.approx((J.T @ FORCE).tolist())


def test_the_loop_closes_when_what_the_joints_pressed_with_has_gone_out() -> None:
    """Or the integral would answer it, and miss it a moment later: the tool left the wall."""
    bias, J, twice = BiasForce([1e6] * 6, T, closed=True), at(), tuple(2.0 * f for f in FORCE)
    bias.begin()
    for _ in range(round(LOOP_DELAY_S / T)):
        bias.update(J, ALL, FORCE, twice)
    assert bias.torque.tolist() == pytest.approx((J.T @ FORCE).tolist())
    for _ in range(50):
        bias.update(J, ALL, FORCE, twice)
    assert np.linalg.solve(J.T, bias.torque)[2] < FORCE[2]


def test_the_integrals_rate_does_not_depend_on_the_control_rate() -> None:
    seconds = 0.12
    reached = []
    for period in (0.002, 0.004, 0.008):
        bias = BiasForce([1e6] * 6, period, closed=True)
        J = np.eye(6)
        for _ in range(round(seconds / period)):
            bias.update(J, ALL, FORCE, GIVES_WAY)
        reached.append(bias.torque[2])
    expected = FORCE[2] * (1.0 + PROPORTIONAL + INTEGRAL_RATE * seconds)
    assert reached == pytest.approx([expected] * 3)
    assert math.isfinite(expected)


# --- in the air, and with no force asked for -----------------------------------------------------


def closed(cycles: int, force: tuple[float, ...], felt: Iterable[Sequence[float]]) -> BiasForce:
    """A closed loop after some cycles."""
    bias, J = BiasForce([1e6] * 6, T, closed=True), at()
    for _, now in zip(range(cycles), felt, strict=False):
        bias.update(J, ALL, force, now)
    return bias


def test_in_the_air_the_integral_grows_as_long_as_the_arm_does_not_move() -> None:
    """So an arm that looks for contact gets going, whatever holds it."""
    bias, J = BiasForce([1e6] * 6, T, closed=True), at()
    for _ in range(40000):
        bias.update(J, ALL, FORCE, NOTHING)
    force = (1.0 + PROPORTIONAL) * np.array(FORCE) + np.sign(FORCE) * INTEGRAL_LIMIT
    assert np.linalg.solve(J.T, bias.torque).tolist() == pytest.approx(force.tolist())


def test_once_the_arm_moves_its_integral_goes_at_once() -> None:
    """So that what is looked for is met by the force asked for, and not by what friction needed."""
    bias, J = BiasForce([1e6] * 6, T, closed=True), at()
    for _ in range(8000):
        bias.update(J, ALL, FORCE, NOTHING)
    for _ in range(round(5.0 * MOVING_FADE_S / T)):
        bias.update(J, ALL, FORCE, NOTHING, [2.0 * T * speed for speed in MOVING])
    left = np.linalg.solve(J.T, bias.torque) - (1.0 + PROPORTIONAL) * np.array(FORCE)
    assert (np.abs(left) < 0.01 * np.array(INTEGRAL_LIMIT)).all()


def test_an_arm_that_has_left_contact_by_an_integral_comes_back() -> None:
    """It pushed away, as friction needed: fading, that turns round and pushes on."""
    bias, J = BiasForce([1e6] * 6, T, closed=True), np.eye(6)
    few, many = (0.0, 0.0, 1.5, 0.0, 0.0, 0.0), (0.0, 0.0, 9.0, 0.0, 0.0, 0.0)
    pushes = []
    for felt in (*[many] * 75, *[NOTHING] * 500):
        bias.update(J, ALL, few, felt)
        pushes.append(bias.torque[2])
    assert pushes[74] < -20.0
    turned = next(k for k, push in enumerate(pushes[75:]) if push > few[2])
    assert turned * T < 0.6
    assert pushes[-1] > 10.0 * few[2]


@pytest.mark.parametrize("seed", range(5))
def test_what_a_tare_leaves_over_and_noise_send_a_free_arm_nowhere(seed: int) -> None:
    """A minute with no force asked for, the readings those of a tared sensor."""
    draw, noise = random.Random(seed), GOOD.noise
    left = [draw.gauss(0.0, n / math.sqrt(TARE_CYCLES)) for n in noise]
    readings = ([m + draw.gauss(0.0, n) for m, n in zip(left, noise, strict=True)] for _ in count())
    bias = closed(15000, NOTHING, readings)
    force = np.linalg.solve(at().T, bias.torque)
    assert (np.abs(force) < 0.1 * np.array(CONTACT)).all()


@given(st.tuples(*[st.floats(-1.0, 1.0)] * 5))
@settings(max_examples=40)
def test_beside_a_contact_too_an_error_within_the_dead_band_is_none(parts: Any) -> None:
    """Pressing along z, which is rigid here, and with no force asked for along the others."""
    x, y, *turns = (part * band for part, band in zip(parts, np.delete(DEAD_BAND, 2), strict=True))
    bias, J, others = BiasForce(LIMITS, T, closed=True), at(), Selection.parse("fx fy rx ry rz")
    for _ in range(500):
        bias.update(J, others, NOTHING, (x, y, 20.0, *turns))
    assert bias.torque.tolist() == [0.0] * 6


def test_the_integral_goes_where_nothing_is_felt_any_more() -> None:
    """What friction needed at the wall would push an arm on that has left it."""
    left = round(INTEGRAL_FADE_S / T)
    felt = [*[(4.0, 0.0, 0.0, 0.0, 0.0, 0.0)] * 200, *[NOTHING] * left]
    before, after = (
        np.linalg.solve(at().T, closed(n, NOTHING, felt).torque)[0] for n in (200, 200 + left)
    )
    pushed = 4.0 - DEAD_BAND[0]
    assert before == pytest.approx(-pushed * (PROPORTIONAL + INTEGRAL_RATE * 200 * T))
    assert after == pytest.approx(-pushed * INTEGRAL_RATE * 200 * T / math.e)


def test_a_force_of_none_is_reached_to_within_what_counts_as_contact() -> None:
    hidden = (2.0, 1.0, -5.0, 0.3, 0.0, -0.1)
    bias, contact = BiasForce([1e6] * 6, T, closed=True), Contact(hidden)
    felt = np.abs(run(bias, contact, NOTHING, 1500))[-1]
    assert (felt < 1.1 * np.array(CONTACT)).all()  # the bus is three periods late

"""Detectors of a joint at their bounds, and what their EMCY tell: to the number."""

import math

import pytest
from support.bench import PERIOD_NS
from support.joint_bench import ANY_SPEED, JointBench, step_limit

from rfms_can.arm import PUMA_260
from rfms_can.joint_nodes.compliance import RowSets
from rfms_can.joint_nodes.detectors.bus import (
    BAD_IN_WINDOW,
    WINDOW_CYCLES,
    BadFrames,
    PortWatch,
    SyncNumbers,
    ahead,
)
from rfms_can.joint_nodes.detectors.drive import AmplifierWatch, OverloadWatch, StallWatch
from rfms_can.joint_nodes.detectors.following import Excess, FollowingWatch
from rfms_can.joint_nodes.detectors.plausible_rows import RowsWatch
from rfms_can.joint_nodes.detectors.sensors import SensorWatch
from rfms_can.joint_nodes.detectors.setpoint_step import StepWatch
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.node.port_counts import PortCounts
from rfms_can.wire.contract import NO_SET, Wire
from rfms_can.wire.records import Measure, Rows
from rfms_can.wire.vocabulary import Command, FaultCode, Law, NodeState, Parameter

P = Parameter
PERIOD = PERIOD_NS * 1e-9
PARAMETERS = all_parameters(PUMA_260, "corke", PERIOD)[2]
FASTEST = PARAMETERS[P.SPEED_LIMIT]
TAU = PARAMETERS[P.PERIOD]
U32 = 1 << 32


# --- steps of set-points --------------------------------------------------------------------------


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_steps_and_changes_of_rate_at_their_bounds(sign: float) -> None:
    watch = StepWatch(PARAMETERS)
    step, change = 1.5 * FASTEST * TAU, 0.2 * FASTEST
    assert watch.bound == pytest.approx(step, rel=1e-9)
    assert watch.excess(sign * 0.999 * step, sign * 99.0) is None, "no rate of so few set-points"
    assert watch.excess(sign * 1.001 * step, 0.0) == Excess(sign * 1.001 * step, watch.bound)
    for taken in range(4):
        assert watch.excess(0.0, sign * 1.001 * change) is None, taken
        watch.take()
    assert watch.excess(0.0, sign * 0.999 * change) is None
    excess = watch.excess(0.0, sign * 1.001 * change)
    assert excess is not None and excess == pytest.approx((sign * 1.001 * change, change))
    both = watch.excess(sign * 2.0 * step, sign * 2.0 * change)
    assert both is not None and both.value == sign * 2.0 * step, "the angle is told first"


def test_cycles_held_widen_the_step_and_forget_the_rate_until_one_is_taken() -> None:
    watch = StepWatch(PARAMETERS)
    one = watch.bound
    for _ in range(4):
        watch.take()
    for held in (1, 2, 3):
        watch.hold()
        assert watch.bound == pytest.approx((1 + held) * one)
        assert watch.excess(0.999 * (1 + held) * one, 99.0) is None
        assert watch.excess(1.001 * (1 + held) * one, 0.0) is not None
    watch.take()
    assert watch.bound == one
    for _ in range(2):
        watch.take()
        assert watch.excess(0.0, 99.0) is None
    watch.take()
    assert watch.excess(0.0, 99.0) is not None
    watch.hold()
    watch.reset()
    assert watch.bound == one
    assert watch.excess(0.0, 99.0) is None


# --- following ------------------------------------------------------------------------------------


def test_before_a_stop_has_begun_its_bound_is_that_of_the_rate() -> None:
    rate = PARAMETERS[P.RATE_ERROR_LIMIT] * FASTEST
    watch = FollowingWatch(PARAMETERS)
    assert watch.stopping(0.0, 0.999 * rate) is None
    assert watch.stopping(0.0, -1.001 * rate) == Excess(-1.001 * rate, rate)


def test_a_stop_is_bounded_in_its_error_too_and_its_speed_is_told_first() -> None:
    watch, error = FollowingWatch(PARAMETERS), PARAMETERS[P.FOLLOWING_ERROR_LIMIT]
    watch.begin_stop(-0.5)
    bound = 0.5 + PARAMETERS[P.RATE_ERROR_LIMIT] * FASTEST
    for sign in (1.0, -1.0):
        assert watch.stopping(sign * error, sign * bound) is None
        assert watch.stopping(sign * 1.01 * error, 0.0) == Excess(sign * 1.01 * error, error)
        assert watch.stopping(sign * 9.0, sign * 9.0) == Excess(sign * 9.0, bound)
    assert watch.servoing(0.0, bound) is not None, "the bound of a servo stays"


# --- rows -----------------------------------------------------------------------------------------


def rows(
    gravity: float = 0.0, own: float = 0.0, law: Law = Law.PID, selection: int = 0, off: float = 0.0
) -> Rows:
    """Rows of joint 2, whose own element of the inertia matrix is given."""
    unit = (0.0, 1.0 + off, 0.0, 0.0, 0.0, 0.0)
    inertia = (0.0, own, 0.0, 0.0, 0.0, 0.0)
    row = unit if law is Law.PID else (0.0, own + off, 0.0, 0.0, 0.0, 0.0)
    return Rows(*row, *inertia, gravity, 1, law, 0.0, selection, 0)


def in_force(gravity: float, number: int) -> RowSets:
    active = RowSets(1)
    active.activate(rows(gravity)._replace(**{NUMBER: number}))
    return active


NUMBER = Rows._fields[13]
LIMIT = PARAMETERS[P.TORQUE_LIMIT]


def test_rows_at_each_of_their_bounds() -> None:
    watch, none = RowsWatch(PARAMETERS, 2), RowSets(1)
    assert none.number == NO_SET
    inertia = 10.0 * PARAMETERS[P.KP] / PARAMETERS[P.NATURAL_FREQUENCY] ** 2
    for sign in (1.0, -1.0):
        assert watch.excess(rows(sign * LIMIT), none) is None
        assert watch.excess(rows(sign * 1.01 * LIMIT), none) == Excess(sign * 1.01 * LIMIT, LIMIT)
        active = in_force(sign * 0.2 * LIMIT, 3)
        step = 0.25 * LIMIT
        assert watch.excess(rows(sign * 0.449 * LIMIT), active) is None
        told = watch.excess(rows(sign * 0.451 * LIMIT), active)
        assert told is not None and told == pytest.approx((sign * 0.251 * LIMIT, step))
    assert watch.excess(rows(own=inertia), none) is None
    assert watch.excess(rows(own=1.001 * inertia), none) == Excess(1.001 * inertia, inertia)
    assert watch.excess(rows(own=-1e-9), none) == Excess(-1e-9, inertia)
    for law in (Law.PID, Law.WEIGHTED):
        margin = 1e-3 if law is Law.PID else 0.5e-3 * inertia
        for sign in (1.0, -1.0):
            told = watch.excess(rows(own=0.5 * inertia, law=law, off=sign * 0.99 * margin), none)
            assert told is None
            told = watch.excess(rows(own=0.5 * inertia, law=law, off=sign * 1.01 * margin), none)
            assert told is not None
            due = 1.0 if law is Law.PID else 0.5 * inertia
            assert told == pytest.approx((due + sign * 1.01 * margin, due))
    assert watch.excess(rows(off=0.5, selection=1), none) is None


def test_without_a_natural_frequency_an_inertia_is_only_not_negative() -> None:
    watch = RowsWatch({**PARAMETERS, P.NATURAL_FREQUENCY: 0.0}, 2)
    assert watch.excess(rows(own=1e6), RowSets(1)) is None
    assert watch.excess(rows(own=-1e-9), RowSets(1)) == Excess(-1e-9, 0.0)


# --- drive ----------------------------------------------------------------------------------------


def test_an_amplifier_adds_both_dacs_up_to_its_limits_and_forgets_the_oldest() -> None:
    watch = AmplifierWatch(PARAMETERS)
    scale = PARAMETERS[P.TORQUE_PER_FORCE_CODE] / PARAMETERS[P.TORQUE_PER_CODE]
    tolerance = 2048.0 * PARAMETERS[P.CURRENT_TOLERANCE]
    for count in range(5):
        assert watch.border(2047) is None, count
        watch.drive(100, 1000)
    driven = 100.0 + 1000.0 * scale
    high = driven + tolerance + 0.1 * abs(driven)
    low = driven - tolerance - 0.1 * abs(driven)
    assert watch.border(math.floor(high)) is None
    assert watch.border(math.ceil(low)) is None
    assert watch.border(math.floor(high) + 1) == pytest.approx(high)
    assert watch.border(math.ceil(low) - 1) == pytest.approx(low)
    for sign, end in ((1, 2047.0), (-1, -2048.0)):
        for _ in range(5):
            watch.drive(sign * 2000, round(sign * 2000 / scale))
        border = watch.border(round(-sign * 2000))
        assert border == pytest.approx(end - math.copysign(tolerance + 0.1 * abs(end), end))
    for _ in range(4):
        watch.drive(0, 0)
    assert watch.border(-2048) is None, "the oldest of five explains it"
    watch.drive(0, 0)
    assert watch.border(-2048) == pytest.approx(-tolerance)
    watch.reset()
    assert watch.border(-2048) is None


def test_heat_begins_at_0_and_is_bounded_where_more_than_the_continuous_torque_flows() -> None:
    watch = OverloadWatch(PARAMETERS)
    continuous = PARAMETERS[P.CONTINUOUS_TORQUE]
    assert watch.heat == 0.0
    assert watch.bound == pytest.approx(PARAMETERS[P.OVERLOAD_TIME] * (LIMIT**2 - continuous**2))
    watch.heat = watch.bound - PARAMETERS[P.PERIOD] * (LIMIT**2 - continuous**2) * 1.0001
    assert watch.bears(-LIMIT)
    assert not watch.bears(-LIMIT)
    assert watch.bears(0.99 * continuous), "it cools, hot as it is"
    watch.heat = 2.0 * watch.bound
    assert watch.bears(continuous)
    assert watch.heat == pytest.approx(2.0 * watch.bound)
    assert not watch.bears(1.01 * continuous)


def test_a_stall_is_a_row_of_cut_torques_of_a_joint_that_stands() -> None:
    watch = StallWatch(PARAMETERS)
    turns = 0.02 * FASTEST
    assert watch.bound == math.ceil(PARAMETERS[P.STALL_TIME] / PARAMETERS[P.PERIOD])
    assert watch.run == 0
    for sign in (1.0, -1.0):
        for k in range(watch.bound):
            assert not watch.stalls(True, sign * 0.999 * turns)
            assert watch.run == k + 1
        assert watch.stalls(True, 0.0)
        assert not watch.stalls(True, sign * 1.001 * turns)
        assert watch.run == 0
    watch.stalls(True, 0.0)
    assert not watch.stalls(False, 0.0)
    assert watch.run == 0


# --- sensors --------------------------------------------------------------------------------------


def test_tachometer_and_encoder_at_their_bounds() -> None:
    for sign in (1.0, -1.0):
        watch = SensorWatch(PARAMETERS)
        bound = 3.0 * TAU * watch.limit
        slack = TAU * (0.01 * FASTEST + 0.05 * 0.4)
        moved = 0.5 * TAU * (0.4 + 0.2)
        assert not watch.differ(sign * (moved + slack + 0.999 * bound), sign * 0.4, sign * 0.2)
        assert watch.differ(sign * (moved + slack + 0.002 * bound), sign * 0.2, sign * 0.4)
        watch.reset()
        assert not watch.differ(sign * (moved + slack + 0.999 * bound), sign * 0.4, sign * 0.2)
        assert not watch.differ(sign * moved, sign * 0.4, sign * 0.2)
    assert watch.limit == PARAMETERS[P.TACHOMETER_LIMIT]


def test_the_variation_is_of_one_code_and_begins_with_the_next() -> None:
    watch = SensorWatch(PARAMETERS)
    counts = 3.0 / abs(PARAMETERS[P.COUNTS_PER_UNIT])
    assert watch.variation_bound == pytest.approx(0.1 * FASTEST * TAU + counts)
    assert watch.variation(0, 0.5) == 0.0
    assert watch.variation(0, 0.75) == 0.25
    assert watch.variation(0, 0.625) == 0.25
    assert watch.variation(0, 0.25) == 0.5
    assert watch.variation(1, 0.25) == 0.0
    assert watch.variation(1, 0.5) == 0.25
    watch.reset()
    assert watch.variation(1, 9.0) == 0.0


# --- bus ------------------------------------------------------------------------------------------


def test_numbers_of_cycles_begin_again_at_0() -> None:
    assert ahead(3, 1) == 2
    assert ahead(1, U32 - 1) == 2
    assert ahead(U32 - 1, 1) == U32 - 2


@pytest.mark.parametrize("last", [0, 100, U32 - 2])
def test_a_sync_of_the_own_master_is_four_cycles_ahead_or_behind_at_most(last: int) -> None:
    numbers = SyncNumbers()
    assert numbers.last is None and not numbers.is_foreign(77)
    numbers.last = last
    for missed in (0, 1, 7):
        near = [off for off in range(-9, 20) if not numbers.is_foreign((last + off) % U32, missed)]
        assert near == list(range(-4, 5 + missed))
    assert numbers.is_foreign((last + 5) % U32)
    numbers.reset()
    assert not numbers.is_foreign((last + 5) % U32)


def test_bad_frames_are_counted_by_identifier_in_a_window() -> None:
    watch = BadFrames()
    assert (BAD_IN_WINDOW, WINDOW_CYCLES) == (3, 10)
    assert [watch.too_many(1, cycle) for cycle in (0, 5, 9)] == [False, False, True]
    assert [watch.too_many(2, cycle) for cycle in (0, 5, 10, 14)] == [False, False, False, True]
    assert [watch.too_many(3, cycle) for cycle in (U32 - 2, U32 - 1, 5)] == [False, False, True]
    assert watch.too_many(1, 10)
    watch.reset()
    assert not watch.too_many(1, 11) and not watch.too_many(1, 11)
    assert watch.too_many(1, 11)


def test_what_a_port_had_counted_before_is_no_news() -> None:
    watch = PortWatch()
    assert watch.news(PortCounts(1, 4)) == (1, 4)
    assert watch.news(PortCounts(1, 4)) == (0, 0)
    assert watch.news(PortCounts(3, 5)) == (2, 1)


# --- what a node tells of them --------------------------------------------------------------------


@pytest.fixture
def bench(wire: Wire) -> JointBench:
    return JointBench(wire).enable()


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_what_is_told_of_sensors_that_contradict_each_other(wire: Wire, sign: float) -> None:
    """One cycle alone is enough where the encoder moves by all that it may."""
    bench = JointBench(wire, changes={P.TACHOMETER_LIMIT: 0.1 * FASTEST}).enable()
    before = bench.angle()
    way = sign * 0.95 * step_limit(bench)
    bench.q[bench.index] += way
    bench.sync()
    bench.measure(speed=0.0)
    (emergency,) = bench.emergencies()
    assert emergency.fault == FaultCode.SENSOR_MISMATCH
    assert (emergency.culprit, emergency.frame) == (bench.number, wire.id(Measure, bench.number))
    assert emergency.value == pytest.approx((bench.angle() - before) / PERIOD, rel=1e-4)
    assert emergency.bound == pytest.approx(0.1 * FASTEST)
    assert bench.state is NodeState.FAULT


def test_a_jump_of_the_encoder_is_told_by_how_much_and_bridged_by_the_speed(
    bench: JointBench,
) -> None:
    bench.reach(0.2)
    theta, speed = bench.node.theta, bench.read_speed
    for k in (1, 2):
        bench.sync()
        bench.measure(bench.q[bench.index] + 0.3)
        assert bench.node.theta == pytest.approx(theta + k * speed * PERIOD, abs=1e-6)
        assert bench.node.ladder.misses[FaultCode.ENCODER_GLITCH] == k
    at = bench.node.theta
    bench.sync()
    bench.measure(bench.q[bench.index] + 0.3)
    (emergency,) = bench.emergencies()
    assert emergency.fault == FaultCode.ENCODER_GLITCH
    assert emergency.value == pytest.approx(bench.angle(bench.q[bench.index] + 0.3) - at, abs=1e-5)
    assert emergency.bound == pytest.approx(step_limit(bench), rel=1e-5)


def test_two_samples_in_a_cycle_are_one_cycle_apart_at_least(bench: JointBench) -> None:
    bench.command(Command.QUICKSTOP)
    bench.sync(NodeState.QUICKSTOP)
    bench.measure()
    bench.measure(bench.q[bench.index] + 0.9 * step_limit(bench))
    assert bench.node.ladder.misses[FaultCode.ENCODER_GLITCH] == 0
    bench.measure(bench.q[bench.index] + 2.1 * step_limit(bench))
    assert bench.node.ladder.misses[FaultCode.ENCODER_GLITCH] == 1


@pytest.mark.parametrize("code", [2047, -2048])
def test_a_speed_at_the_rail_is_that_of_the_encoder(wire: Wire, code: int) -> None:
    bench = JointBench(wire, changes=ANY_SPEED).enable()
    bench.run()
    before = bench.angle()
    for lost in (0, 1):
        for _ in range(lost):
            bench.sync()
        bench.q[bench.index] += 0.002
        bench.sync()
        bench.measure(code=code)
        after = bench.angle()
        speed = (after - before) / (PERIOD * (1 + lost))
        assert bench.controller.sensing.speed == pytest.approx(speed, rel=1e-4)
        assert bench.node.ladder.misses[FaultCode.ADC_SATURATED] == 1 + lost
        before = after

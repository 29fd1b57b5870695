"""The controlled stop begins at the joint: never faster than it moves, never beyond its range."""

import math
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.bench import PERIOD_NS
from support.joint_bench import ANY_SPEED, JointBench

from rfms_can.arm import PUMA_260
from rfms_can.joint_nodes.ladder import Reaction
from rfms_can.joint_nodes.sensing import HARD_MARGIN_RAD, SOFT_MARGIN_RAD
from rfms_can.joint_nodes.stop_ramp import StopRamp
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import MASTER
from rfms_can.wire.records import Reference, Setpoint
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState, Parameter

PERIOD = PERIOD_NS * 1e-9
LOW, HIGH = PUMA_260.joint_limits[1]
FASTEST = PUMA_260.speed_limits[1]


@pytest.fixture(scope="module")
def enabled(wire: Wire) -> JointBench:
    """One joint for many stops."""
    return JointBench(wire).enable()


def ramp_of(
    bench: JointBench, theta: float, measured: float, position: float, rate: float
) -> StopRamp:
    """The ramp of a joint at an angle and speed that is told another angle and speed."""
    controller = bench.controller
    controller.sensing.theta, controller.sensing.speed = theta, measured
    controller._begin_stop(position, rate)
    assert controller.ramp is not None
    return controller.ramp


angles = st.floats(LOW, HIGH)
speeds = st.floats(-1.4 * FASTEST, 1.4 * FASTEST)


@settings(max_examples=300)
@given(angles, speeds, angles, speeds)
def test_a_stop_begins_where_the_joint_is_and_ends_in_its_range(
    enabled: JointBench, theta: float, measured: float, position: float, rate: float
) -> None:
    ramp = ramp_of(enabled, theta, measured, position, rate)
    step = 1.5 * FASTEST * PERIOD
    assert abs(ramp.position - theta) <= 0.25 * step + 1e-9
    assert abs(ramp.position - position) <= abs(theta - position) + 1e-9
    if rate * measured <= 0.0:
        assert ramp.speed == 0.0
    else:
        least = min(abs(rate), abs(measured), enabled.parameters[Parameter.SPEED_LIMIT])
        assert ramp.speed == pytest.approx(math.copysign(least, rate))
    began, count = ramp.speed, 1.0 / abs(enabled.parameters[Parameter.COUNTS_PER_UNIT])
    before, cycles = ramp.position, 0
    while ramp.speed:
        speed = ramp.speed
        ramp.step()
        cycles += 1
        assert abs(ramp.speed) < abs(speed) and ramp.speed * speed >= 0.0, "ever slower"
        assert (ramp.position - before) * began >= 0.0, "and never back"
        before = ramp.position
    # the last step of a ramp takes a whole period
    beyond = count + 0.5 * abs(began) * PERIOD
    assert LOW - beyond <= ramp.position <= HIGH + beyond
    slowest = enabled.parameters[Parameter.ACCELERATION_LIMIT] * PERIOD
    assert cycles <= math.ceil(abs(began) / slowest)


@given(st.floats(0.0, SOFT_MARGIN_RAD), speeds, st.sampled_from((True, False)))
def test_a_joint_just_beyond_its_range_stops_before_its_torque_goes_off(
    enabled: JointBench, beyond: float, measured: float, upper: bool
) -> None:
    end = HIGH if upper else LOW
    theta = HIGH + beyond if upper else LOW - beyond
    ramp = ramp_of(enabled, theta, measured, end, measured)
    while ramp.speed:
        ramp.step()
    assert LOW - HARD_MARGIN_RAD < ramp.position < HIGH + HARD_MARGIN_RAD


# --- where it begins, in the life of a joint ------------------------------------------------------


def test_a_joint_that_stands_does_not_start_for_a_stop(wire: Wire) -> None:
    """It is told to move, and is blocked: the stop is none of the way it was told."""
    bench = JointBench(wire, changes={Parameter.RATE_ERROR_LIMIT: 0.5}).enable()
    where = bench.q[bench.index]
    for _ in range(6):
        bench.q[bench.index] += 0.2 * FASTEST * PERIOD
        bench.sync()
        bench.setpoint()
        bench.measure(where)
        bench.other_errors()
    assert bench.controller.trajectory.rate > 0.1 * FASTEST
    bench.command(Command.QUICKSTOP)
    ramp = bench.controller.ramp
    assert ramp is not None
    assert ramp.speed == 0.0
    assert abs(ramp.position - where) <= 0.25 * 1.5 * FASTEST * PERIOD + 1e-4


def test_an_encoder_that_jumps_while_the_joint_stops_does_not_begin_the_stop_again(
    wire: Wire,
) -> None:
    """The joint brakes as long as it would have; its place is told from another zero."""
    bench = JointBench(wire, changes={Parameter.TACHOMETER_LIMIT: FASTEST}).enable()
    bench.reach(0.6 * FASTEST)
    bench.run(10)
    bench.command(Command.QUICKSTOP)
    ramp, slower = bench.controller.ramp, bench.parameters[Parameter.ACCELERATION_LIMIT] * PERIOD
    assert ramp is not None
    jump, speeds = 0.3, [ramp.speed]
    due = math.ceil(ramp.speed / slower)
    for cycle in range(due + 20):
        bench.speed = max(0.0, bench.speed - slower)
        bench.sync(NodeState.QUICKSTOP)
        bench.measure(bench.q[bench.index] + (jump if cycle >= 10 else 0.0))
        assert bench.controller.ramp is ramp
        speeds.append(ramp.speed)
        assert abs(ramp.position - bench.controller.sensing.theta) < 0.02
    assert bench.node.faults[FaultCode.ENCODER_GLITCH] >= 3
    assert bench.state is NodeState.QUICKSTOP
    assert speeds.index(0.0) <= due
    assert all(later <= earlier for earlier, later in pairwise(speeds))
    assert ramp.position == pytest.approx(bench.q[bench.index] + jump, abs=0.02)


def test_the_third_jump_begins_a_stop_where_the_encoder_says_and_as_fast_as_it_is(
    wire: Wire,
) -> None:
    bench = JointBench(wire).enable()
    bench.reach(0.4 * FASTEST)
    bench.run(10)
    for _ in range(3):
        bench.sync()
        bench.setpoint()
        bench.measure(bench.q[bench.index] + 0.3)
        bench.other_errors()
    assert bench.state is NodeState.QUICKSTOP
    ramp = bench.controller.ramp
    assert ramp is not None
    assert ramp.position == pytest.approx(bench.q[bench.index] + 0.3, abs=5e-3)
    slower = bench.parameters[Parameter.ACCELERATION_LIMIT] * PERIOD
    assert ramp.speed == pytest.approx(bench.read_speed - slower, abs=1e-6)


# --- who is to blame for a joint that is about to leave its range ---------------------------------


def outwards(wire: Wire, told: bool) -> JointBench:
    """A joint near its end that is too fast for it; as it is told, or not."""
    bench = JointBench(wire, changes=ANY_SPEED)
    bench.q[bench.index] = HIGH - (1.0 if told else 0.3)
    bench.enable()
    if told:
        bench.reach(1.9)
    held = list(bench.q)
    for _ in range(100):
        bench.speed = min(1.9, bench.speed + 0.1)
        bench.sync()
        bench.setpoint(None if told else held)
        bench.measure()
        if bench.state is not NodeState.OPERATIONAL:
            break
        bench.other_errors()
    return bench


@pytest.mark.parametrize("told", [True, False])
def test_a_joint_that_was_told_to_leave_its_range_blames_the_master(wire: Wire, told: bool) -> None:
    bench = outwards(wire, told)
    emergency = bench.emergencies()[0]
    assert emergency.fault == FaultCode.SOFT_LIMIT
    assert emergency.culprit == (MASTER if told else bench.number)
    assert emergency.frame == (wire.id(Setpoint, 1) if told else 0)
    assert emergency.bound == pytest.approx(HIGH + SOFT_MARGIN_RAD)
    assert emergency.value > emergency.bound
    assert bench.node.reaction is Reaction.STOP


# --- homing ---------------------------------------------------------------------------------------


def test_an_index_that_is_found_with_an_error_is_no_runaway(wire: Wire) -> None:
    """Angles are counted from another zero from then on: the joint has not moved that far."""
    bench = JointBench(wire)
    bench.q[bench.index] = HIGH - 1.0
    bench.configure()
    bench.command(Command.HOME)
    bench.rows(0)
    p, controller = bench.parameters, bench.controller
    lag = 1.5 * controller.motion.runaway.bound

    def sample(valid: bool) -> None:
        bench.sync(NodeState.HOMING)
        bench.measure()
        if valid:
            bench.reference()
            return
        coarse = bench.q[bench.index] - p[Parameter.COARSE_ZERO]
        code = round(coarse / p[Parameter.COARSE_PER_CODE])
        bench.say(Reference, bench.number, code, 0, 0, bench.cycle & 0xFF)

    while controller.homing.error > -lag:  # it is held up on its way down
        sample(valid=False)
        assert bench.state is NodeState.HOMING
    before = controller.sensing.encoder.angle(bench.counts())
    bench.speed = 0.1  # and is pushed back, for less than five cycles
    for valid in (False, False, True, True):
        sample(valid)
    after = controller.sensing.encoder.angle(bench.counts())
    assert after - before > 0.1, "as if it had been thrown the other way"
    bench.speed = 0.0
    for _ in range(10):
        sample(valid=True)
    assert controller.homing.error < -lag
    assert (bench.state, bench.emergencies()) == (NodeState.READY, [])

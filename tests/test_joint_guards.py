"""Guards of a joint, each at its bound: what mutants of the safety core showed no test to ask."""

import math
from collections.abc import Callable

import pytest
from support.bench import PERIOD_NS, Heard
from support.joint_bench import JointBench, step_limit

from rfms_can.joint_nodes.detectors.runaway import RunawayWatch
from rfms_can.joint_nodes.inputs import ALL_ERRORS, CycleInputs
from rfms_can.joint_nodes.stop_ramp import StopRamp
from rfms_can.kinematics.limits import nearest_turn, within_limits
from rfms_can.plant.brake_watchdog import SILENT_CYCLES, BrakeWatchdog
from rfms_can.wire.contract import COMPLY_BELONGS, Wire
from rfms_can.wire.records import Bias, Comply, JointError
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState, Parameter

PERIOD = PERIOD_NS * 1e-9
TURN = math.tau


@pytest.fixture
def bench(wire: Wire) -> JointBench:
    return JointBench(wire).enable()


# --- inputs of a cycle ----------------------------------------------------------------------------


def test_an_error_that_is_known_has_all_three_numbers() -> None:
    inputs = CycleInputs()
    assert (inputs.errors, inputs.rates, inputs.accelerations) == ([0.0] * 6,) * 3
    for index in range(6):
        assert inputs.heard != ALL_ERRORS
        inputs.take_error(index, 0.1 + index, 0.2 + index, 0.3 + index)
    assert inputs.heard == ALL_ERRORS == 0b111111
    assert inputs.errors == [0.1 + index for index in range(6)]
    assert inputs.rates == [0.2 + index for index in range(6)]
    assert inputs.accelerations == [0.3 + index for index in range(6)]


@pytest.mark.parametrize("due", [(True, False), (False, True)])
def test_a_new_cycle_has_received_nothing(due: tuple[bool, bool]) -> None:
    inputs = CycleInputs()
    inputs.take_error(2, 0.1, 0.2, 0.3)
    inputs.bias = inputs.displacement = 0.5
    inputs.servoed = inputs.new_sample = True
    inputs.begin(*due)
    assert (inputs.dac_due, inputs.setpoint_due) == due
    assert inputs.heard == 0
    kept = (inputs.bias, inputs.displacement, inputs.measure, inputs.setpoint)
    assert all(each is None for each in kept)
    assert (inputs.servoed, inputs.new_sample) == (False, False)


@pytest.mark.parametrize("joint", [1, 2, 6])
def test_a_joint_takes_its_own_element_and_that_of_this_cycle_alone(wire: Wire, joint: int) -> None:
    bench = JointBench(wire, joint).enable()
    bench.sync()
    own = [0.001 * k for k in range(1, 7)]
    old = bench.cycle - 1 & 0xFF
    bench.say(Bias, None, *own, old)
    bench.say(Comply, None, *own, old)
    assert (bench.node.inputs.bias, bench.node.inputs.displacement) == (None, None)
    bench.say(Bias, None, *own, bench.cycle & 0xFF)
    bench.say(Comply, None, *own, bench.cycle & 0xFF)
    assert bench.node.inputs.bias == pytest.approx(own[joint - 1], abs=1e-6)
    assert bench.node.inputs.displacement == pytest.approx(own[joint - 1], abs=1e-6)


def test_errors_of_the_others_are_kept_as_they_are_told(bench: JointBench) -> None:
    bench.sync()
    bench.say(JointError, 5, 0.01, 0.02, 0.03, bench.cycle & 0xFF)
    inputs = bench.node.inputs
    told = inputs.errors[4], inputs.rates[4], inputs.accelerations[4]
    assert told == pytest.approx((0.01, 0.02, 0.03), abs=1e-3)
    assert inputs.heard == 1 << 4


@pytest.mark.parametrize("last", ["setpoint", "measure", "comply", "error"])
def test_whatever_comes_last_completes_the_cycle(bench: JointBench, last: str) -> None:
    bench.sync()
    frames: dict[str, Callable[[], list[Heard]]] = {
        "setpoint": lambda: bench.setpoint(extras=COMPLY_BELONGS),
        "measure": bench.measure,
        "comply": lambda: bench.say(Comply, None, *(0.0,) * 6, bench.cycle & 0xFF),
        "error": bench.other_errors,
    }
    answers = [frames[name]() for name in frames if name != last]
    assert not bench.dacs(answer for each in answers for answer in each)
    assert len(bench.dacs(frames[last]())) == 1


# --- cycles that were lost ------------------------------------------------------------------------


@pytest.mark.parametrize("lost", [0, 1, 2])
def test_the_encoder_may_step_by_the_cycles_since_the_last_sample(wire: Wire, lost: int) -> None:
    limit = step_limit(JointBench(wire))
    for share, missed in ((0.98, 0), (1.02, 1)):
        bench = JointBench(wire).enable()
        bench.miss_syncs(lost)
        bench.sync()
        bench.measure(bench.q[bench.index] + share * limit * (lost + 1))
        assert bench.node.ladder.misses[FaultCode.ENCODER_GLITCH] == missed, share


def test_syncs_that_were_missed_count_once(bench: JointBench) -> None:
    """After two lost cycles and a good one the next sample has one cycle again."""
    bench.miss_syncs(2)
    bench.run()
    bench.sync()
    bench.measure(bench.q[bench.index] + 1.5 * step_limit(bench))
    assert bench.node.ladder.misses[FaultCode.ENCODER_GLITCH] == 1


def test_syncs_that_were_missed_are_forgotten_by_the_next_gap(bench: JointBench) -> None:
    bench.miss_syncs(2)
    bench.run()
    bench.cycle += 2  # two cycles of which no watchdog has told
    bench.sync()
    bench.measure(bench.q[bench.index] + 2.5 * step_limit(bench))
    assert bench.node.ladder.misses[FaultCode.ENCODER_GLITCH] == 0


@pytest.mark.parametrize(
    ("share", "state"), [(1.9, NodeState.OPERATIONAL), (2.1, NodeState.QUICKSTOP)]
)
def test_a_held_cycle_gives_a_set_point_twice_the_step(
    bench: JointBench, share: float, state: NodeState
) -> None:
    bench.sync()
    bench.measure()
    bench.other_errors()
    bench.sync()
    bench.measure()
    goal = list(bench.q)
    goal[bench.index] += share * step_limit(bench)
    bench.setpoint(goal)
    assert bench.state is state


def test_a_start_begins_without_what_was_held_before(bench: JointBench) -> None:
    for _ in range(2):
        bench.sync()
        bench.measure()
        bench.other_errors()
    bench.command(Command.STOP)
    bench.command(Command.START)
    bench.cycle = -1
    bench.sync()
    bench.measure()
    goal = list(bench.q)
    goal[bench.index] += 1.2 * step_limit(bench)
    bench.setpoint(goal)
    assert bench.state is NodeState.QUICKSTOP


# --- compliance -----------------------------------------------------------------------------------


def test_a_displacement_is_part_of_the_set_point_and_of_its_rate(bench: JointBench) -> None:
    for by in (0.0005, 0.0008):
        bench.sync()
        bench.say(Comply, None, *(by,) * 6, bench.cycle & 0xFF)
        bench.setpoint(extras=COMPLY_BELONGS)
        answers = bench.measure()
        bench.other_errors()
    (error,) = bench.errors(answers)
    held = bench.q[bench.index] - bench.angle()
    assert error.error == pytest.approx(0.0008 + held, abs=2e-6)
    assert error.error_rate == pytest.approx(0.0003 / PERIOD, rel=0.02)


def test_the_step_of_a_displacement_counts_from_the_one_before(bench: JointBench) -> None:
    share = 0.7 * step_limit(bench)
    bench.rows(1, selection=1)
    for by in (share, share, 0.0, -share, -share, 0.0):
        bench.sync()
        bench.say(Comply, None, *(by,) * 6, bench.cycle & 0xFF)
        bench.setpoint(extras=COMPLY_BELONGS)
        bench.measure()
        bench.other_errors()
        assert bench.state is NodeState.OPERATIONAL


# --- the controlled stop --------------------------------------------------------------------------


@pytest.mark.parametrize("speed", [0.5, -0.5])
def test_a_ramp_tells_its_deceleration_and_stops_at_zero(speed: float) -> None:
    ramp, sign = StopRamp(1.0, speed, 5.0, PERIOD), math.copysign(1.0, speed)
    assert (ramp.position, ramp.speed, ramp.acceleration) == (1.0, speed, 0.0)
    ramp.step()
    assert ramp.speed == pytest.approx(speed - sign * 5.0 * PERIOD)
    assert ramp.acceleration == pytest.approx(-sign * 5.0)
    assert ramp.position == pytest.approx(1.0 + speed * PERIOD - sign * 2.5 * PERIOD**2)
    for _ in range(24):
        ramp.step()
    assert ramp.speed == pytest.approx(0.0, abs=1e-12)
    ramp.step()
    assert ramp.speed == 0.0
    assert ramp.acceleration == pytest.approx(0.0, abs=1e-9)


# --- turns and ranges -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("angle", "previous", "lower", "upper", "expected"),
    [
        (0.3, 0.2, -1.0, 1.0, 0.3),
        (0.3, 0.3 + TURN, -1.0, 10.0, 0.3 + TURN),
        (0.3, 0.3 - TURN, -10.0, 1.0, 0.3 - TURN),
        (0.3, 0.2, 1.0, 10.0, 0.3 + TURN),
        (0.3, 0.2, -10.0, 0.0, 0.3 - TURN),
        (0.3 + 3 * TURN, 0.2, 1.0, 10.0, 0.3 + TURN),
        (-3.0, 3.0, -4.0, 4.0, -3.0 + TURN),
        (-3.0, 3.0, -4.0, 3.2, -3.0),
        (3.0, -3.0, -3.2, 4.0, 3.0),
    ],
)
def test_the_turn_nearest_to_the_joint_inside_its_range(
    angle: float, previous: float, lower: float, upper: float, expected: float
) -> None:
    if expected > upper:  # the nearest is outside: the next one inside
        expected -= TURN
    assert nearest_turn(angle, previous, lower, upper) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_no_turn_is_told(bad: float) -> None:
    assert math.isnan(nearest_turn(0.3, 0.2, 1.0, 2.0))
    assert math.isnan(nearest_turn(bad, 0.2, -1.0, 1.0))
    assert math.isnan(nearest_turn(0.3, bad, -1.0, 1.0))


def test_an_angle_at_its_limit_is_inside(bench: JointBench) -> None:
    lower, upper = zip(*bench.arm.joint_limits, strict=True)
    assert all(within_limits(bench.arm, lower)) and all(within_limits(bench.arm, upper))
    outside = [angle + 1e-9 * (k == 3) for k, angle in enumerate(upper)]
    assert within_limits(bench.arm, outside) == (True, True, True, False, True, True)


@pytest.mark.parametrize("end", [Parameter.POSITION_MIN, Parameter.POSITION_MAX])
def test_the_end_of_the_range_that_is_left_is_told(wire: Wire, end: Parameter) -> None:
    bench = JointBench(wire, joint=1)
    outward = 1.0 if end is Parameter.POSITION_MAX else -1.0
    at_end = bench.wire_value(bench.parameters[end])
    bench.q[bench.index] = at_end - 0.001 * outward
    bench.enable()
    held = list(bench.q)
    bench.speed = 0.045 * outward * bench.parameters[Parameter.SPEED_LIMIT]  # no runaway
    while bench.state is not NodeState.FAULT:
        bench.sync(bench.state)
        bench.setpoint(held)
        bench.measure()
        bench.other_errors()
    told = bench.emergencies()
    assert [each.fault for each in told] == [FaultCode.SOFT_LIMIT, FaultCode.HARD_LIMIT]
    for each, margin in zip(told, (0.02, 0.05), strict=True):
        assert each.culprit == bench.number
        assert each.bound == pytest.approx(at_end + margin * outward, abs=1e-6)
        beyond = outward * (each.value - at_end)
        assert margin < beyond < margin + 2.0 * abs(bench.speed) * PERIOD


def test_a_motion_away_that_is_braked_is_no_runaway(wire: Wire) -> None:
    """Each cycle slower than nine tenths of the one before: the servo has it."""
    p = JointBench(wire).parameters
    watch = RunawayWatch(p, 5)
    away, angle, error = 0.45 * p[Parameter.SPEED_LIMIT] * PERIOD, 0.0, 1.1 * watch.bound
    for _ in range(12):
        angle, error = angle - away, error + away
        assert not watch.watch(error, angle)
        away *= 0.87
        assert away > 0.05 * p[Parameter.SPEED_LIMIT] * PERIOD


# --- brakes ---------------------------------------------------------------------------------------


def test_silence_must_last_to_close_a_brake() -> None:
    brakes = BrakeWatchdog(2, 2)
    brakes.end_cycle([True, True], driven=True)
    for _ in range(3):
        for _ in range(SILENT_CYCLES - 1):
            assert brakes.end_cycle([False, True], driven=True) == []
        brakes.end_cycle([True, True], driven=True)
    assert not brakes.closed(0)

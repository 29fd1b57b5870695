"""Tachometer, encoder and converters: what a joint finds wrong with them, and what it does not."""

from collections.abc import Callable

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from support.bench import PERIOD_NS, Heard
from support.joint_bench import ANY_SPEED, JointBench

from rfms_can.arm import PUMA_260
from rfms_can.joint_nodes.detectors.sensors import FOUND_CYCLES, SensorWatch
from rfms_can.joint_nodes.ladder import Reaction
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.wire.contract import Wire
from rfms_can.wire.records import Measure
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState, Parameter

PERIOD = PERIOD_NS * 1e-9
PARAMETERS = all_parameters(PUMA_260, "corke", PERIOD)[2]
FASTEST = PARAMETERS[Parameter.SPEED_LIMIT]
LIMIT = PARAMETERS[Parameter.TACHOMETER_LIMIT]
TAU = PARAMETERS[Parameter.PERIOD]
RAIL = 2047

PATIENT = {Parameter.RATE_ERROR_LIMIT: 0.5, Parameter.FOLLOWING_ERROR_LIMIT: 0.5}
"""A joint that does not mind how it follows: what it is told of its motion is wrong here."""

speeds = st.floats(-1.5 * FASTEST, 1.5 * FASTEST)


# --- the sums ------------------------------------------------------------------------------------


def pumped(cycles: list[tuple[float, float]]) -> list[bool]:
    """What the watch says of encoder and tachometer rates, rad/s, cycle by cycle."""
    watch, before, found = SensorWatch(PARAMETERS), 0.0, []
    for encoder, tachometer in cycles:
        found.append(watch.differ(encoder * TAU, tachometer, before))
        before = tachometer
    return found


@given(st.lists(st.tuples(speeds, speeds), max_size=12))
def test_a_sum_is_that_of_the_worst_row_of_cycles_up_to_now(
    cycles: list[tuple[float, float]],
) -> None:
    """Page's sum by its definition: the largest of all sums that end in this cycle."""
    before, up, down = 0.0, [], []
    for encoder, tachometer in cycles:
        off = TAU * (encoder - 0.5 * (tachometer + before))
        slack = TAU * (0.01 * FASTEST + 0.05 * max(abs(tachometer), abs(before)))
        up.append(off - slack)
        down.append(-off - slack)
        before = tachometer
    bound, expected = 3.0 * TAU * LIMIT, []
    for end in range(1, len(cycles) + 1):
        worst = max(sum(row[begin:end]) for row in (up, down) for begin in range(end))
        assume(abs(worst - bound) > 1e-12)
        expected.append(worst > bound)
    assert pumped(cycles) == expected


@given(speeds, st.floats(-0.05, 0.05), st.floats(-0.01, 0.01))
def test_a_tachometer_a_few_per_cent_off_is_never_found(
    speed: float, gain: float, offset: float
) -> None:
    told = speed * (1.0 + gain) + 0.9 * offset * FASTEST
    slack = 0.01 * FASTEST + 0.05 * abs(told)
    assume(abs(speed - told) <= slack)
    assert not any(pumped([(0.0, 0.0), (0.5 * speed, told), *[(speed, told)] * 200])[2:])


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_difference_of_the_limit_beyond_the_slack_is_found_after_three_cycles(
    sign: float,
) -> None:
    slack = 0.01 * FASTEST
    just = pumped([(sign * (LIMIT + slack) * 0.9999, 0.0)] * 4)
    more = pumped([(sign * (LIMIT + slack) * 1.0001, 0.0)] * 4)
    assert (just.index(True), more.index(True)) == (FOUND_CYCLES, FOUND_CYCLES - 1)


def test_a_tachometer_shows_another_code_where_the_motion_varies() -> None:
    watch = SensorWatch(PARAMETERS)
    least = 0.1 * FASTEST * TAU + 3.0 / abs(PARAMETERS[Parameter.COUNTS_PER_UNIT])
    assert watch.variation_bound == pytest.approx(least)
    assert watch.variation(7, 0.003) == 0.0
    assert watch.variation(7, 0.001) == pytest.approx(0.002)
    assert watch.variation(7, 0.002) == pytest.approx(0.002)  # between them
    assert watch.variation(7, 0.004) == pytest.approx(0.003)
    assert watch.variation(8, 0.0) == 0.0  # another code: begun again
    watch.reset()
    assert watch.variation(8, 1.0) == 0.0


# --- the joint that is told so --------------------------------------------------------------------


@pytest.fixture
def bench(wire: Wire) -> JointBench:
    return JointBench(wire, changes=PATIENT).enable()


Told = Callable[[JointBench, float], list[Heard]]
"""MEASURE of a board whose sensors are wrong; the angle where that began, rad."""

WRONG: dict[str, Told] = {
    "frozen encoder": lambda bench, q0: bench.measure(q0),
    "reversed encoder": lambda bench, q0: bench.measure(2.0 * q0 - bench.q[bench.index]),
    "reversed tachometer": lambda bench, q0: bench.measure(speed=-bench.speed),
    "tachometer of nought": lambda bench, q0: bench.measure(code=0),
    "tachometer twice as fast": lambda bench, q0: bench.measure(speed=2.0 * bench.speed),
}


def cycle(bench: JointBench, measured: Callable[[], list[Heard]]) -> list[Heard]:
    answers = bench.sync() + bench.setpoint()
    return answers + measured() + bench.other_errors()


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("wrong", WRONG)
def test_sensors_that_contradict_each_other_end_torque(
    bench: JointBench, wrong: str, sign: float
) -> None:
    q0, measured = bench.q[bench.index], WRONG[wrong]
    change = bench.parameters[Parameter.ACCELERATION_LIMIT] * PERIOD
    answers: list[Heard] = []
    while bench.state is NodeState.OPERATIONAL:
        bench.speed += sign * change
        assert abs(bench.speed) < 0.3 * FASTEST, "not found"
        answers = cycle(bench, lambda: measured(bench, q0))
    (emergency,) = bench.emergencies()
    assert emergency.fault == FaultCode.SENSOR_MISMATCH
    assert (emergency.culprit, emergency.frame) == (bench.number, bench.wire.id(Measure, 2))
    assert emergency.bound == pytest.approx(LIMIT)
    assert abs(emergency.value) > 0.02 * FASTEST
    encoder_lags = wrong in ("frozen encoder", "reversed encoder", "tachometer twice as fast")
    assert emergency.value * sign * (-1.0 if encoder_lags else 1.0) > 0.0
    assert bench.node.reaction is Reaction.OFF
    assert [dac.current_dac for dac in bench.dacs(answers)] == [0]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_tachometer_that_sticks_is_found_when_the_joint_slows_down(
    wire: Wire, sign: float
) -> None:
    bench = JointBench(wire, changes={Parameter.TACHOMETER_LIMIT: 0.25 * FASTEST}).enable()
    bench.reach(sign * 0.2 * FASTEST)
    bench.run(30)
    code = bench.speed_code()
    change = bench.parameters[Parameter.ACCELERATION_LIMIT] * PERIOD
    while bench.state is NodeState.OPERATIONAL:
        bench.speed -= sign * change
        assert bench.speed * sign > -FASTEST, "not found"
        cycle(bench, lambda: bench.measure(code=code))
    fault = bench.emergencies()[0]
    assert fault.fault == FaultCode.SENSOR_STUCK
    assert (fault.culprit, fault.frame) == (bench.number, bench.wire.id(Measure, 2))
    counts = abs(PARAMETERS[Parameter.COUNTS_PER_UNIT])
    assert fault.bound == pytest.approx(0.1 * FASTEST + 3.0 / counts / TAU)
    assert fault.bound < fault.value < fault.bound + 2.0 * change + 1.0 / counts / TAU
    assert bench.node.reaction is Reaction.OFF


@pytest.mark.parametrize("gain", [0.95, 1.05])
def test_a_tachometer_five_per_cent_off_is_none_of_it(wire: Wire, gain: float) -> None:
    bench = JointBench(wire, changes=PATIENT).enable()
    change = bench.parameters[Parameter.ACCELERATION_LIMIT] * PERIOD
    for k in range(600):
        up = k % 200 < 100
        bench.speed = max(0.0, min(0.9 * FASTEST, bench.speed + (change if up else -change)))
        cycle(bench, lambda: bench.measure(speed=gain * bench.speed))
    assert bench.state is NodeState.OPERATIONAL
    assert not bench.node.faults


@pytest.mark.parametrize("rests", [False, True])
def test_what_was_summed_is_forgotten_while_the_joint_is_braked(
    bench: JointBench, rests: bool
) -> None:
    wrong = {"speed": 0.1 * FASTEST}
    for _ in range(2):
        for _ in range(3):
            cycle(bench, lambda: bench.measure(**wrong))  # type: ignore[arg-type]
        if rests:
            bench.command(Command.STOP)
            bench.sync(NodeState.READY)
            bench.measure()
            bench.start()
    found = bench.node.faults[FaultCode.SENSOR_MISMATCH]
    assert bool(found) is not rests


def test_a_cycle_without_its_sample_says_nothing_of_the_tachometer(bench: JointBench) -> None:
    """It is not known how fast the joint was meanwhile."""
    for _ in range(12):
        bench.sync()
        bench.setpoint()
        bench.other_errors()
        cycle(bench, lambda: bench.measure(speed=0.3 * FASTEST))
    assert set(bench.node.faults) == {FaultCode.MEASURE_MISSING}


# --- rails ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("code", [RAIL, -RAIL - 1])
def test_a_velocity_converter_at_its_rail_is_replaced_by_the_encoder_then_damps(
    bench: JointBench, code: int
) -> None:
    bench.reach(0.2 * FASTEST)
    bench.run(10)
    for rails in (1, 2):
        for _ in range(rails):
            assert bench.dacs(cycle(bench, lambda: bench.measure(code=code)))
            assert bench.node.speed == pytest.approx(bench.speed, abs=0.03)
        bench.run()
    assert bench.emergencies() == []
    assert bench.node.faults == {FaultCode.ADC_SATURATED: 3}
    for _ in range(3):
        cycle(bench, lambda: bench.measure(code=code))
    (emergency,) = bench.emergencies()
    assert emergency.fault == FaultCode.ADC_SATURATED
    assert (emergency.culprit, emergency.frame) == (bench.number, bench.wire.id(Measure, 2))
    assert (emergency.value, emergency.bound) == (code, RAIL)
    assert bench.node.reaction is Reaction.DAMP


@pytest.mark.parametrize("code", [RAIL - 1, -RAIL])
def test_one_code_less_is_no_rail(wire: Wire, code: int) -> None:
    bench = JointBench(wire, changes=ANY_SPEED).enable()
    for _ in range(5):
        cycle(bench, lambda: bench.measure(code=code))
    assert FaultCode.ADC_SATURATED not in bench.node.faults


@pytest.mark.parametrize("code", [RAIL, -RAIL - 1])
def test_a_current_at_its_rail_counts_unless_it_was_asked_for(bench: JointBench, code: int) -> None:
    bench.run(5)
    cycle(bench, lambda: bench.measure(current=code))
    assert bench.node.faults[FaultCode.ADC_SATURATED] == 1
    scale = bench.parameters[Parameter.TORQUE_PER_CODE]
    limit = bench.parameters[Parameter.TORQUE_LIMIT]
    bench.rows(1, gravity=limit if code * scale > 0.0 else -limit)
    bench.run(20)
    assert abs(bench.driven) == RAIL
    cycle(bench, lambda: bench.measure(current=code))
    assert bench.node.faults[FaultCode.ADC_SATURATED] == 1

"""AMPLIFIER_FAULT: a current that no DAC of the last cycles asked for, and none else."""

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from support.joint_bench import JointBench

from rfms_can.arm import PUMA_260
from rfms_can.joint_nodes.detectors.drive import REMEMBERED, AmplifierWatch
from rfms_can.joint_nodes.ladder import Reaction
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.wire.contract import Wire
from rfms_can.wire.records import Measure
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState, Parameter

PARAMETERS = all_parameters(PUMA_260, "corke", 0.004)[2]
TOLERANCE = 2048.0 * PARAMETERS[Parameter.CURRENT_TOLERANCE]
PER_FORCE = PARAMETERS[Parameter.TORQUE_PER_FORCE_CODE] / PARAMETERS[Parameter.TORQUE_PER_CODE]

codes = st.integers(-2048, 2047)


def driven(current: int, force: int) -> float:
    return max(-2048.0, min(2047.0, current + force * PER_FORCE))


# --- the watch ------------------------------------------------------------------------------------


@given(
    st.lists(st.tuples(codes, codes), min_size=REMEMBERED, max_size=40),
    st.lists(st.booleans(), min_size=40, max_size=40),
    st.floats(-0.09, 0.09),
    st.floats(-0.99, 0.99),
)
def test_any_dacs_with_up_to_two_frames_lost_explain_the_current(
    dacs: list[tuple[int, int]], lost: list[bool], gain: float, offset: float
) -> None:
    """A board drives the last frame that it got up to two cycles ago; it is off by less than the
    tolerance, and its rails cut it off."""
    watch, shown, in_a_row = AmplifierWatch(PARAMETERS), 0.0, 0
    arrived: list[float] = []
    for k, (current, force) in enumerate(dacs):
        if k >= REMEMBERED:
            told = (1.0 + gain) * arrived[k - 2] + offset * TOLERANCE
            assert watch.border(max(-2048, min(2047, round(told)))) is None
        watch.drive(current, force)
        in_a_row = in_a_row + 1 if lost[k] and in_a_row < 2 and k > 0 else 0
        shown = shown if in_a_row else driven(current, force)
        arrived.append(shown)


@given(codes, codes, st.floats(1.001, 40.0), st.sampled_from((1.0, -1.0)))
def test_any_lasting_offset_beyond_the_tolerance_is_found(
    current: int, force: int, times: float, sign: float
) -> None:
    watch, asked = AmplifierWatch(PARAMETERS), driven(current, force)
    tolerance = TOLERANCE + 0.1 * abs(asked)
    told = round(asked + sign * (times * tolerance + 0.5))
    assume(-2048 <= told <= 2047)
    for _ in range(REMEMBERED - 1):
        watch.drive(current, force)
        assert watch.border(told) is None, "with fewer than five nothing is known"
    watch.drive(current, force)
    assert watch.border(told) == pytest.approx(asked + sign * tolerance)


@given(st.lists(codes, min_size=REMEMBERED, max_size=REMEMBERED))
def test_the_borders_are_the_tolerance_around_all_five(dacs: list[int]) -> None:
    watch = AmplifierWatch(PARAMETERS)
    watch.drive(2047, 0)  # the sixth from the end is forgotten
    for code in dacs:
        watch.drive(code, 0)
    high, low = max(dacs), min(dacs)
    above = high + TOLERANCE + 0.1 * abs(high)
    below = low - TOLERANCE - 0.1 * abs(low)
    assert watch.border(int(above // 1)) is None
    assert watch.border(int(above // 1) + 1) == pytest.approx(above)
    assert watch.border(int(-(-below // 1))) is None
    assert watch.border(int(-(-below // 1)) - 1) == pytest.approx(below)
    watch.reset()
    assert watch.border(int(above // 1) + 1) is None


# --- the joint ------------------------------------------------------------------------------------


@pytest.fixture
def bench(wire: Wire) -> JointBench:
    bench = JointBench(wire).enable()
    bench.rows(1, gravity=5.0)
    bench.run(10)
    return bench


def cycle(bench: JointBench, current: int, *, braked: bool = False) -> None:
    bench.sync()
    bench.setpoint()
    bench.measure(current=current, braked=braked)
    bench.other_errors()


@pytest.mark.parametrize("current", [0, 2047])
def test_an_amplifier_that_sticks_ends_torque_in_its_second_cycle(
    bench: JointBench, current: int
) -> None:
    assert 500 < bench.driven < 560
    cycle(bench, current)
    assert bench.state is NodeState.OPERATIONAL
    assert bench.node.faults[FaultCode.AMPLIFIER_FAULT] == 1
    asked = bench.driven
    cycle(bench, current)
    (emergency,) = bench.emergencies()
    assert emergency.fault == FaultCode.AMPLIFIER_FAULT
    assert (emergency.culprit, emergency.frame) == (bench.number, bench.wire.id(Measure, 2))
    assert emergency.value == current
    sign = 1.0 if current else -1.0
    assert emergency.bound == pytest.approx(asked + sign * (TOLERANCE + 0.1 * asked), abs=2.0)
    assert bench.node.reaction is Reaction.OFF
    assert bench.dacs()[-1].current_dac == 0


def test_single_cycles_are_none(bench: JointBench) -> None:
    for _ in range(10):
        cycle(bench, 0)
        bench.run()
    assert bench.state is NodeState.OPERATIONAL
    assert bench.node.faults == {FaultCode.AMPLIFIER_FAULT: 10}


def test_an_offset_within_the_tolerance_is_none(bench: JointBench) -> None:
    for sign in (1, -1):
        for _ in range(10):
            cycle(bench, bench.driven + sign * int(0.9 * TOLERANCE))
    assert not bench.node.faults


def test_a_brake_that_holds_forgets_what_was_asked_for(bench: JointBench) -> None:
    """The board of a braked joint drives nothing."""
    for _ in range(3):
        cycle(bench, 0, braked=True)
        for _ in range(REMEMBERED - 1):
            cycle(bench, 0)
        assert not bench.node.faults
    cycle(bench, 0)
    assert set(bench.node.faults) == {FaultCode.AMPLIFIER_FAULT}


def test_a_joint_that_starts_again_remembers_no_dac_of_before(bench: JointBench) -> None:
    bench.command(Command.STOP)
    bench.sync(NodeState.READY)
    bench.measure(current=0, braked=True)
    bench.command(Command.START)
    bench.cycle = -1
    for _ in range(REMEMBERED):
        cycle(bench, 0)
    assert not bench.node.faults

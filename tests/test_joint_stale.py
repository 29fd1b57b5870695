"""Frames of another cycle leave no trace but a count; those of this one act in any order."""

from collections.abc import Callable

import pytest
from support.bench import Heard
from support.joint_bench import JointBench

from rfms_can.kinematics import configuration_of, direct
from rfms_can.setpoint.cartesian import CartesianSetpoint
from rfms_can.setpoint.frames import values_of
from rfms_can.wire.contract import BIAS_BELONGS, JOINT_SETPOINT_BELONGS, Wire
from rfms_can.wire.records import Bias, Comply, JointAngles, JointError, Setpoint
from rfms_can.wire.vocabulary import Blend, Mode, NodeState, TrajectoryState


@pytest.fixture
def bench(wire: Wire) -> JointBench:
    return JointBench(wire).enable()


def pose(bench: JointBench, number: int, cycle: int, extras: int = 0) -> list[Heard]:
    """One of the two poses of a set-point; the arm stands in both."""
    where, configuration = direct(bench.arm, bench.q), configuration_of(bench.arm, bench.q)
    setpoint = CartesianSetpoint(
        *(TrajectoryState.IDLE, Mode.JOINT, Blend.CONTINUOUS, 0.0, 0.0, 0.2),
        *(where, configuration, where, configuration),
    )
    return bench.say(Setpoint, number, *values_of(setpoint, where, configuration, cycle, extras))


def angles(bench: JointBench, number: int, cycle: int) -> list[Heard]:
    return bench.say(JointAngles, number, *bench.q, cycle & 0xFF, 0b111111)


SAID: dict[str, tuple[str, Callable[[JointBench, int], list[Heard]]]] = {
    "SETPOINT": ("setpoint", lambda bench, cycle: pose(bench, 1, cycle)),
    "SETPOINT 2": ("second_setpoint", lambda bench, cycle: pose(bench, 2, cycle)),
    "JOINT_SETPOINT": ("joint_setpoint", lambda bench, cycle: angles(bench, 1, cycle)),
    "JOINT_SETPOINT 2": ("second_joint_setpoint", lambda bench, cycle: angles(bench, 2, cycle)),
    "COMPLY": (
        "displacement",
        lambda bench, cycle: bench.say(Comply, None, *(0.001,) * 6, cycle & 0xFF),
    ),
    "BIAS": ("bias", lambda bench, cycle: bench.say(Bias, None, *(0.1,) * 6, cycle & 0xFF)),
    "MEASURE": ("measure", lambda bench, cycle: bench.measure(cycle=cycle)),
}


@pytest.mark.parametrize("what", SAID)
def test_a_frame_of_another_cycle_is_counted_and_not_kept(bench: JointBench, what: str) -> None:
    field, say = SAID[what]
    bench.run(3)
    bench.sync()
    bench.node.ignored.clear()
    for cycle in (bench.cycle - 1, bench.cycle + 1):
        assert say(bench, cycle) == []
        assert getattr(bench.node.inputs, field) is None
    assert bench.node.ignored == {f"stale {what.partition(' ')[0]}": 2}
    say(bench, bench.cycle)
    assert getattr(bench.node.inputs, field) is not None
    assert bench.node.ignored.total() == 2


def test_an_error_of_another_cycle_is_counted_and_not_kept(bench: JointBench) -> None:
    bench.sync()
    bench.node.ignored.clear()
    bench.say(JointError, 5, 0.01, 0.0, 0.0, bench.cycle - 1 & 0xFF)
    assert bench.node.ignored == {"stale ERROR": 1}
    assert bench.node.inputs.heard == 0


@pytest.mark.parametrize("last", ["first", "second", "angles 1", "angles 2", "bias", "measure"])
def test_all_parts_of_a_set_point_are_waited_for_in_any_order(bench: JointBench, last: str) -> None:
    extras = JOINT_SETPOINT_BELONGS | BIAS_BELONGS
    bench.sync()
    bench.other_errors()
    cycle = bench.cycle
    parts: dict[str, Callable[[], list[Heard]]] = {
        "first": lambda: pose(bench, 1, cycle, extras),
        "second": lambda: pose(bench, 2, cycle, extras),
        "angles 1": lambda: angles(bench, 1, cycle),
        "angles 2": lambda: angles(bench, 2, cycle),
        "bias": lambda: bench.say(Bias, None, *(0.1,) * 6, cycle & 0xFF),
        "measure": bench.measure,
    }
    for name, say in parts.items():
        if name != last:
            assert say() == [], name
    answers = parts[last]()
    assert len(bench.errors(answers)) == len(bench.dacs(answers)) == 1
    assert bench.state is NodeState.OPERATIONAL


def test_the_torque_that_is_told_is_the_sum_with_the_bias(bench: JointBench) -> None:
    told = []
    for bias in (0.0, 0.5):
        bench.sync()
        bench.say(Bias, None, *(bias,) * 6, bench.cycle & 0xFF)
        bench.setpoint(extras=BIAS_BELONGS)
        bench.measure()
        bench.other_errors()
        told.append(bench.node.torque)
    assert told[1] - told[0] == pytest.approx(0.5, abs=0.02)

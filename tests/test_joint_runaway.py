"""RUNAWAY: a joint that drives away from its set-point loses its torque; nothing else does."""

import math

import pytest
from support.bench import PERIOD_NS, Heard
from support.joint_bench import JointBench

from rfms_can.joint_nodes.detectors.runaway import RunawayWatch
from rfms_can.joint_nodes.ladder import Reaction
from rfms_can.master.start_up.node_parameters import FOLLOWING_ERROR_RAD
from rfms_can.wire.contract import Wire
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState, Parameter

PERIOD = PERIOD_NS * 1e-9
AWAY_SPEED = 0.25
"""Speed of a joint that runs off, rad/s: so slow that it is no error of its rate."""


@pytest.fixture
def bench(wire: Wire) -> JointBench:
    return JointBench(wire).enable()


def bound(bench: JointBench) -> float:
    p = bench.parameters
    half = 0.5 * min(p[Parameter.TORQUE_LIMIT] / p[Parameter.KP], FOLLOWING_ERROR_RAD)
    return min(half, 0.01 * p[Parameter.SPEED_LIMIT])


def displaced(bench: JointBench, by: float, speed: float) -> list[Heard]:
    """One cycle: the arm is commanded to rest; the joint is so far from there, at a speed."""
    bench.sync(NodeState.OPERATIONAL if bench.state is NodeState.OPERATIONAL else bench.state)
    answers = bench.setpoint()
    answers += bench.measure(bench.q[bench.index] + by, speed=speed)
    return answers + bench.other_errors()


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_motor_that_drives_away_loses_its_torque_within_five_cycles(
    bench: JointBench, sign: float
) -> None:
    step, by, beyond = AWAY_SPEED * PERIOD, 0.0, 0
    while bench.state is NodeState.OPERATIONAL:
        by += step
        beyond += by > bound(bench)
        displaced(bench, sign * by, sign * AWAY_SPEED)
    assert beyond in (5, 6)  # the encoder may round the first of them below the bound
    (emergency,) = bench.emergencies()
    assert emergency.fault == FaultCode.RUNAWAY
    assert emergency.culprit == bench.number
    assert emergency.value == pytest.approx(-sign * by, abs=2e-4)
    assert emergency.bound == pytest.approx(bound(bench), rel=1e-6)
    assert bench.node.reaction is Reaction.OFF
    assert bench.dacs()[-1].current_dac == 0
    count = len(bench.dacs()), len(bench.errors())
    displaced(bench, sign * by, sign * AWAY_SPEED)
    assert (len(bench.dacs()), len(bench.errors())) == count


def test_a_controlled_stop_that_drives_away_ends_as_well(bench: JointBench) -> None:
    bench.run(3)
    bench.command(Command.QUICKSTOP)
    by = 0.0
    for _ in range(200):
        by += AWAY_SPEED * PERIOD
        displaced(bench, by, AWAY_SPEED)
        if bench.state is NodeState.FAULT:
            break
    assert [e.fault for e in bench.emergencies()] == [FaultCode.RUNAWAY]
    assert by < bound(bench) + 8 * AWAY_SPEED * PERIOD


def test_homing_that_drives_away_ends_before_the_joint_is_fast(wire: Wire) -> None:
    """Encoder and coarse position agree that the joint goes the other way: a reversed motor."""
    bench = JointBench(wire)
    bench.configure()
    bench.command(Command.HOME)
    bench.rows(0)
    p, start = bench.parameters, bench.q[bench.index]
    middle = 0.5 * (p[Parameter.POSITION_MIN] + p[Parameter.POSITION_MAX])
    away = math.copysign(1.0, start - middle)
    hidden = p[Parameter.INDEX_INTERVAL_COUNTS]
    for _ in range(200):
        bench.sync(NodeState.HOMING)
        bench.measure()
        coarse = (bench.q[bench.index] - p[Parameter.COARSE_ZERO]) / p[Parameter.COARSE_PER_CODE]
        answers = bench.say(*_reference(bench, coarse))
        if bench.state is NodeState.FAULT:
            break
        bench.speed += away * 4.0 * PERIOD  # the servo pushes, and the joint goes the other way
        assert abs(bench.q[bench.index] - start) < hidden / abs(p[Parameter.COUNTS_PER_UNIT])
    (emergency,) = bench.emergencies()
    assert emergency.fault == FaultCode.RUNAWAY
    assert bench.dacs(answers)[-1].current_dac == 0
    assert abs(bench.speed) < p[Parameter.SPEED_LIMIT]


def _reference(bench: JointBench, coarse: float) -> tuple:  # type: ignore[type-arg]
    from rfms_can.wire.records import Reference

    return Reference, bench.number, round(coarse), 0, 0, bench.cycle & 0xFF


def test_a_joint_that_an_obstacle_throws_back_goes_on(bench: JointBench) -> None:
    """Away from its set-point for four cycles in a row, then it stands still for one."""
    by = 0.0
    for k in range(1, 121):
        speed = 0.0 if k % 5 == 0 else AWAY_SPEED
        by += speed * PERIOD
        displaced(bench, by, speed)
    assert by > 3.0 * bound(bench)
    assert not bench.node.faults


def test_a_blocked_joint_does_not_run_away(wire: Wire) -> None:
    """The set-point leaves, the joint stands."""
    p = JointBench(wire).parameters
    watch = RunawayWatch(p, 5)
    assert all(not watch.watch(k * 0.004, 0.3) for k in range(100))


def test_a_joint_that_lags_ever_more_but_moves_along_does_not_run_away(wire: Wire) -> None:
    p = JointBench(wire).parameters
    watch = RunawayWatch(p, 5)
    assert all(not watch.watch(k * 0.004, k * 0.002) for k in range(100))


def test_a_joint_that_complies_may_be_pushed_away(bench: JointBench) -> None:
    bench.rows(7, selection=0b100, damping=5.0, specification=1)
    bench.run(2)
    by = 0.0
    for _ in range(40):
        by += AWAY_SPEED * PERIOD
        displaced(bench, by, AWAY_SPEED)
    assert by > 2.0 * bound(bench)
    assert not bench.node.faults


def test_without_a_proportional_gain_the_following_error_limit_is_the_bound(wire: Wire) -> None:
    p = {**JointBench(wire).parameters, Parameter.KP: 0.0, Parameter.SPEED_LIMIT: 50.0}
    assert RunawayWatch(p, 5).bound == pytest.approx(0.5 * FOLLOWING_ERROR_RAD)

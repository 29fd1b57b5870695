"""What a joint makes of single numbers: which is which, and what its EMCY tells of them."""

import pytest
from support.bench import PERIOD_NS
from support.joint_bench import ANY_SPEED, JointBench, step_limit

from rfms_can.joint_nodes.friction import FrictionCompensation
from rfms_can.wire.contract import ESTOP_VALUES, Wire
from rfms_can.wire.records import Config, Estop
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState, Parameter

PERIOD = PERIOD_NS * 1e-9


@pytest.fixture
def bench(wire: Wire) -> JointBench:
    return JointBench(wire).enable()


@pytest.mark.parametrize("held", [0, 1, 2])
def test_the_bound_of_a_step_is_told_with_the_cycles_held(bench: JointBench, held: int) -> None:
    for _ in range(held):
        bench.sync()
        bench.measure()
        bench.other_errors()
    bench.sync()
    bench.measure()
    goal = list(bench.q)
    goal[bench.index] += 4.0 * step_limit(bench)
    (emergency,) = bench.emergencies(bench.setpoint(goal))
    assert emergency.fault == FaultCode.SETPOINT_STEP
    assert emergency.bound == pytest.approx((1 + held) * step_limit(bench), rel=1e-6)
    assert emergency.value == pytest.approx(4.0 * step_limit(bench), rel=1e-3)


def test_a_stopped_joint_is_held_by_its_error_and_braked_by_its_speed(wire: Wire) -> None:
    bench = JointBench(wire, changes=ANY_SPEED).enable()
    p = bench.parameters
    bench.command(Command.QUICKSTOP)
    codes = []
    for angle, speed in ((0.0, 0.0), (-0.001, 0.0), (0.0, 0.2)):
        bench.sync(NodeState.QUICKSTOP)
        bench.speed = speed
        (dac,) = bench.dacs(bench.measure(bench.q[bench.index] + angle))
        codes.append(dac.current_dac)
    rest, behind, moving = codes
    scale = p[Parameter.TORQUE_PER_CODE]
    assert behind - rest == pytest.approx(p[Parameter.KP] * 0.001 / scale, rel=0.2)
    assert moving - rest == pytest.approx(-p[Parameter.KD] * 0.2 / scale, rel=0.2)


def test_friction_of_a_complying_joint_is_asked_by_speeds_and_cycle(
    bench: JointBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[tuple[float, ...]] = []

    def complying(_self: object, *numbers: float) -> float:
        asked.append(numbers)
        return 0.0

    monkeypatch.setattr(FrictionCompensation, "complying", complying)
    bench.rows(1, selection=1)
    held, bench.speed = list(bench.q), 0.1
    bench.controller.servo.state.intended_speed = 0.05
    bench.sync()
    bench.setpoint(held)
    bench.measure()
    bench.other_errors()
    ((desired, speed, _intended, cycle),) = asked
    assert desired == pytest.approx(0.0, abs=1e-9)
    assert speed == pytest.approx(bench.read_speed)
    assert cycle == bench.cycle


def test_a_reset_forgets_counters_and_half_a_configuration(wire: Wire) -> None:
    bench = JointBench(wire)
    frame = bench.sender(Config, bench.number).frame(Parameter.PERIOD, 0, PERIOD, 0)
    assert len(bench.give(frame)) == 1 and bench.give(frame) == []
    assert set(bench.node.parameters) == {Parameter.PERIOD}
    bench.command(Command.RESET)
    assert bench.node.parameters == {}
    assert len(bench.give(frame)) == 1


def test_before_the_first_sync_an_emergency_tells_no_cycle(wire: Wire) -> None:
    bench = JointBench(wire)
    (emergency,) = bench.emergencies(bench.say(Estop, None, *ESTOP_VALUES))
    assert emergency.cycle == 0xFF


@pytest.mark.parametrize(("first", "state"), [(0, NodeState.QUICKSTOP), (1, NodeState.OPERATIONAL)])
def test_a_first_cycle_that_is_lost_counts_as_held(
    bench: JointBench, first: int, state: NodeState
) -> None:
    bench.command(Command.STOP)
    bench.command(Command.START)
    bench.cycle = first - 1
    bench.sync()
    bench.measure()
    goal = list(bench.q)
    goal[bench.index] += 1.5 * step_limit(bench)
    bench.setpoint(goal)
    assert bench.state is state

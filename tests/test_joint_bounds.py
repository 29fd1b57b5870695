"""Set-points, measurements and limits: what a joint does not follow, and where it stops."""

import math

import pytest
from support.bench import PERIOD_NS
from support.joint_bench import ANY_SPEED, JointBench, step_limit

from rfms_can.joint_nodes.ladder import Reaction
from rfms_can.joint_nodes.sensing import HARD_MARGIN_RAD, SOFT_MARGIN_RAD
from rfms_can.wire.contract import Wire
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState, Parameter

PERIOD = PERIOD_NS * 1e-9


@pytest.fixture
def bench(wire: Wire) -> JointBench:
    return JointBench(wire).enable()


def code_of_one_cycle(bench: JointBench) -> int:
    (dac,) = bench.dacs(bench.run())
    return dac.current_dac


# --- set-points and measurements out of bounds ------------------------------------------------


@pytest.mark.parametrize("step", [0.05, -0.05, 0.5, 1.0, -1.0])
def test_a_setpoint_step_beyond_the_speed_limit_is_refused_and_stops_the_joint(
    bench: JointBench, step: float
) -> None:
    bench.run(10)
    rest = code_of_one_cycle(bench)
    held = bench.q[bench.index]
    bench.sync()
    bench.setpoint([*bench.q[:1], held + step, *bench.q[2:]])
    assert bench.errors(bench.measure()) == []
    (emergency,) = bench.emergencies()
    assert emergency.fault == FaultCode.SETPOINT_STEP
    assert emergency.value == pytest.approx(step, abs=1e-5)
    assert bench.state is NodeState.QUICKSTOP
    for _ in range(50):  # and nothing of the step acts: the joint holds where it was
        bench.sync(NodeState.QUICKSTOP)
        (dac,) = bench.dacs(bench.measure())
        assert abs(dac.current_dac - rest) <= 1


def test_a_setpoint_as_fast_as_the_joint_may_run_is_taken(bench: JointBench) -> None:
    for sign in (1.0, -1.0):
        bench.reach(sign * bench.parameters[Parameter.SPEED_LIMIT])
        for _ in range(20):
            assert bench.errors(bench.run())
    assert not bench.node.faults


@pytest.mark.parametrize("lost", [1, 2])
def test_setpoints_lost_at_full_speed_are_no_step(bench: JointBench, lost: int) -> None:
    bench.reach(bench.parameters[Parameter.SPEED_LIMIT])
    for k in range(30):
        if 10 <= k < 10 + lost:
            bench.sync()
            bench.measure()
            bench.other_errors()
        else:
            (error,) = bench.errors(bench.run())
            assert abs(error.acceleration) < 1.0 or k < 10
    assert set(bench.node.faults) == {FaultCode.SETPOINT_MISSING}


def test_setpoints_lost_before_a_new_start_excuse_no_step_after_it(bench: JointBench) -> None:
    for _ in range(2):
        bench.sync()
        bench.measure()
    bench.command(Command.STOP)
    bench.command(Command.START)
    bench.cycle = -1
    bench.sync()
    bench.measure()
    bench.setpoint([bench.q[0], bench.q[1] + 1.2 * step_limit(bench), *bench.q[2:]])
    assert bench.state is NodeState.QUICKSTOP


@pytest.mark.parametrize("lost", [1, 2])
def test_syncs_lost_at_full_speed_are_neither_step_nor_glitch(bench: JointBench, lost: int) -> None:
    bench.reach(bench.parameters[Parameter.SPEED_LIMIT])
    for k in range(30):
        if 10 <= k < 10 + lost:
            bench.sync(lost=True)
        else:
            (error,) = bench.errors(bench.run())
            assert abs(error.acceleration) < 1.0 or k < 10
    assert bench.state is NodeState.OPERATIONAL
    assert set(bench.node.faults) <= {FaultCode.SYNC_MISSING}


@pytest.mark.parametrize("lost", [1, 2])
def test_measurements_lost_at_full_speed_are_no_glitch(bench: JointBench, lost: int) -> None:
    bench.reach(bench.parameters[Parameter.SPEED_LIMIT])
    for k in range(30):
        if 10 <= k < 10 + lost:
            bench.sync()
            bench.setpoint()
            bench.other_errors()
        else:
            bench.run()
    assert set(bench.node.faults) == {FaultCode.MEASURE_MISSING}


def test_an_encoder_glitch_is_predicted_over(bench: JointBench) -> None:
    quiet = code_of_one_cycle(bench)
    for glitches in (1, 2):
        for _ in range(glitches):
            bench.sync()
            bench.setpoint()
            answers = bench.measure(bench.q[bench.index] + 0.3) + bench.other_errors()
            (dac,) = bench.dacs(answers)
            assert abs(dac.current_dac - quiet) <= 1
            assert abs(bench.errors(answers)[0].error) < 1e-3
        bench.run()
    assert bench.node.faults[FaultCode.ENCODER_GLITCH] == 3
    assert bench.state is NodeState.OPERATIONAL


@pytest.mark.parametrize("lost", [0, 1, 2])
def test_a_prediction_covers_the_cycles_whose_sync_was_lost_once(
    bench: JointBench, lost: int
) -> None:
    bench.reach(0.4)
    theta = bench.node.theta
    for _ in range(lost):
        bench.sync(lost=True)
    bench.sync()
    bench.measure(3.0)
    assert bench.node.theta - theta == pytest.approx((1 + lost) * bench.read_speed * PERIOD)


def test_prediction_goes_on_at_the_measured_speed(bench: JointBench) -> None:
    bench.reach(0.4)
    theta = bench.node.theta
    for k in (1, 2):
        bench.sync()
        bench.setpoint()
        bench.measure(3.0)
        assert bench.node.theta == pytest.approx(theta + k * bench.read_speed * PERIOD)


def test_an_encoder_that_stays_elsewhere_stops_the_joint_where_it_is(bench: JointBench) -> None:
    """What moved is the encoder, not the joint: no torque may try to bring it back."""
    bench.run(10)
    quiet = code_of_one_cycle(bench)
    elsewhere = bench.q[bench.index] + 0.3
    for k in range(40):
        bench.sync(NodeState.OPERATIONAL if k < 3 else NodeState.QUICKSTOP)
        bench.setpoint()
        for dac in bench.dacs(bench.measure(elsewhere) + bench.other_errors()):
            assert abs(dac.current_dac - quiet) <= 1
    assert bench.state is NodeState.QUICKSTOP
    assert [e.fault for e in bench.emergencies()] == [FaultCode.ENCODER_GLITCH]


# --- limits -----------------------------------------------------------------------------------


CREEP = 0.07
"""rad/s: of a joint that is no runaway."""


def near_limit(
    wire: Wire, upper: bool, inside: float, changes: dict[Parameter, float] | None = None
) -> JointBench:
    """A joint enabled near an end of its range."""
    bench = JointBench(wire, changes=changes)
    lower, upper_limit = bench.arm.joint_limits[bench.index]
    bench.q[bench.index] = upper_limit - inside if upper else lower + inside
    return bench.enable()


@pytest.mark.parametrize("upper", [True, False])
def test_beyond_the_range_torque_goes_off(wire: Wire, upper: bool) -> None:
    """A joint that is pushed outwards, too slowly to run away: it stops, then lets go."""
    bench = near_limit(wire, upper, 0.005)
    lower, upper_limit = bench.arm.joint_limits[bench.index]
    outwards = 1.0 if upper else -1.0
    held = list(bench.q)
    bench.run()
    bench.speed = outwards * CREEP
    beyond: dict[NodeState, float] = {}
    while bench.state is not NodeState.FAULT:
        bench.sync(bench.state)
        bench.setpoint(held)
        bench.measure()
        bench.other_errors()
        where = bench.q[bench.index]
        beyond[bench.state] = where - upper_limit if upper else lower - where
    soft, emergency = bench.emergencies()
    assert (soft.fault, emergency.fault) == (FaultCode.SOFT_LIMIT, FaultCode.HARD_LIMIT)
    assert beyond[NodeState.OPERATIONAL] == pytest.approx(SOFT_MARGIN_RAD, abs=2e-3)
    assert beyond[NodeState.FAULT] == pytest.approx(HARD_MARGIN_RAD, abs=1e-3)
    assert emergency.culprit == bench.number
    assert outwards * emergency.value == pytest.approx(outwards * where, abs=1e-4)
    assert bench.node.reaction is Reaction.OFF
    assert bench.dacs()[-1].current_dac == 0
    count = len(bench.dacs())
    bench.run(5)
    assert len(bench.dacs()) == count


@pytest.mark.parametrize("upper", [True, False])
def test_too_fast_towards_the_end_of_the_range_stops_in_time(wire: Wire, upper: bool) -> None:
    inside = 0.1
    bench = near_limit(wire, upper, inside, ANY_SPEED)
    deceleration = bench.parameters[Parameter.ACCELERATION_LIMIT]
    fast = math.sqrt(2.0 * deceleration * (inside + SOFT_MARGIN_RAD))
    outwards = 1.0 if upper else -1.0
    bench.speed = 0.95 * fast * outwards
    bench.run()
    bench.speed = 1.05 * fast * -outwards  # away from the end: as fast as it likes
    assert len(bench.dacs(bench.run())) == 1
    bench.speed = 1.05 * fast * outwards
    bench.run()
    assert [e.fault for e in bench.emergencies()] == [FaultCode.SOFT_LIMIT]
    assert bench.state is NodeState.QUICKSTOP


@pytest.mark.parametrize("upper", [True, False])
def test_a_controlled_stop_ends_inside_the_range(wire: Wire, upper: bool) -> None:
    """A motion that does not slow down for the end is stopped before it."""
    bench = near_limit(wire, upper, 1.0)
    outwards = 1.0 if upper else -1.0
    speed = 0.9 * bench.parameters[Parameter.SPEED_LIMIT]
    bench.reach(outwards * speed)
    while bench.state is NodeState.OPERATIONAL:
        bench.run()
    assert bench.state is NodeState.QUICKSTOP
    ramp = bench.controller.ramp
    assert ramp is not None
    assert abs(ramp.speed) == pytest.approx(speed, rel=0.03)  # it has made its first step
    while ramp.speed:
        ramp.step()
    lower, upper_limit = bench.arm.joint_limits[bench.index]
    assert lower - 1e-3 <= ramp.position <= upper_limit + 1e-3


def test_a_stopped_joint_pushed_out_of_its_range_goes_off(wire: Wire) -> None:
    bench = near_limit(wire, True, 0.02)
    bench.command(Command.QUICKSTOP)
    bench.speed = CREEP  # so that it does not run away
    for _ in range(300):
        bench.sync(NodeState.QUICKSTOP)
        bench.measure()
    faults = [FaultCode.SOFT_LIMIT, FaultCode.HARD_LIMIT]  # it stops already; then it lets go
    assert [e.fault for e in bench.emergencies()] == faults
    assert bench.dacs()[-1].current_dac == 0

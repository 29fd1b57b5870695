"""OVERSPEED, FOLLOWING_ERROR, STALL, OVERLOAD: a torque that has not the effect it should have."""

import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from support.bench import PERIOD_NS, Heard
from support.joint_bench import ANY_SPEED, JointBench

from rfms_can.arm import PUMA_260
from rfms_can.joint_nodes.detectors.drive import OverloadWatch, StallWatch
from rfms_can.joint_nodes.detectors.following import Excess, FollowingWatch
from rfms_can.joint_nodes.ladder import Reaction
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.wire.contract import BIAS_BELONGS, Wire
from rfms_can.wire.records import Bias, Emcy, Measure
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState, Parameter

PERIOD = PERIOD_NS * 1e-9
PARAMETERS = all_parameters(PUMA_260, "corke", PERIOD)[2]
P = Parameter
TAU, LIMIT = PARAMETERS[P.PERIOD], PARAMETERS[P.TORQUE_LIMIT]
CONTINUOUS = PARAMETERS[P.CONTINUOUS_TORQUE]
FASTEST = PARAMETERS[P.SPEED_LIMIT]


def only(bench: JointBench, fault: FaultCode) -> Emcy:
    """The one EMCY of a joint, which blames the joint and its sample."""
    (emergency,) = bench.emergencies()
    assert emergency.fault == fault
    assert (emergency.culprit, emergency.frame) == (bench.number, bench.wire.id(Measure, 2))
    return emergency


def cycle(bench: JointBench, **told: float) -> list[Heard]:
    """One cycle, with what MEASURE tells."""
    answers = bench.sync() + bench.setpoint()
    answers += bench.measure(**told)  # type: ignore[arg-type]
    return answers + bench.other_errors()


# --- overspeed ------------------------------------------------------------------------------------


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_joint_that_is_too_fast_for_two_cycles_loses_its_torque(wire: Wire, sign: float) -> None:
    changes = {**ANY_SPEED, P.OVERSPEED_LIMIT: 1.8}
    bench = JointBench(wire, changes=changes).enable()
    for _ in range(5):
        cycle(bench, speed=sign * 1.81)
        cycle(bench, speed=sign * 1.79)
    assert bench.node.faults == {FaultCode.OVERSPEED: 5}
    assert bench.emergencies() == []
    cycle(bench, speed=sign * 1.81)
    answers = cycle(bench, speed=sign * 1.82)
    emergency = only(bench, FaultCode.OVERSPEED)
    assert emergency.value == pytest.approx(sign * 1.82, abs=1e-3)
    assert emergency.bound == pytest.approx(1.8)
    assert bench.node.reaction is Reaction.OFF
    assert [dac.current_dac for dac in bench.dacs(answers)] == [0]


@pytest.mark.parametrize("state", [NodeState.QUICKSTOP, NodeState.FAULT])
def test_overspeed_is_watched_wherever_the_joint_drives(wire: Wire, state: NodeState) -> None:
    changes = {**ANY_SPEED, P.OVERSPEED_LIMIT: 1.8}
    bench = JointBench(wire, changes=changes).enable()
    if state is NodeState.QUICKSTOP:
        bench.command(Command.QUICKSTOP)
    else:
        bench.miss_syncs(5)
    assert bench.state is state
    for _ in range(2):
        assert bench.node.reaction is not Reaction.OFF
        bench.sync(NodeState.QUICKSTOP)
        bench.measure(speed=1.9)
    assert bench.emergencies()[-1].fault == FaultCode.OVERSPEED
    assert bench.node.reaction is Reaction.OFF


# --- following ------------------------------------------------------------------------------------

UNSEEN = {P.TACHOMETER_LIMIT: FASTEST}
"""A joint that is told a speed by its tachometer alone, and does not mind for a while."""


def test_a_rigid_joint_may_be_off_up_to_its_bounds() -> None:
    watch = FollowingWatch(PARAMETERS)
    error, rate = PARAMETERS[P.FOLLOWING_ERROR_LIMIT], PARAMETERS[P.RATE_ERROR_LIMIT] * FASTEST
    for sign in (1.0, -1.0):
        assert watch.servoing(sign * error, sign * rate) is None
        assert watch.servoing(sign * error * 1.001, sign * rate) == Excess(
            sign * error * 1.001, error
        )
        assert watch.servoing(sign * error, sign * rate * 1.001) == Excess(
            sign * rate * 1.001, rate
        )
    both = watch.servoing(2.0 * error, 2.0 * rate)
    assert both == Excess(2.0 * rate, rate), "the rate is told before the error"


@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_a_stop_may_be_as_fast_as_it_began_and_a_rate_error_more(
    began: float, speed: float
) -> None:
    watch = FollowingWatch(PARAMETERS)
    watch.begin_stop(began)
    bound = abs(began) + PARAMETERS[P.RATE_ERROR_LIMIT] * FASTEST
    assume(abs(abs(speed) - bound) > 1e-9)
    excess = watch.stopping(0.0, speed)
    assert excess == (Excess(speed, bound) if abs(speed) > bound else None)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_joint_that_is_faster_than_it_is_told_loses_its_torque_in_two_cycles(
    wire: Wire, sign: float
) -> None:
    bench = JointBench(wire, changes=UNSEEN).enable()
    bound = bench.parameters[P.RATE_ERROR_LIMIT] * FASTEST
    for _ in range(3):  # single cycles are none
        cycle(bench, speed=sign * 1.02 * bound)
        bench.run(8)
    assert bench.node.faults == {FaultCode.FOLLOWING_ERROR: 3}
    for _ in range(3):
        cycle(bench, speed=sign * 0.98 * bound)
        bench.run(8)
    assert bench.node.faults == {FaultCode.FOLLOWING_ERROR: 3}
    assert bench.errors(cycle(bench, speed=sign * 1.02 * bound))
    answers = cycle(bench, speed=sign * 1.02 * bound)
    assert bench.errors(answers) == [], "nothing of an error goes out that took the torque off"
    emergency = only(bench, FaultCode.FOLLOWING_ERROR)
    assert emergency.value == pytest.approx(-sign * 1.02 * bound, abs=2e-3)
    assert emergency.bound == pytest.approx(bound)
    assert [dac.current_dac for dac in bench.dacs(answers)] == [0]


def test_a_joint_that_is_left_behind_loses_its_torque(wire: Wire) -> None:
    """It is held fast, and the set-point goes on, slowly."""
    bench = JointBench(wire, changes={P.FOLLOWING_ERROR_LIMIT: 0.02, P.STALL_TIME: 5.0}).enable()
    held = bench.q[bench.index]
    for _ in range(200):
        bench.q[bench.index] += 0.1 * FASTEST * PERIOD
        cycle(bench, theta=held)
        if bench.state is NodeState.FAULT:
            break
    emergency = only(bench, FaultCode.FOLLOWING_ERROR)
    assert emergency.bound == pytest.approx(0.02)
    assert 0.02 < emergency.value < 0.02 + 3 * 0.1 * FASTEST * PERIOD


def test_a_joint_that_complies_need_not_follow(wire: Wire) -> None:
    bench = JointBench(wire, changes=UNSEEN).enable()
    cycle(bench, speed=0.5)
    assert bench.node.faults == {FaultCode.FOLLOWING_ERROR: 1}
    bench.rows(7, selection=0b100, damping=5.0, specification=1)
    cycle(bench, speed=0.5)
    cycle(bench, speed=0.5)
    bench.rows(8, specification=2)
    cycle(bench, speed=0.5)  # the count began again: two cycles in a row are rigid ones
    assert bench.node.faults == {FaultCode.FOLLOWING_ERROR: 2}
    assert bench.state is NodeState.OPERATIONAL


def test_a_stop_that_gets_faster_ends(wire: Wire) -> None:
    bench = JointBench(wire, changes=UNSEEN).enable()
    bench.reach(0.4 * FASTEST)
    bench.run(10)
    bench.command(Command.QUICKSTOP)
    bound = bench.speed + bench.parameters[P.RATE_ERROR_LIMIT] * FASTEST
    for factor in (0.99, 1.01, 0.99, 1.01, 1.01):
        assert bench.state is NodeState.QUICKSTOP
        bench.sync(NodeState.QUICKSTOP)
        bench.measure(speed=factor * bound)
    assert bench.node.faults == {FaultCode.FOLLOWING_ERROR: 3}
    emergency = only(bench, FaultCode.FOLLOWING_ERROR)
    assert emergency.bound == pytest.approx(bound, abs=2e-3)
    assert emergency.value == pytest.approx(1.01 * bound, abs=2e-3)
    assert bench.dacs()[-1].current_dac == 0


# --- stall ----------------------------------------------------------------------------------------


def test_torques_at_the_limit_are_counted_while_the_joint_stands() -> None:
    watch, slow = StallWatch(PARAMETERS), 0.0199 * FASTEST
    assert watch.bound == math.ceil(PARAMETERS[P.STALL_TIME] / TAU)
    for _ in range(watch.bound):
        assert not watch.stalls(True, slow)
    assert watch.stalls(True, -slow)
    for cut, speed in ((False, 0.0), (True, 0.0201 * FASTEST), (True, -0.0201 * FASTEST)):
        assert not watch.stalls(cut, speed)
        assert watch.run == 0
        assert not watch.stalls(True, 0.0)


@pytest.mark.parametrize("stopped", [False, True])
def test_a_joint_that_pushes_and_does_not_turn_is_damped(wire: Wire, stopped: bool) -> None:
    bench = JointBench(wire, changes={P.STALL_TIME: 0.04}).enable()
    bench.rows(1, gravity=LIMIT)
    bench.run()
    if stopped:
        bench.command(Command.QUICKSTOP)
    cycles, goal = 0, [*bench.q]
    goal[bench.index] += 0.0005
    bench.q[bench.index] -= 0.0005  # it has yielded a little, and stands
    while bench.state is not NodeState.FAULT:
        cycles += 1
        bench.sync(bench.state)
        bench.setpoint(goal)
        answers = bench.measure() + bench.other_errors()
        assert cycles < 30
    assert 10 <= cycles <= 13
    emergency = only(bench, FaultCode.STALL)
    assert emergency.value == pytest.approx(11 * TAU)
    assert emergency.bound == pytest.approx(0.04)
    assert bench.node.reaction is Reaction.DAMP
    assert len(bench.dacs(answers)) == 1, "the torque goes out all the same"


# --- overload -------------------------------------------------------------------------------------


@given(st.lists(st.floats(-LIMIT, LIMIT), max_size=40), st.floats(0.02, 0.2))
def test_heat_is_the_largest_integral_that_ends_now(torques: list[float], seconds: float) -> None:
    watch = OverloadWatch({**PARAMETERS, P.OVERLOAD_TIME: seconds})
    assert watch.bound == pytest.approx(seconds * (LIMIT**2 - CONTINUOUS**2))
    powers = [TAU * (torque**2 - CONTINUOUS**2) for torque in torques]
    for k, torque in enumerate(torques):
        heat = max(0.0, *(sum(powers[begin : k + 1]) for begin in range(k + 1)))
        assume(abs(heat - watch.bound) > 1e-6)
        bears = watch.bears(torque)
        assert watch.heat == pytest.approx(heat, abs=1e-9)
        assert bears == (heat <= watch.bound or abs(torque) <= CONTINUOUS)


def test_the_limit_is_borne_for_its_time_and_the_continuous_torque_for_ever() -> None:
    watch = OverloadWatch({**PARAMETERS, P.OVERLOAD_TIME: 0.4})
    assert all(watch.bears(CONTINUOUS) for _ in range(10_000))
    borne = 0
    while watch.bears(-LIMIT):
        borne += 1
    assert borne in (99, 100)
    assert watch.bears(CONTINUOUS), "it cools no slower than it is asked for"


def carried(bench: JointBench) -> int:
    """Good cycles until the joint stops."""
    cycles = 0
    while bench.state is NodeState.OPERATIONAL:
        bench.run()
        cycles += 1
    return cycles


def test_a_joint_that_carries_too_much_is_damped_also_after_reset(wire: Wire) -> None:
    """A motor does not cool by a command."""
    bench = JointBench(wire, changes={P.OVERLOAD_TIME: 0.1}).enable()
    bench.rows(1, gravity=0.9 * LIMIT)
    cycles = carried(bench)
    heat = TAU * ((0.9 * LIMIT) ** 2 - CONTINUOUS**2)
    bound = 0.1 * (LIMIT**2 - CONTINUOUS**2)
    assert cycles == pytest.approx(bound / heat, abs=2)
    emergency = only(bench, FaultCode.OVERLOAD)
    assert emergency.bound == pytest.approx(bound, rel=1e-5)
    assert bound < emergency.value < bound + 1.2 * heat
    assert bench.node.reaction is Reaction.DAMP
    bench.command(Command.RESET)
    before = bench.controller.motion.overload.heat
    bench.home()
    bench.rows(2, gravity=0.9 * LIMIT)
    bench.start()
    assert bench.controller.motion.overload.heat > 0.8 * before
    assert carried(bench) < 5
    bench.command(Command.RESET)
    bench.parameters[P.KI] += 1.0
    bench.configure()
    assert bench.controller.motion.overload.heat == 0.0


def test_a_braked_joint_cools(wire: Wire) -> None:
    bench = JointBench(wire, changes={P.OVERLOAD_TIME: 0.1}).enable()
    bench.rows(1, gravity=0.9 * LIMIT)
    bench.run(15)
    assert bench.controller.motion.overload.heat > 0.0
    bench.command(Command.STOP)
    for _ in range(40):
        bench.sync(NodeState.READY)
        bench.measure()
    assert bench.controller.motion.overload.heat == 0.0


def test_the_bias_heats_as_the_servo_does(wire: Wire) -> None:
    bench = JointBench(wire).enable()
    bench.rows(1, gravity=0.9 * CONTINUOUS)
    bench.run(30)
    assert bench.controller.motion.overload.heat == 0.0
    for _ in range(3):
        bench.sync()
        bench.setpoint(extras=BIAS_BELONGS)
        bench.measure()
        bench.other_errors()
        bench.say(Bias, None, *(0.3 * CONTINUOUS,) * 6, bench.cycle & 0xFF)
    bench.run(1)
    borne = 3.0 * TAU * ((1.2 * CONTINUOUS) ** 2 - CONTINUOUS**2)
    assert bench.controller.motion.overload.heat == pytest.approx(borne, rel=0.01)

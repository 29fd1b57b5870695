"""What docs/node.md and node-law.md answer to the questions of one who wrote a joint from them."""

import math

import pytest
from node_book.pump import JOINT, Pump, parameters

from rfms_can.arm import PUMA_260
from rfms_can.joint_nodes.homing import Homing
from rfms_can.joint_nodes.servo import Servo
from rfms_can.kinematics import configuration_of, direct
from rfms_can.node.encoder_reference import EncoderReference
from rfms_can.setpoint.cartesian import CartesianSetpoint
from rfms_can.setpoint.frames import values_of
from rfms_can.wire.frame import Frame
from rfms_can.wire.records import Dac, JointError, Measure, Reference, Setpoint
from rfms_can.wire.vocabulary import (
    Blend,
    Command,
    FaultCode,
    Mode,
    NodeState,
    Parameter,
    TrajectoryState,
)

OPERATIONAL = NodeState.OPERATIONAL
STEP_COUNTS = abs(
    1.5
    * parameters()[Parameter.SPEED_LIMIT]
    * parameters()[Parameter.PERIOD]
    * parameters()[Parameter.COUNTS_PER_UNIT]
)
"""The step that an encoder may make in a cycle."""


@pytest.fixture
def pump() -> Pump:
    return Pump().enabled()


def identifiers(frames: list[Frame]) -> list[int]:
    return [frame.id for frame in frames]


def out_of_sequence(pump: Pump) -> list[Frame]:
    """A BLEND straight after IDLE, where the arm is."""
    q = list(PUMA_260.park)
    pose, configuration = direct(PUMA_260, q), configuration_of(PUMA_260, q)
    setpoint = CartesianSetpoint(
        *(TrajectoryState.BLEND, Mode.JOINT, Blend.CONTINUOUS, 0.0, 0.5, 0.2),
        *(pose, configuration, None, configuration),
    )
    return pump.say(Setpoint, 1, *values_of(setpoint, pose, configuration, pump.cycle))


def test_what_comes_after_start_in_its_cycle_is_acted_upon() -> None:
    pump = Pump()
    pump.introduce()
    pump.configure()
    pump.home()
    pump.sync(NodeState.READY)
    cycle = pump.cycle
    pump.command(Command.START)
    pump.cycle = cycle
    pump.setpoint()
    error, dac = pump.wire.id(JointError, JOINT), pump.wire.id(Dac, JOINT)
    assert identifiers(pump.measure()) == [error]
    (answer,) = pump.other_errors()
    assert (answer.id, answer.data[7]) == (dac, cycle)


def test_a_good_setpoint_may_follow_a_refused_one(pump: Pump) -> None:
    pump.sync(OPERATIONAL)
    pump.measure()
    assert out_of_sequence(pump) == []
    assert identifiers(pump.setpoint()) == [pump.wire.id(JointError, JOINT)]


def test_a_cycle_in_which_reset_was_taken_owes_nothing(pump: Pump) -> None:
    pump.command(Command.QUICKSTOP)
    pump.sync(OPERATIONAL)
    pump.command(Command.RESET)
    pump.command(Command.HOME)
    pump.sync(OPERATIONAL)
    assert (pump.node.state, pump.node.error_register) == (NodeState.HOMING, 0)
    pump.sync(OPERATIONAL)  # that one had begun in HOMING
    assert set(pump.node.faults) == {FaultCode.SETPOINT_MISSING}


def test_one_in_which_stop_and_home_were_taken_owes_what_it_did(pump: Pump) -> None:
    pump.sync(OPERATIONAL)
    pump.command(Command.STOP)
    pump.command(Command.HOME)
    pump.sync(NodeState.HOMING)
    assert set(pump.node.faults) == {FaultCode.MEASURE_MISSING}


@pytest.mark.parametrize(("steps", "glitches"), [(2.9, 0), (3.1, 1)])
def test_the_sync_after_run_offs_of_the_watchdog_counts_at_least_one(
    pump: Pump, steps: float, glitches: int
) -> None:
    pump.miss_sync()
    pump.miss_sync()
    pump.sync(OPERATIONAL)
    pump.measure(off=round(steps * STEP_COUNTS))
    assert pump.node.ladder.misses[FaultCode.ENCODER_GLITCH] == glitches


@pytest.mark.parametrize(("steps", "glitches"), [(1.9, 0), (2.1, 1)])
def test_so_does_a_sync_that_goes_back(pump: Pump, steps: float, glitches: int) -> None:
    pump.run(4)
    pump.sync(OPERATIONAL)
    pump.cycle -= 3
    pump.sync(OPERATIONAL)
    pump.measure(off=round(steps * STEP_COUNTS))
    assert pump.node.ladder.misses[FaultCode.ENCODER_GLITCH] == glitches


def test_homing_tells_the_last_of_what_fails_in_a_cycle_and_takes_no_index_then() -> None:
    used = {**parameters(), Parameter.HOMING_TIME: 0.1}
    encoder, period = EncoderReference(used), used[Parameter.PERIOD]
    homing, longest = Homing(used, encoder, Servo(used, JOINT)), math.ceil(0.1 / period)
    far = round(0.1 / used[Parameter.COARSE_PER_CODE])
    for cycle in range(longest):
        homing.step(Measure(cycle, 0, 0, 0, 0, 0), Reference(1000, 0, 0, 0), 0.0, 0.0)
        assert homing.failure is None
    measure, coarse = Measure(0, 0, 0, 0, 0, 0), encoder.coarse_angle(1000 + far)
    index = -round(coarse * used[Parameter.COUNTS_PER_UNIT])
    reference = Reference(1000 + far, index, 1, 0)
    assert EncoderReference(used).find(measure, reference), "a good index by itself"
    homing.step(measure, reference, 0.0, 0.0)
    assert homing.failure is not None
    assert (homing.failure.value, homing.failure.bound) == pytest.approx(
        ((longest + 1) * period, longest * period)
    )
    assert encoder.zero_counts is None

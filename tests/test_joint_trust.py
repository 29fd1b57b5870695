"""What a joint believes of its bus: frames that no node of ours would send, at any moment."""

from collections.abc import Callable

import pytest
from support.bench import FieldNodeBench
from support.joint_bench import JointBench

from rfms_can.arm import ARMS, Arm
from rfms_can.joint_nodes.gripper import GripperNode
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import GRIPPER, JOINTS, MASTER
from rfms_can.wire.records import (
    Bias,
    Comply,
    Config,
    Heartbeat,
    JointAngles,
    Nmt,
    Setpoint,
)
from rfms_can.wire.vocabulary import Command, ConfigStatus, FaultCode, NodeState, Parameter

STEPS: list[Callable[[JointBench], object]] = [
    lambda bench: bench.sync(),
    lambda bench: bench.setpoint(),
    lambda bench: bench.measure(),
    lambda bench: bench.other_errors(without=(1, 3, 4)),
    lambda bench: bench.other_errors(without=(5, 6)),
]
"""One cycle of a bus, in pieces."""


@pytest.mark.parametrize("command", Command)
@pytest.mark.parametrize("at", range(len(STEPS) + 1))
def test_a_command_between_any_two_frames_of_a_cycle_never_raises(
    wire: Wire, command: Command, at: int
) -> None:
    """Also not in the cycles after it, whose frames then belong to another state."""
    bench = JointBench(wire).enable()
    for step in STEPS[:at]:
        step(bench)
    bench.say(Nmt, None, command, 0, 0)
    for step in STEPS[at:]:
        step(bench)
    bench.run(3)
    for step in STEPS[:at]:
        step(bench)
    bench.miss_syncs(2)
    assert bench.state in NodeState


def beat_of(bench: JointBench, boot_id: int) -> None:
    """The HEARTBEAT of a master."""
    values = (NodeState.OPERATIONAL, 0, 0, boot_id, bench.wire.dbc_hash, 0, 0, 0)
    frame = bench.wire.sender(Heartbeat, MASTER).frame(*values)
    bench.give(frame)


def test_a_second_master_does_not_take_the_counters_of_the_one_that_drives(wire: Wire) -> None:
    bench = JointBench(wire).enable()
    beat_of(bench, 0xA)
    for _ in range(20):
        bench.command(Command.ANNOUNCE)
        bench.run()
    beat_of(bench, 0xB)
    (emergency,) = bench.emergencies()
    assert emergency.fault == FaultCode.FOREIGN_MASTER
    foreign = wire.sender(Nmt)
    bench.give(foreign.frame(Command.RESET, 0, 0))  # counter 0: an old frame to this joint
    states = [bench.state]
    bench.say(Nmt, None, Command.RESET, 0, 0)  # of the one that drives
    states.append(bench.state)
    assert states == [NodeState.QUICKSTOP, NodeState.PREOP]


def test_a_joint_that_does_not_drive_ignores_a_second_master(wire: Wire) -> None:
    """The others drive: SYNC says so, and this joint lies in READY."""
    bench = JointBench(wire)
    bench.configure()
    bench.home()
    bench.sync()
    beat_of(bench, 0xA)
    beat_of(bench, 0xB)
    assert bench.node.ignored["HEARTBEAT of a second master"] == 1
    assert (bench.state, bench.emergencies()) == (NodeState.READY, [])


def test_a_master_that_starts_again_is_heard_once_the_other_is_silent(wire: Wire) -> None:
    bench = JointBench(wire).enable()
    beat_of(bench, 0xA)
    bench.run(20)
    bench.miss_syncs(60)
    beat_of(bench, 0xB)
    assert not bench.node.ignored["HEARTBEAT of a second master"]
    bench.give(wire.sender(Nmt).frame(Command.RESET, 0, 0))
    assert bench.state is NodeState.PREOP


def test_a_set_point_with_an_extra_of_a_later_version_is_not_followed(wire: Wire) -> None:
    bench = JointBench(wire).enable()
    for _ in range(40):
        bench.sync()
        bench.measure()
        assert bench.errors(bench.setpoint(extras=0b1000)) == []
    assert bench.emergencies()[-1].frame == wire.id(Setpoint, 1)
    assert bench.state is NodeState.QUICKSTOP


def test_a_frame_whose_bit_is_not_set_is_no_part_of_the_set_point(wire: Wire) -> None:
    """Whenever it comes: a joint that heard it in time would go elsewhere than one that did not."""
    bench = JointBench(wire).enable()
    bench.sync()
    low = bench.cycle & 0xFF
    bench.say(Comply, None, *(0.01,) * 6, low)
    bench.say(Bias, None, *(1.0,) * 6, low)
    bench.say(JointAngles, 1, *(0.01 + angle for angle in bench.q), low, 0b111111)
    answers = bench.setpoint() + bench.measure() + bench.other_errors()
    (error,), (dac,) = bench.errors(answers), bench.dacs(answers)
    assert error.error == pytest.approx(bench.q[bench.index] - bench.angle(), abs=1e-6)
    assert error.error_rate == 0.0
    assert dac.force_dac == 0


@pytest.mark.parametrize("torque_nm", [1e3, -1e3])
def test_a_bias_beyond_what_the_dac_gives_is_cut_to_it(wire: Wire, torque_nm: float) -> None:
    bench = JointBench(wire).enable()
    servo = bench.controller.servo
    limit = 2047 * abs(servo.config.torque_per_force_code)
    assert abs(servo.deliverable_bias(torque_nm)) == pytest.approx(limit, rel=1e-3)
    assert servo.deliverable_bias(0.5 * limit) == 0.5 * limit


# --- configuration ------------------------------------------------------------------------------


def test_a_parameter_of_an_earlier_master_does_not_spoil_the_set(wire: Wire) -> None:
    bench = JointBench(wire)
    bench.say(Config, 2, Parameter.KP, 0, 9.0, 0)  # a master that was killed at its first one
    bench.say(Nmt, None, Command.RESET, 0, 0)
    del bench.parameters[Parameter.KP]
    assert bench.dialogue()[-1].values.status == ConfigStatus.WRONG_HASH  # KP is not there


def test_a_parameter_after_commit_begins_an_empty_set(wire: Wire) -> None:
    bench = JointBench(wire)
    bench.configure()
    bench.say(Config, 2, Parameter.KP, 0, 9.0, 0)
    assert bench.node.config_hash == 0
    assert bench.commit()[-1].values.status == ConfigStatus.WRONG_HASH
    bench.configure()  # whole again


def test_a_commit_that_comes_again_changes_nothing(wire: Wire) -> None:
    """Its acknowledgement was lost, and the joint has homed since: it knows where it is."""
    bench = JointBench(wire)
    bench.configure()
    bench.home()
    controller = bench.controller
    bench.say(Nmt, None, Command.RESET, 0, 0)
    assert bench.commit()[-1].values.status == ConfigStatus.TAKEN
    assert bench.controller is controller


@pytest.mark.parametrize(
    ("lesser", "greater"),
    [
        (Parameter.POSITION_MIN, Parameter.POSITION_MAX),
        (Parameter.INTEGRAL_LIMIT, Parameter.TORQUE_LIMIT),
        (Parameter.CONTINUOUS_TORQUE, Parameter.TORQUE_LIMIT),
        (Parameter.HOMING_SPEED, Parameter.SPEED_LIMIT),
        (Parameter.TACHOMETER_LIMIT, Parameter.SPEED_LIMIT),
    ],
)
def test_bounds_that_contradict_each_other_are_refused_at_commit(
    wire: Wire, lesser: Parameter, greater: Parameter
) -> None:
    bench = JointBench(wire)
    a, b = bench.parameters[lesser], bench.parameters[greater]
    bench.parameters |= {lesser: b + 0.01 * (b - a or 1.0)}
    assert bench.dialogue()[-1].values.status == ConfigStatus.REFUSED_VALUE
    assert bench.node.controller is None


@pytest.mark.parametrize("arm", ARMS.values(), ids=lambda arm: arm.name)
def test_overspeed_may_be_half_as_fast_again_as_the_speed_limit_and_no_more(
    wire: Wire, arm: Arm
) -> None:
    """Also where float32 rounds the one up and the other down."""
    for joint in JOINTS:
        for factor, status in ((1.5, ConfigStatus.TAKEN), (1.50001, ConfigStatus.REFUSED_VALUE)):
            bench = JointBench(wire, joint, arm)
            limit = bench.parameters[Parameter.SPEED_LIMIT]
            bench.parameters[Parameter.OVERSPEED_LIMIT] = factor * limit
            assert bench.dialogue()[-1].values.status == status


def test_the_gripper_knows_no_parameter_of_a_joint_alone(wire: Wire) -> None:
    bench: FieldNodeBench[GripperNode] = FieldNodeBench(GripperNode(wire, 7), wire, {})
    (answer,) = bench.say(Config, GRIPPER, Parameter.DH_A_1, 0, 0.0, 0)
    assert answer.values.status == ConfigStatus.UNKNOWN


@pytest.mark.parametrize("parameter", [42, 63, 200])
def test_a_parameter_of_a_later_version_is_unknown_and_leaves_the_set_whole(
    wire: Wire, parameter: int
) -> None:
    bench = JointBench(wire)
    bench.configure()
    (answer,) = bench.say(Config, 2, parameter, 0, 1.0, 0)
    assert answer.values[:2] == (parameter, ConfigStatus.UNKNOWN)
    assert bench.node.controller is not None

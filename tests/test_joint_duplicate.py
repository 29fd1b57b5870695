"""DUPLICATE_NODE: a node that hears its own identifiers does not drive beside another one."""

from typing import NamedTuple

import pytest
from support.joint_bench import JointBench

from rfms_can.joint_nodes.gripper import GripperNode
from rfms_can.joint_nodes.joint import JointNode
from rfms_can.node.protocol import hears_itself
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.records import ConfigAck, Dac, Emcy, Heartbeat, JointError
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState

BEAT = (NodeState.PREOP, 0, 0, 0xB007, 0, 0, 0, 0)
OWN: tuple[tuple[type[NamedTuple], tuple[float, ...]], ...] = (
    (Heartbeat, BEAT),
    (Emcy, (FaultCode.SYNC_MISSING, 0, 0, 1.0, 0.0, 0, 3)),
    (ConfigAck, (0, 0, 260.0, 0)),
    (JointError, (0.0, 0.0, 0.0, 0)),
    (Dac, (0, 0, 0)),
)


def other_says(bench: JointBench, record: type[NamedTuple], values: tuple[float, ...]) -> None:
    bench.say(record, bench.number, *values)


@pytest.mark.parametrize(("record", "values"), OWN, ids=lambda x: getattr(x, "__name__", ""))
def test_a_second_node_of_its_number_stops_a_joint_in_motion(
    wire: Wire, record: type[NamedTuple], values: tuple[float, ...]
) -> None:
    bench = JointBench(wire).enable()
    bench.run(3)
    other_says(bench, record, values)
    (emergency,) = bench.emergencies()
    assert emergency.fault == FaultCode.DUPLICATE_NODE
    assert emergency.culprit == bench.number
    assert emergency.frame == wire.id(record, bench.number)
    assert bench.state is NodeState.QUICKSTOP
    for command in (Command.START, Command.HOME, Command.STOP):
        bench.command(command)
        assert bench.state is NodeState.QUICKSTOP
    bench.command(Command.RESET)
    assert bench.node.state.name == "PREOP"


def test_it_says_so_once(wire: Wire) -> None:
    bench = JointBench(wire).enable()
    for _ in range(3):
        other_says(bench, Heartbeat, BEAT)
    assert len(bench.emergencies()) == 1


def test_any_other_joint_goes_to_preop_and_does_not_home_until_reset(wire: Wire) -> None:
    for reached in (NodeState.PREOP, NodeState.HOMING, NodeState.READY):
        bench = JointBench(wire)
        bench.configure()
        if reached is NodeState.HOMING:
            bench.command(Command.HOME)
        elif reached is NodeState.READY:
            bench.home()
        assert bench.state is reached
        other_says(bench, Heartbeat, BEAT)
        assert bench.state is NodeState.PREOP
        assert [e.fault for e in bench.emergencies()] == [FaultCode.DUPLICATE_NODE]
        bench.command(Command.HOME)
        assert bench.state is NodeState.PREOP
        bench.command(Command.RESET)
        bench.command(Command.HOME)
        assert bench.node.state.name == "HOMING"


def test_a_joint_whose_torque_is_off_stays_so(wire: Wire) -> None:
    bench = JointBench(wire).enable()
    bench.node.trip(FaultCode.HARD_LIMIT, bench.controller._master, 1.0)
    other_says(bench, Heartbeat, BEAT)
    assert bench.state is NodeState.FAULT


def test_a_frame_that_is_not_whole_gives_nothing_away(wire: Wire) -> None:
    bench = JointBench(wire).enable()
    frame = bench.sender(Heartbeat, bench.number).frame(*BEAT)
    bench.give(Frame(frame.id, frame.data[:-1] + bytes([frame.data[-1] ^ 1])))
    assert bench.state is NodeState.OPERATIONAL


def test_no_bus_brings_these_nodes_their_own_frames(wire: Wire) -> None:
    assert not hears_itself(JointNode(3, wire, 1))
    assert not hears_itself(GripperNode(wire, 1))

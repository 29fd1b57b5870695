"""A master is killed, at any moment, and another one takes its place: the nodes live on."""

from collections import deque

import pytest
from support.bench import FieldNodeBench
from support.fleet import Fleet
from support.joint_bench import JointBench

from rfms_can.arm import PUMA_260
from rfms_can.joint_nodes import gripper
from rfms_can.joint_nodes.gripper import GripperNode
from rfms_can.master.node import MasterNode
from rfms_can.master.phases import Phase
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.node.protocol import Node
from rfms_can.wire.configuration import Clock
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import MASTER
from rfms_can.wire.records import Heartbeat, Nmt
from rfms_can.wire.vocabulary import Command, NodeState, Parameter

SOME_STEPS = 37
"""Into a cycle: frames are under way."""


def take_over(fleet: Fleet, after_ns: int) -> MasterNode:
    """Kill the master; another one is there so much later, and hears nothing of the time before."""
    pump, old = fleet.pump, fleet.master
    pump.nodes.remove(old)
    pump._queue = deque((node, frame) for node, frame in pump._queue if node is not old)
    at_ns = pump.now_ns + after_ns
    while pump._queue or _next_ns(fleet) < at_ns:
        pump.step()
    pump.now_ns = max(pump.now_ns, at_ns)
    new = MasterNode(old.arm, fleet.wire, 0x77, old.settings)
    new.timer.retry(pump.now_ns)
    pump.nodes.append(new)
    pump._accepts.pop(new.name, None)
    fleet.master = new
    return new


def _next_ns(fleet: Fleet) -> float:
    deadlines = [node.next_deadline_ns() for node in fleet.pump.nodes]
    return min((due for due in deadlines if due is not None), default=float("inf"))


def bring_into(fleet: Fleet, phase: Phase) -> None:
    """Run into a phase, and some frames on."""
    if phase in (Phase.RUN, Phase.HALT):
        fleet.enable()
        if phase is Phase.HALT:
            fleet.master.lose("a fault")
            fleet.run(20)
    else:
        fleet.reach(phase)
    for _ in range(SOME_STEPS):
        fleet.pump.step()


@pytest.mark.parametrize("clock", [Clock.VIRTUAL, Clock.LOCKSTEP])
@pytest.mark.parametrize("phase", [Phase.HOME, Phase.READY, Phase.RUN, Phase.HALT])
@pytest.mark.parametrize("after_ms", [0, 3, 14, 300, 2500, 7000])
def test_the_next_master_brings_the_bus_up(
    wire: Wire, clock: Clock, phase: Phase, after_ms: int
) -> None:
    """Whatever the nodes still do for the one before: it resets them until all have heard it."""
    fleet = Fleet(wire, clock, patience=30.0)
    bring_into(fleet, phase)
    new = take_over(fleet, after_ms * 1_000_000)
    fleet.pump.run_until(lambda: new.fault is not None or new.phase is Phase.READY)
    assert new.fault is None


def test_a_reset_that_was_lost_is_said_again(wire: Wire) -> None:
    fleet = Fleet(wire).reach(Phase.READY)
    new = take_over(fleet, 2_000_000_000)
    lost: list[Frame] = []

    def lose_the_first(frame: Frame, node: Node) -> bool:
        if frame.id == fleet.id(Nmt) and node is fleet.joints[3] and not lost:
            lost.append(frame)
            return True
        return False

    fleet.pump.lose(lose_the_first)
    fleet.pump.run_until(lambda: new.fault is not None or new.phase is Phase.READY)
    assert lost
    assert new.fault is None


def test_a_node_without_configuration_hears_every_master(wire: Wire) -> None:
    """It has heard SYNC of an arm that was driven, and none since: nothing is to be protected."""
    bench = JointBench(wire)
    bench.sync(NodeState.QUICKSTOP)
    for boot_id in range(10, 16):
        values = (NodeState.PREOP, 0, 0, boot_id, wire.dbc_hash, 0, 0, 0)
        bench.give(wire.sender(Heartbeat, MASTER).frame(*values))
        nmt = wire.sender(Nmt)
        bench.give(nmt.frame(Command.RESET, 0, 0))
        answers = bench.give(nmt.frame(Command.ANNOUNCE, 0, 0))
        assert [heard.name for heard in answers] == ["HEARTBEAT_2"]


def test_nodes_that_do_not_take_the_reset_are_named(fleet_of_two_masters: Fleet) -> None:
    fleet = fleet_of_two_masters
    assert fleet.halted() == (
        "RESET is not taken by joint 4 (OPERATIONAL); does another master run on this bus?"
    )


@pytest.fixture
def fleet_of_two_masters(wire: Wire) -> Fleet:
    """Joint 4 drives for another master, and does not listen."""
    fleet = Fleet(wire)
    fleet.pump.run_until(lambda: fleet.joints[3].state is NodeState.PREOP)
    fleet.joints[3].state = NodeState.OPERATIONAL
    fleet.pump.lose(lambda frame, node: frame.id == fleet.id(Nmt) and node is fleet.joints[3])
    joint = fleet.joints[3]
    fleet.pump.post(joint.on_frame(fleet.wire.sender(Nmt).frame(0, 0, 0), 0), joint)
    return fleet


def test_the_gripper_does_without_what_its_master_does_not_know(
    wire: Wire, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gripper, "DEFAULTS", {Parameter.ARM_ID: 260.0})
    parameters = all_parameters(PUMA_260, "corke", 0.004)[7]
    del parameters[Parameter.ARM_ID]
    bench: FieldNodeBench[GripperNode] = FieldNodeBench(GripperNode(wire, 7), wire, parameters)
    bench.configure()

"""The way back from a fault: rest, RESET, a roll call, homing only where a reference is lost."""

from typing import Final

import pytest
from support.fleet import Fleet

from rfms_can.errors import FaultError, ProgramError
from rfms_can.joint_nodes.gripper import GripperNode
from rfms_can.joint_nodes.joint import JointNode
from rfms_can.master.cycle import SETTLING_CYCLES
from rfms_can.master.phases import NO_RESET, Phase, PhaseError, PhaseMachine
from rfms_can.messages import ComplyRequest, GripperRequest, Outcome, ResetRequest
from rfms_can.node.protocol import Node
from rfms_can.plant.node import PlantNode
from rfms_can.wire.configuration import Clock
from rfms_can.wire.contract import ESTOP_VALUES, Wire
from rfms_can.wire.records import Estop
from rfms_can.wire.vocabulary import Command, GripperCommand, NodeState

STEP: Final = (0.0, -0.3, 0.2, 0.0, 0.1, 0.0)
"""A displacement, rad."""
CLOCKS = pytest.mark.parametrize("clock", [Clock.VIRTUAL, Clock.LOCKSTEP])


def in_motion(wire: Wire, clock: Clock = Clock.VIRTUAL) -> Fleet:
    """A fleet in the middle of its first move."""
    fleet = Fleet(wire, clock).enable()
    assert fleet.move(STEP, seconds=0.8) == 1
    fleet.run(100)
    return fleet


def reset(fleet: Fleet) -> None:
    """Reset, and run on until the arm is enabled again or halted."""
    master = fleet.master
    master.handle(ResetRequest())
    fleet.pump.run_until(lambda: master.phase in (Phase.RUN, Phase.HALT))


def replace(fleet: Fleet, old: Node, new: Node) -> None:
    """Another node in the place of one."""
    fleet.pump.nodes[fleet.pump.nodes.index(old)] = new


def restart_joint(fleet: Fleet, joint: int) -> JointNode:
    """A joint's process has ended, and another one is there."""
    new = JointNode(joint, fleet.wire, 0x100 + joint)
    replace(fleet, fleet.joints[joint - 1], new)
    fleet.joints[joint - 1] = new
    return new


def angles(fleet: Fleet) -> list[float]:
    """Where the joints are in the plant, rad."""
    return list(fleet.plant.physics.model.q)


# --- back to work ------------------------------------------------------------------------------


@CLOCKS
def test_a_reset_leads_from_motion_to_rest_and_back_to_work(wire: Wire, clock: Clock) -> None:
    fleet = in_motion(wire, clock)
    master = fleet.master
    queued = fleet.move((0.0,) * 6, seconds=0.8)
    master.handle(ComplyRequest("fx", [0.0]))
    master.lose("a fault")
    assert master.motion.generator.completed == queued
    since = len(fleet.pump.sent)
    master.handle(ResetRequest())
    assert (master.phase, master.fault) == (Phase.RESET, None)
    fleet.pump.run_until(lambda: master.phase is Phase.ROLL_CALL)
    speeds = [abs(speed) for speed in fleet.plant.physics.model.qd]
    assert max(speeds) < 0.02, "RESET lets go of the joints: they stand still"
    fleet.pump.run_until(lambda: master.phase is Phase.RUN)
    said = [values[0] for values in fleet.said("NMT", since)]
    assert said == [
        *(Command.QUICKSTOP, Command.RESET, Command.ANNOUNCE),
        *(Command.HOME, Command.START),
    ]
    assert fleet.said("CONFIG_3", since) == [], "what the nodes hold they keep"
    outcomes = master.motion.generator.outcomes.of(1, queued)
    assert [outcome.how for outcome in outcomes] == [Outcome.FAULTED] * 2
    assert master.motion.comply == "", "rigid until the program asks again"
    assert "goal 1" in master.motion.world.names().transforms
    number = fleet.move(STEP, seconds=0.8)
    assert number == queued + 1
    fleet.pump.run_until(lambda: master.motion.is_over(number))
    assert master.motion.generator.outcomes.of(number, number)[0].how is Outcome.MADE
    assert list(master.machine.reset_faults) == ["a fault"]
    assert all(joint.faults.total() == 0 for joint in fleet.joints)


def test_with_its_references_the_arm_does_not_move(wire: Wire) -> None:
    fleet = in_motion(wire)
    fleet.master.lose("a fault")
    fleet.run(SETTLING_CYCLES)
    before = angles(fleet)
    cycles = fleet.master.closed
    reset(fleet)
    assert fleet.master.fault is None
    fleet.run(50)
    assert angles(fleet) == pytest.approx(before, abs=3e-3)
    assert fleet.master.closed - cycles < 100


def test_nothing_is_enabled_by_itself(wire: Wire) -> None:
    fleet = in_motion(wire)
    fleet.master.lose("a fault")
    fleet.run(2000)
    assert fleet.master.phase is Phase.HALT
    assert all(joint.state is NodeState.QUICKSTOP for joint in fleet.joints)


@CLOCKS
def test_a_second_fault_on_the_way_halts_again(wire: Wire, clock: Clock) -> None:
    for phase in (Phase.RESET, Phase.ROLL_CALL, Phase.HOME, Phase.READY):
        fleet = in_motion(wire, clock)
        fleet.master.lose("first")
        fleet.master.handle(ResetRequest())
        fleet.reach(phase)
        fleet.master.lose("second")
        assert (fleet.master.phase, fleet.master.fault) == (Phase.HALT, "second")
        reset(fleet)
        assert fleet.master.phase is Phase.RUN
        assert list(fleet.master.machine.reset_faults) == ["first", "second"]


@pytest.mark.parametrize("phase", [Phase.RESET, Phase.ROLL_CALL, Phase.HOME])
def test_a_run_may_end_on_the_way(wire: Wire, phase: Phase) -> None:
    fleet = in_motion(wire)
    fleet.master.lose("a fault")
    fleet.master.handle(ResetRequest())
    fleet.reach(phase)
    fleet.master.stop()
    fleet.pump.run_until(lambda: fleet.master.timer.stopped)
    assert fleet.master.phase is Phase.END


# --- who was away ------------------------------------------------------------------------------


@pytest.mark.parametrize("joint", [1, 4])
def test_a_joint_that_started_again_is_configured_and_homed(wire: Wire, joint: int) -> None:
    fleet = in_motion(wire)
    new = restart_joint(fleet, joint)
    assert fleet.halted().startswith(f"joint {joint} restarted while the bus was up")
    fleet.run(SETTLING_CYCLES)
    before, since = angles(fleet), len(fleet.pump.sent)
    reset(fleet)
    assert fleet.master.fault is None
    configured = [n for n in range(1, 8) if fleet.said(f"CONFIG_{n}", since)]
    assert configured == [joint]
    fleet.run(30)
    moved = [n for n in range(1, 7) if abs(angles(fleet)[n - 1] - before[n - 1]) > 5e-3]
    assert moved in ([], [joint]), "the others know where they are"
    assert new.theta == pytest.approx(angles(fleet)[joint - 1], abs=1e-3)
    assert fleet.master.arm_state.q[joint - 1] == pytest.approx(new.theta, abs=1e-6)


def test_after_a_restart_of_the_plant_every_joint_homes(wire: Wire) -> None:
    """Its encoders count from elsewhere: what the nodes hold as their reference is of no use."""
    fleet = in_motion(wire)
    model = fleet.plant.physics.model
    fleet.pump.nodes.remove(fleet.plant)
    assert fleet.halted().startswith("plant: no MEASURE_1")
    other = Fleet(wire).plant
    plant = PlantNode(other.physics, wire, 0x99, fleet.plant._watch_ns)
    fleet.plant = plant
    fleet.pump.nodes.append(plant)
    fleet.pump._accepts.clear()
    since = len(fleet.pump.sent)
    reset(fleet)
    assert fleet.master.fault is None
    assert all(fleet.said(f"CONFIG_{n}", since) for n in range(1, 8))
    fleet.run(30)
    assert fleet.master.arm_state.q == pytest.approx(angles(fleet), abs=1e-3)
    assert plant.physics.model is not model


def test_a_node_that_is_missing_is_named_and_may_come_back(wire: Wire) -> None:
    fleet = in_motion(wire)
    fleet.pump.nodes.remove(fleet.joints[2])
    fleet.halted()
    for _ in range(2):
        reset(fleet)
        assert fleet.master.fault == (
            "not on the bus: joint 3; start them, or look at their own error messages"
        )
        assert fleet.master.next_deadline_ns() is None
    fleet.joints[2] = JointNode(3, wire, 0x103)
    fleet.pump.nodes.append(fleet.joints[2])
    fleet.pump._accepts.clear()
    reset(fleet)
    assert (fleet.master.phase, fleet.master.fault) == (Phase.RUN, None)
    assert len(fleet.master.machine.reset_faults) == 3


# --- the gripper -------------------------------------------------------------------------------


def test_the_gripper_does_not_let_go_of_a_workpiece(wire: Wire) -> None:
    fleet = Fleet(wire).enable()
    jaw = fleet.plant.physics.jaw
    jaw.part_width = 0.02
    fleet.master.handle(GripperRequest(False, 0.5))
    fleet.run(300)
    assert jaw.opening == pytest.approx(0.02, abs=1e-4)
    fleet.master.lose("a fault")
    openings: list[float] = []
    fleet.plant._observe = lambda _: openings.append(jaw.opening)
    reset(fleet)
    fleet.run(50)
    assert max(openings) < 0.0201
    assert fleet.master.arm_state.jaw_opening(fleet.master.arm.gripper) == pytest.approx(
        0.02, abs=1e-3
    )


def test_a_gripper_that_had_to_home_stays_open(wire: Wire) -> None:
    fleet = Fleet(wire).enable()
    fleet.master.handle(GripperRequest(False, 0.5))
    fleet.run(300)
    new = GripperNode(wire, 0x107)
    replace(fleet, fleet.gripper, new)
    fleet.halted()
    reset(fleet)
    fleet.run(100)
    stroke = fleet.master.arm.gripper.stroke
    assert fleet.plant.physics.jaw.opening == pytest.approx(stroke, abs=1e-3)
    assert fleet.master.requests.gripper == (GripperCommand.HOLD, 0.0)
    assert fleet.master.arm_state.jaw_opening(fleet.master.arm.gripper) == pytest.approx(
        stroke, abs=1e-3
    )


# --- what is refused ---------------------------------------------------------------------------


@pytest.mark.parametrize("phase", [phase for phase in Phase if phase is not Phase.HALT])
def test_without_a_fault_there_is_nothing_to_reset(wire: Wire, phase: Phase) -> None:
    fleet = Fleet(wire)
    if phase is Phase.RUN:
        fleet.enable()
    elif phase is Phase.RESET:
        fleet.enable().master.lose("a fault")
        fleet.master.handle(ResetRequest())
    elif phase is Phase.END:
        fleet.enable().master.stop()
        fleet.reach(phase)
    else:
        fleet.reach(phase)
    sent = len(fleet.pump.sent)
    with pytest.raises(ProgramError, match=f"reset in phase {phase.name}: {NO_RESET[phase]}"):
        fleet.master.handle(ResetRequest())
    assert (fleet.master.phase, len(fleet.pump.sent)) == (phase, sent)


@pytest.mark.parametrize("by", ["link", "bus"])
def test_an_emergency_stop_is_in_force_until_a_person_lifts_it(wire: Wire, by: str) -> None:
    fleet = in_motion(wire)
    master = fleet.master
    if by == "link":
        master.emergency_stop("emergency stop by 'door'")
    else:
        fleet.pump.post([wire.sender(Estop, None).frame(*ESTOP_VALUES)])
    fleet.run(50)
    assert all(joint.state is NodeState.FAULT for joint in fleet.joints)
    for _ in range(3):
        with pytest.raises(FaultError, match=r"emergency stop .*rfms reset --lift-emergency-stop"):
            master.handle(ResetRequest())
        assert (master.phase, bool(master.emergency)) == (Phase.HALT, True)
    assert master.lift_emergency_stop()
    assert not master.lift_emergency_stop(), "none is in force any more"
    assert master.phase is Phase.HALT, "lifted is not enabled"
    reset(fleet)
    assert (master.phase, master.fault) == (Phase.RUN, None)
    number = fleet.move(STEP, seconds=0.8)
    fleet.pump.run_until(lambda: master.motion.is_over(number))


def test_an_emergency_stop_after_a_fault_is_in_force_too(wire: Wire) -> None:
    fleet = in_motion(wire)
    fleet.master.lose("a fault")
    fleet.run(20)
    fleet.master.emergency_stop("emergency stop by 'door'")
    fleet.run(5)
    assert fleet.master.fault == "a fault", "the first stays"
    with pytest.raises(FaultError, match="emergency stop by 'door'"):
        fleet.master.handle(ResetRequest())


def test_the_machine_holds_its_own_code_to_this() -> None:
    machine = PhaseMachine()
    with pytest.raises(PhaseError):
        machine.reset()
    machine.latch("a fault", emergency=True)
    with pytest.raises(PhaseError, match="emergency stop 'a fault'"):
        machine.reset()

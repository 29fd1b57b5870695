"""Whom the master waits for, and what ends its run."""

from typing import NamedTuple

import pytest
from support.fleet import Fleet

from rfms_can.master.answers import SILENCE_BOUND, Answers, bit
from rfms_can.master.phases import Phase
from rfms_can.wire.configuration import Clock
from rfms_can.wire.contract import ESTOP_VALUES, Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import GRIPPER, JOINTS, NODE_NAMES, PLANT
from rfms_can.wire.records import Dac, Emcy, Estop, JointError, Measure, Rows, Setpoint
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState


@pytest.fixture
def fleet(wire: Wire) -> Fleet:
    return Fleet(wire).enable()


# --- whom it waits for ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("record", "node", "reason"),
    [
        (JointError, 3, "joint 3: no ERROR_3 for 3 cycles"),
        (Dac, 5, "joint 5: no DAC_5 for 3 cycles"),
        (Dac, GRIPPER, "gripper: no DAC_7 for 3 cycles"),
        (Measure, 2, "plant: no MEASURE_2 for 3 cycles"),
        (Rows, 1, "master: no ROWS_1 for 3 cycles"),
    ],
)
def test_a_node_silent_for_three_cycles_halts_the_run_by_name(
    fleet: Fleet, record: type[NamedTuple], node: int, reason: str
) -> None:
    lost = fleet.id(record, node)
    fleet.pump.lose(lambda frame, to: frame.id == lost and to is fleet.master)
    closed = fleet.master.closed
    assert fleet.halted() == reason
    assert fleet.master.closed - closed == SILENCE_BOUND
    assert fleet.master.statistics.incomplete == SILENCE_BOUND
    (missing,) = fleet.master.statistics.missing
    assert reason.split(": no ")[1].split(maxsplit=1)[0] in missing.split(", ")


def test_one_or_two_lost_answers_are_counted_and_forgiven(fleet: Fleet) -> None:
    lost = fleet.id(Dac, 4)
    for burst in (1, 2, 2, 1):
        fleet.pump.lose(lambda frame, to: frame.id == lost and to is fleet.master)
        fleet.run(burst)
        fleet.pump.heal()
        fleet.run(2)
    assert fleet.master.fault is None
    assert fleet.master.statistics.missing == {"DAC_4": 6}
    assert fleet.master.lost == 6


def test_answers_name_what_is_missing() -> None:
    answers = Answers()
    answers.begin(Phase.RUN, 1)
    answers.missing &= bit("MEASURE", 2) | bit("DAC", 7) | bit("ERROR", 6)
    assert answers.describe() == "MEASURE_2, ERROR_6, DAC_7"
    answers.begin(Phase.READY, 12)
    for joint in JOINTS:
        answers.missing &= ~(bit("MEASURE", joint) | bit("ROWS", joint))
    assert answers.describe() == "MEASURE_7, " + ", ".join(f"HEARTBEAT_{n}" for n in range(1, 10))


def test_silence_is_counted_in_a_row() -> None:
    answers = Answers()
    for cycle in (1, 2, 4, 5, 7, 8):
        answers.missing = bit("DAC", 1)
        assert answers.unanswered(cycle) is None
    lost = answers.unanswered(9)
    assert lost == (1, "DAC_1", 3)
    assert lost.words == "joint 1: no DAC_1 for 3 cycles"


@pytest.mark.parametrize("clock", [Clock.VIRTUAL, Clock.LOCKSTEP])
def test_answers_of_another_cycle_do_not_count(wire: Wire, clock: Clock) -> None:
    fleet = Fleet(wire, clock, barrier=0.02).enable()
    late = fleet.id(Dac, 2)
    delay_ns = fleet.master.settings.cycle_limit_ns * 3 // 2
    fleet.pump.delay(lambda frame, to: frame.id == late and to is fleet.master, delay_ns)
    assert fleet.halted() == "joint 2: no DAC_2 for 3 cycles"
    assert fleet.master.ignored["stale DAC"] >= 1


# --- faults -----------------------------------------------------------------------------------


def emergency(
    fleet: Fleet,
    node: int,
    fault: int,
    value: float,
    *,
    bound: float = 0.0,
    culprit: int = 0,
    message: int = 0,
) -> Frame:
    """An EMCY of a node."""
    values = (fault, culprit or node, message, value, bound, 0, 1 << fault | 1)
    return fleet.wire.sender(Emcy, node).frame(*values)


@pytest.mark.parametrize(
    ("culprit", "frame", "words"),
    [
        (9, "MEASURE_5", "joint 5: ROWS_MISSING (3, bound 3): MEASURE_5 of plant"),
        (5, "", "joint 5: ROWS_MISSING (3, bound 3)"),
        (0, "MEASURE_5", "joint 5: ROWS_MISSING (3, bound 3): MEASURE_5"),
        (8, "", "joint 5: ROWS_MISSING (3, bound 3): master"),
    ],
)
def test_an_emergency_names_the_culprit(fleet: Fleet, culprit: int, frame: str, words: str) -> None:
    message = fleet.wire.codecs[frame].id if frame else 0
    fault = FaultCode.ROWS_MISSING
    fleet.pump.post([emergency(fleet, 5, fault, 3.0, bound=3.0, culprit=culprit, message=message)])
    assert fleet.halted() == words


@pytest.mark.parametrize(
    ("fault", "missed", "sender", "evidence"),
    [
        (FaultCode.SYNC_MISSING, "SYNC", 8, "other nodes have answered it"),
        (FaultCode.SETPOINT_MISSING, "SETPOINT_1", 8, "other joints have answered it"),
        (FaultCode.MEASURE_MISSING, "MEASURE_5", 9, "the master has heard it"),
        (FaultCode.ERROR_MISSING, "ERROR_2", 2, "the master has heard it"),
    ],
)
@pytest.mark.parametrize("deaf", [True, False])
def test_a_node_that_misses_what_others_have_heard_is_deaf(
    fleet: Fleet, fault: FaultCode, missed: str, sender: int, evidence: str, deaf: bool
) -> None:
    """Where nothing was to be heard, by the master either, its sender is to blame."""
    fleet.run(3)
    if not deaf:  # neither in this cycle nor in the one before
        fleet.pump.lose(lambda frame, to: to is fleet.master)
        fleet.run(2)
        fleet.pump.heal()
        fleet.master.inputs.begin(Phase.RUN, fleet.master.cycle.number + 1)
        fleet.master.inputs.begin(Phase.RUN, fleet.master.cycle.number + 1)
    message = fleet.wire.codecs[missed].id
    (frame,) = [emergency(fleet, 5, fault, 3.0, bound=3.0, culprit=sender, message=message)]
    fleet.master.on_frame(frame, fleet.pump.now_ns)
    culprit, words = fleet.master.culprit, fleet.master.fault or ""
    assert culprit is not None
    assert (culprit.frame, culprit.value, culprit.bound) == (missed, 3.0, 3.0)
    blamed = "joint 5" if deaf else NODE_NAMES[sender]
    assert culprit.sender == blamed
    assert (f"but {evidence}: joint 5 does not hear" in words) is deaf


@pytest.mark.parametrize("node", [5, 9])
def test_who_hears_no_sync_while_a_joint_answers_is_deaf(fleet: Fleet, node: int) -> None:
    fleet.run(3)
    deaf = fleet.plant if node == PLANT else fleet.joints[node - 1]
    fleet.pump.lose(lambda _, to: to is deaf)
    fleet.halted()
    culprit = fleet.master.culprit
    assert culprit is not None and culprit.sender == NODE_NAMES[node]


@pytest.mark.parametrize("fault", [FaultCode.ENCODER_GLITCH, FaultCode.HOMING_FAILED])
def test_what_a_sample_says_is_of_the_joint_and_not_of_its_sender(
    fleet: Fleet, fault: FaultCode
) -> None:
    message = fleet.wire.codecs["MEASURE_5"].id
    fleet.pump.post([emergency(fleet, 5, fault, 0.3, bound=0.25, culprit=9, message=message)])
    assert (fleet.halted() or "").endswith("MEASURE_5 of plant")
    culprit = fleet.master.culprit
    assert culprit is not None and (culprit.sender, culprit.frame) == ("joint 5", "MEASURE_5")


@pytest.mark.parametrize(("lost", "sender"), [(JOINTS, "master"), ((2, 3, 4, 5, 6), "joint 2")])
def test_what_all_joints_lack_at_once_is_the_set_point(
    fleet: Fleet, lost: tuple[int, ...], sender: str
) -> None:
    """One that answers shows that it has gone out."""
    deaf = [fleet.joints[joint - 1] for joint in lost]
    setpoint = fleet.id(Setpoint, 1)
    fleet.pump.lose(lambda frame, to: frame.id == setpoint and to in deaf)
    assert fleet.halted().startswith(f"{sender}: ")
    culprit = fleet.master.culprit
    assert culprit is not None and culprit.sender == sender
    assert culprit.cycle is not None


def test_a_fault_that_only_a_later_version_knows_is_told_by_its_number(fleet: Fleet) -> None:
    fleet.pump.post([emergency(fleet, 5, 30, 1.0)])
    assert fleet.halted() == "joint 5: FaultCode 30 (1)"


def test_an_emergency_of_one_node_stops_all_and_is_latched(fleet: Fleet) -> None:
    fleet.pump.post([emergency(fleet, 5, FaultCode.HARD_LIMIT, 12.5, bound=3.0)])
    assert fleet.halted() == "joint 5: HARD_LIMIT (12.5, bound 3)"
    assert fleet.said("NMT")[-1].command == Command.QUICKSTOP
    fleet.run(2)
    assert {node.state for node in fleet.joints} == {NodeState.QUICKSTOP}
    assert fleet.said("SYNC")[-1].state == NodeState.QUICKSTOP
    fleet.pump.post([emergency(fleet, 2, FaultCode.SOFT_LIMIT, 1.0)])
    fleet.master.start()
    fleet.run(50)
    assert (
        fleet.master.fault == "joint 5: HARD_LIMIT (12.5, bound 3)"
    )  # the first one is the reason
    assert fleet.master.phase is Phase.HALT
    assert {node.state for node in fleet.joints} == {NodeState.QUICKSTOP}


def test_the_estop_frame_of_anybody_halts_the_run(fleet: Fleet) -> None:
    fleet.pump.post([fleet.wire.sender(Estop).frame(*ESTOP_VALUES)])
    assert fleet.halted() == "emergency stop on the bus"
    fleet.run(3)
    assert {node.state for node in fleet.joints} == {NodeState.FAULT}
    assert all(fleet.master.arm_state.braked)


def test_a_node_that_says_it_has_stopped_halts_the_run_without_its_emcy(fleet: Fleet) -> None:
    fleet.pump.lose(lambda frame, _: frame.id == fleet.id(Emcy, 2))
    beat, held = fleet.joints[1]._heartbeat, fleet.joints[1].config_hash  # it counts on
    fleet.pump.post([beat.frame(NodeState.QUICKSTOP, 0, 1, 2, fleet.wire.dbc_hash, held, 0, 0)])
    assert fleet.halted() == "joint 2 is in QUICKSTOP"


def test_stop_disables_brakes_and_ends(fleet: Fleet) -> None:
    fleet.master.stop()
    fleet.pump.run_until(lambda: fleet.master.ended)
    assert fleet.said("NMT")[-1].command == Command.STOP
    assert all(fleet.master.arm_state.braked)
    assert {node.state for node in fleet.joints} == {NodeState.READY}
    assert fleet.master.next_deadline_ns() is None


def test_stop_after_a_fault_resets_the_nodes_to_preop(fleet: Fleet) -> None:
    fleet.pump.post([emergency(fleet, 5, FaultCode.HARD_LIMIT, 12.5, bound=3.0)])
    fleet.halted()
    fleet.run(30)
    fleet.master.stop()
    fleet.pump.run_until(lambda: fleet.master.ended)
    assert {node.state for node in fleet.joints} == {NodeState.PREOP}
    assert fleet.master.fault is not None

"""A control cycle of the master: what it sends, whom it waits for, what ends the run."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pytest
from nodes_rig import PERIOD_NS, Fleet

from rfms_can.arm import PUMA_260
from rfms_can.dynamics import ArmDynamics
from rfms_can.errors import MoveError, ProgramError
from rfms_can.frame import Frame
from rfms_can.kinematics import direct
from rfms_can.master.answers import SILENCE_BOUND, Answers, bit
from rfms_can.master.math_processor import MathProcessor
from rfms_can.master.phases import Phase
from rfms_can.master.settings import Clock
from rfms_can.messages import (
    GripperRequest,
    ModeMessage,
    MoveRequest,
    PositionMessage,
    StopRequest,
    TransformMessage,
)
from rfms_can.protection import Refusal
from rfms_can.transform import Transform
from rfms_can.wire import ESTOP_VALUES, GRIPPER, JOINTS, MESSAGES, Wire
from rfms_can.wire.records import (
    Dac,
    Emcy,
    Estop,
    Heartbeat,
    JointError,
    Measure,
    Nmt,
    Rows,
    Setpoint,
)
from rfms_can.wire.vocabulary import Command, FaultCode, GripperCommand, Law, NodeState


@pytest.fixture
def fleet(wire: Wire) -> Fleet:
    return Fleet(wire).enable()


def ask_to_move(fleet: Fleet, way: Sequence[float], seconds: float = 0.6) -> int:
    """A joint motion from park by some angles, rad."""
    goal = [q + step for q, step in zip(PUMA_260.park, way, strict=True)]
    master = fleet.master
    master.handle(TransformMessage("goal", direct(PUMA_260, goal)))
    master.handle(PositionMessage("there", ["t6"], ["goal"]))
    master.handle(ModeMessage("swift", "joint", seconds, 0.1))
    return master.handle(MoveRequest("there", "swift"))


def halted(fleet: Fleet, most: int = 100_000) -> str:
    """Run until the master gives up; its reason."""
    fleet.pump.run_until(lambda: fleet.master.fault is not None, most)
    assert fleet.master.phase is Phase.HALT
    assert fleet.master.fault is not None
    return fleet.master.fault


# --- what goes out -----------------------------------------------------------------------------


def test_a_cycle_is_sync_setpoint_measures_rows_errors_dacs(fleet: Fleet) -> None:
    fleet.run(2)
    first = len(fleet.pump.sent)
    fleet.run(1)
    names = [fleet.reader.read(frame).name for frame in fleet.pump.sent[first:]]
    expected = {"SYNC", "SETPOINT_1", "MEASURE_7", "DAC_7"}
    expected |= {f"{kind}_{j}" for kind in ("MEASURE", "ROWS", "ERROR", "DAC") for j in JOINTS}
    assert sorted(names) == sorted(expected)
    place = {name: names.index(name) for name in names}
    assert place["SYNC"] < place["SETPOINT_1"] < place["MEASURE_1"] < place["ROWS_1"]
    for joint in JOINTS:
        assert place[f"MEASURE_{joint}"] < place[f"ERROR_{joint}"] < place[f"DAC_{joint}"]


def test_counters_and_cycles_begin_anew_at_start(wire: Wire) -> None:
    fleet = Fleet(wire).reach(Phase.READY)
    fleet.run(7)
    fleet.master.start()
    fleet.reach(Phase.RUN)
    first = len(fleet.pump.sent)
    fleet.run(1)
    frames = fleet.pump.sent[first:]
    begun: set[int] = set()
    for frame in frames:
        if frame.id not in begun:
            assert frame.data[2] == 0, fleet.reader.read(frame).name
            begun.add(frame.id)
    assert fleet.said("SYNC", first)[0].cycle == 0
    assert fleet.said("MEASURE_3", first)[0].cycle == 0
    fleet.run(300)
    for node in (*fleet.joints, fleet.gripper, fleet.plant, fleet.master):
        assert (node.discarded, node.lost, node.ignored.total()) == (0, 0, 0)


def test_rows_are_the_models_at_the_measured_angles(fleet: Fleet) -> None:
    ask_to_move(fleet, (0.2, 0.1, -0.2, 0.1, 0.1, 0.2))
    fleet.run(80)
    dynamics, identity = ArmDynamics(PUMA_260), np.eye(6)
    for _ in range(5):
        first = len(fleet.pump.sent)
        fleet.run(1)
        q = []
        for joint in JOINTS:
            (measure,) = fleet.said(f"MEASURE_{joint}", first)
            zero = fleet.master.arm_state.zero_counts[joint - 1]
            q.append((measure.counts - zero) / PUMA_260.drives[joint - 1].counts_per_radian)
        dynamics.update(q)
        for joint in JOINTS:
            (rows,) = fleet.said(f"ROWS_{joint}", first)
            assert rows[:6] == tuple(identity[joint - 1])
            assert rows[6:12] == pytest.approx(dynamics.M[joint - 1], rel=1e-5, abs=1e-7)
            assert rows.gravity == pytest.approx(dynamics.g[joint - 1], rel=1e-5, abs=1e-6)
            assert rows.law == Law.PID


def test_weighted_rows_are_the_inertia_times_the_compliance() -> None:
    math_processor = MathProcessor(PUMA_260)
    rng = np.random.default_rng(3)
    compliance = rng.uniform(-1.0, 1.0, (6, 6))
    math_processor.compliance = tuple(tuple(row) for row in compliance.tolist())
    math_processor.law = Law.WEIGHTED
    q = rng.uniform(-1.0, 1.0, 6).tolist()
    number, rows = math_processor.rows(q)
    weighted = ArmDynamics(PUMA_260).inertia_matrix(q) @ compliance
    for i, row in enumerate(rows):
        assert row[:6] == pytest.approx(compliance[i])
        assert row[6:12] == pytest.approx(weighted[i])
        assert row[13:] == (number, Law.WEIGHTED)


def test_sync_names_the_set_that_went_out_in_the_cycle_before(fleet: Fleet) -> None:
    for _ in range(300):  # set numbers wrap
        sent = fleet.said("ROWS_6", len(fleet.pump.sent) - 30)[-1].set
        first = len(fleet.pump.sent)
        fleet.run(1)
        assert fleet.said("SYNC", first)[0].row_set == sent
    assert {node.rows.number for node in fleet.joints} == {sent}


def test_sync_never_names_a_set_of_which_a_frame_is_still_waiting(fleet: Fleet) -> None:
    before = fleet.said("SYNC")[-1].row_set
    last_row = fleet.id(Rows, 6)
    fleet.pump.delay(lambda frame, _: frame.id == last_row, PERIOD_NS * 3 // 2)
    first = len(fleet.pump.sent)
    fleet.run(4)
    assert fleet.master.fault == "master: no ROWS_6 for 3 cycles"  # always late is never
    named = {sync.row_set for sync in fleet.said("SYNC", first)[1:]}
    sent = {rows.set for rows in fleet.said("ROWS_1", first)}
    assert len(sent) == 4
    assert len(named) == 1
    assert named <= {before, (before + 1) & 0xFF}
    assert not any(node.faults[FaultCode.ROWS_MISSING] for node in fleet.joints)


def test_gripper_commands_go_out_at_the_next_cycle_and_are_repeated(fleet: Fleet) -> None:
    fleet.run(3)
    fleet.master.handle(GripperRequest(False, 0.333))
    fleet.run(2)
    first = len(fleet.pump.sent)
    command = fleet.said("GRIPPER")[-1]
    assert (command.command, command.force) == (GripperCommand.CLOSE, 33.5)
    fleet.run(24)
    assert len(fleet.said("GRIPPER", first)) == 2


def test_every_setpoint_says_its_cycle_and_move(fleet: Fleet) -> None:
    sequence = ask_to_move(fleet, (0.1, 0.0, 0.0, 0.0, 0.0, 0.0))
    first = len(fleet.pump.sent)
    fleet.run(250)
    setpoints = fleet.said("SETPOINT_1", first)
    cycles = [setpoint.cycle for setpoint in setpoints]
    assert cycles == list(range(cycles[0], cycles[0] + len(cycles)))
    assert setpoints[-1].sequence == sequence
    seconds = fleet.said("SETPOINT_2", first)
    assert len(seconds) == sum(setpoint.poses == 2 for setpoint in setpoints) > 0
    assert fleet.master.motion.is_over(sequence)


# --- whom it waits for -------------------------------------------------------------------------


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
    assert halted(fleet) == reason
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
    assert answers.unanswered(9) == "joint 1: no DAC_1 for 3 cycles"


@pytest.mark.parametrize("clock", [Clock.VIRTUAL, Clock.LOCKSTEP])
def test_answers_of_another_cycle_do_not_count(wire: Wire, clock: Clock) -> None:
    fleet = Fleet(wire, clock, barrier=0.02).enable()
    late = fleet.id(Dac, 2)
    delay_ns = fleet.master.settings.cycle_limit_ns * 3 // 2
    fleet.pump.delay(lambda frame, to: frame.id == late and to is fleet.master, delay_ns)
    assert halted(fleet) == "joint 2: no DAC_2 for 3 cycles"
    assert fleet.master.ignored["stale DAC"] >= 1


# --- faults ------------------------------------------------------------------------------------


def test_an_emergency_of_one_node_stops_all_and_is_latched(fleet: Fleet) -> None:
    fleet.pump.post([fleet.wire.sender(Emcy, 5).frame(FaultCode.OVER_TORQUE, 1, 12.5, 0)])
    assert halted(fleet) == "joint 5: OVER_TORQUE (12.5)"
    assert fleet.said("NMT")[-1].command == Command.QUICKSTOP
    fleet.run(2)
    assert {node.state for node in fleet.joints} == {NodeState.QUICKSTOP}
    assert fleet.said("SYNC")[-1].state == NodeState.QUICKSTOP
    fleet.pump.post([fleet.wire.sender(Emcy, 2).frame(FaultCode.RUNAWAY, 1, 0.0, 0)])
    fleet.master.start()
    fleet.run(50)
    assert fleet.master.fault == "joint 5: OVER_TORQUE (12.5)"  # the first one is the reason
    assert fleet.master.phase is Phase.HALT
    assert {node.state for node in fleet.joints} == {NodeState.QUICKSTOP}


def test_the_estop_frame_of_anybody_halts_the_run(fleet: Fleet) -> None:
    fleet.pump.post([fleet.wire.sender(Estop).frame(*ESTOP_VALUES)])
    assert halted(fleet) == "emergency stop on the bus"
    fleet.run(3)
    assert {node.state for node in fleet.joints} == {NodeState.FAULT}
    assert all(fleet.master.arm_state.braked)


def test_a_node_that_says_it_has_stopped_halts_the_run_without_its_emcy(fleet: Fleet) -> None:
    fleet.pump.lose(lambda frame, _: frame.id == fleet.id(Emcy, 2))
    beat = fleet.wire.sender(Heartbeat, 2)
    fleet.pump.post([beat.frame(NodeState.QUICKSTOP, 1, 2, fleet.wire.dbc_hash, 0, 0)])
    assert halted(fleet) == "joint 2 is in QUICKSTOP"


def test_stop_disables_brakes_and_ends(fleet: Fleet) -> None:
    fleet.master.stop()
    fleet.pump.run_until(lambda: fleet.master.ended)
    assert fleet.said("NMT")[-1].command == Command.STOP
    assert all(fleet.master.arm_state.braked)
    assert {node.state for node in fleet.joints} == {NodeState.READY}
    assert fleet.master.next_deadline_ns() is None


def test_stop_after_a_fault_resets_the_nodes_to_preop(fleet: Fleet) -> None:
    fleet.pump.post([fleet.wire.sender(Emcy, 5).frame(FaultCode.OVER_TORQUE, 1, 12.5, 0)])
    halted(fleet)
    fleet.run(30)
    fleet.master.stop()
    fleet.pump.run_until(lambda: fleet.master.ended)
    assert {node.state for node in fleet.joints} == {NodeState.PREOP}
    assert fleet.master.fault is not None


# --- what is refused before it is sent ---------------------------------------------------------


def test_nothing_can_be_asked_of_an_arm_that_is_not_enabled(wire: Wire) -> None:
    fleet = Fleet(wire).reach(Phase.READY)
    with pytest.raises(ProgramError, match=r"not enabled \(phase READY\)"):
        fleet.master.handle(TransformMessage("a", Transform.identity()))


def test_a_t6_out_of_reach_is_refused_and_never_sent(fleet: Fleet) -> None:
    master = fleet.master
    far = direct(PUMA_260, PUMA_260.park)._replace(px=1.5)
    master.handle(TransformMessage("far", far))
    master.handle(PositionMessage("far away", ["t6"], ["far"]))
    master.handle(ModeMessage("swift", "joint", 1.0, 0.1))
    with pytest.raises(MoveError, match=r"to 'far away' with 'swift': puma260: too_far"):
        master.handle(MoveRequest("far away", "swift"))
    first = len(fleet.pump.sent)
    fleet.run(20)
    assert master.phase is Phase.RUN
    assert {setpoint.p_x for setpoint in fleet.said("SETPOINT_1", first)} == {
        fleet.said("SETPOINT_1")[0].p_x
    }


def test_a_setpoint_the_arm_cannot_take_halts_before_it_is_sent(fleet: Fleet) -> None:
    generator = fleet.master.motion.generator
    good = generator.tick()
    bad = good._replace(T6_1=good.T6_1._replace(px=1.9))
    first = len(fleet.pump.sent)
    generator.tick = lambda: bad  # type: ignore[method-assign]  # as if a rule had been forgotten
    reason = halted(fleet)
    assert reason.startswith("set-point refused before it was sent: puma260: too_far")
    fleet.run(3)
    assert all(abs(setpoint.p_x) < 1.0 for setpoint in fleet.said("SETPOINT_1", first))


def test_a_stop_that_ends_in_a_singular_wrist_halts_by_name(fleet: Fleet) -> None:
    """Programs stop wherever they like; where theta4 and theta6 are one, nothing can be held."""
    motion = fleet.master.motion
    ask_to_move(fleet, (0.2, 0.0, 0.0, 0.0, 0.0, 0.0))
    fleet.run(60)
    fleet.master.handle(StopRequest())
    while not motion.generator.stopped:
        fleet.run(1)
        singular = (*motion.commanded.theta[:4], 0.0005, motion.commanded.theta[5])
    motion.commanded.reset(singular)
    assert halted(fleet).startswith("puma260: wrist singularity: sin(theta5) = 0.0005")


def test_an_arm_with_a_singular_wrist_is_not_enabled(wire: Wire) -> None:
    fleet = Fleet(wire).reach(Phase.READY)
    fleet.master.arm_state.q[4] = 0.0005
    fleet.pump.lose(lambda frame, to: frame.id == fleet.id(Measure, 5) and to is fleet.master)
    fleet.master.start()
    reason = halted(fleet)
    assert reason.startswith("puma260: wrist singularity: sin(theta5) = 0.0005, enabling needs")
    assert Command.START not in {nmt.command for nmt in fleet.said("NMT")}


# --- clocks ------------------------------------------------------------------------------------


def stream(fleet: Fleet, cycles: int) -> dict[int, list[bytes]]:
    """Payloads by identifier, of so many cycles from START on, with a motion in them."""
    fleet.reach(Phase.READY)
    fleet.run(1)
    fleet.master.start()
    fleet.reach(Phase.RUN)
    start = fleet.id(Nmt)
    first = max(i for i, frame in enumerate(fleet.pump.sent) if frame.id == start) + 1
    fleet.run(5)
    ask_to_move(fleet, (0.3, -0.2, 0.2, 0.3, 0.2, -0.3))
    fleet.master.handle(GripperRequest(True, 1.0))
    fleet.run(cycles)
    frames: dict[int, list[bytes]] = {}
    for frame in fleet.pump.sent[first:]:
        frames.setdefault(frame.id, []).append(frame.data)
    return frames


def test_virtual_time_and_lockstep_send_the_same_frames(wire: Wire) -> None:
    virtual = stream(Fleet(wire), 200)
    lockstep = stream(Fleet(wire, Clock.LOCKSTEP), 200)
    assert set(virtual) == set(lockstep)
    for identifier, payloads in virtual.items():
        others = lockstep[identifier]
        common = min(len(payloads), len(others))
        assert common > 0
        assert abs(len(payloads) - len(others)) <= 2  # a cycle may be under way
        assert payloads[:common] == others[:common], hex(identifier)


def test_a_lockstep_cycle_ends_with_the_last_answer_and_no_time(wire: Wire) -> None:
    fleet = Fleet(wire, Clock.LOCKSTEP).enable()
    began = fleet.pump.now_ns
    fleet.run(50)
    assert fleet.pump.now_ns == began


def test_an_expired_barrier_counts_as_a_cycle_and_names_who_is_missing(wire: Wire) -> None:
    fleet = Fleet(wire, Clock.LOCKSTEP, barrier=0.05).enable()
    lost = fleet.id(Dac, 6)
    fleet.pump.lose(lambda frame, to: frame.id == lost and to is fleet.master)
    closed, began = fleet.master.closed, fleet.pump.now_ns
    fleet.run(1)
    assert fleet.master.closed == closed + 1
    assert fleet.pump.now_ns == began + 50_000_000
    assert fleet.master.statistics.missing == {"DAC_6": 1}


# --- lossy bus ---------------------------------------------------------------------------------


def test_frames_that_come_twice_change_nothing(wire: Wire) -> None:
    once, twice = Fleet(wire), Fleet(wire)
    twice.reach(Phase.READY)
    twice.pump.repeat(lambda _frame, _to: True)
    expected, got = stream(once, 100), stream(twice, 100)
    for identifier in set(expected) | set(got):
        if identifier < once.id(Heartbeat, 1):  # these tell how many were discarded
            assert got[identifier] == expected[identifier], hex(identifier)
    assert twice.master.fault is None
    assert set(twice.joints[0].refused) == {Refusal.DUPLICATE}


@pytest.mark.parametrize("record", [Setpoint, Measure, JointError, Dac, Rows])
def test_a_frame_lost_now_and_then_disturbs_nothing_for_long(
    wire: Wire, record: type[NamedTuple]
) -> None:
    """Every 25th frame of a kind is lost to everybody while the arm moves: R1, and no more."""
    fleet = Fleet(wire).enable()
    codecs = [c for c in wire.codecs.values() if c.name.split("_")[0] == _kind(record)]
    identifiers, seen = {codec.id for codec in codecs}, [0]
    doomed: set[bytes] = set()

    def lose(frame: Frame, _: object) -> bool:
        if frame.id not in identifiers:
            return False
        if frame.data in doomed:
            return True
        seen[0] += 1
        if seen[0] % 251 == 0:
            doomed.add(frame.data)
            return True
        return False

    fleet.pump.lose(lose)
    ask_to_move(fleet, (0.5, -0.2, 0.3, 0.5, 0.3, -0.5))
    fleet.run(250)
    assert fleet.master.fault is None
    assert doomed
    assert max(map(abs, fleet.master.errors)) < math.radians(0.3)


def _kind(record: type[NamedTuple]) -> str:
    return MESSAGES[record].split("_")[0]

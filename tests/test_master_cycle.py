"""A control cycle of the master: what it sends, and what it refuses before it is sent."""

import numpy as np
import pytest
from support.bench import PERIOD_NS
from support.fleet import Fleet

from rfms_can.arm import PUMA_260
from rfms_can.arm.load import NOTHING
from rfms_can.compliance import ControlLaw, Selection, compliance_jacobian
from rfms_can.dynamics.model import FULL, make_dynamics
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.errors import MoveError, ProgramError
from rfms_can.kinematics import direct
from rfms_can.master.phases import Phase
from rfms_can.master.rows.compliance import Compliance
from rfms_can.master.rows.math_processor import COMPLIANT_DAMPING, MathProcessor
from rfms_can.messages import (
    GripperRequest,
    ModeMessage,
    MoveRequest,
    PositionMessage,
    TransformMessage,
)
from rfms_can.transform import Transform
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import Rows
from rfms_can.wire.vocabulary import FaultCode, GripperCommand, Law


@pytest.fixture
def fleet(wire: Wire) -> Fleet:
    return Fleet(wire).enable()


# --- what goes out ----------------------------------------------------------------------------


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
    fleet.move((0.2, 0.1, -0.2, 0.1, 0.1, 0.2), 0.6)
    fleet.run(80)
    dynamics = ArmDynamics(PUMA_260)
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
            assert rows[:6] == pytest.approx(dynamics.M[joint - 1], rel=1e-5, abs=1e-7)
            assert rows[6:12] == rows[:6]  # nothing complies
            assert rows.gravity == pytest.approx(dynamics.g[joint - 1], rel=1e-5, abs=1e-6)
            assert rows.law == Law.WEIGHTED


def test_weighted_rows_are_the_inertia_times_the_compliance() -> None:
    q = (0.3, 1.2, -2.9, 0.4, -0.9, 0.2)
    selection, frame = Selection.parse("fx rz"), Transform.translation(0.0, 0.0, 0.1)
    dynamics = ArmDynamics(PUMA_260)
    dynamics.update(q)
    J = compliance_jacobian(dynamics.J, frame)
    C = np.linalg.solve(J, np.where(selection.mask[:, np.newaxis], 0.0, J))
    for law, expected, wire in (
        (ControlLaw.WEIGHTED, dynamics.M @ C, Law.WEIGHTED),
        (ControlLaw.HYBRID, C, Law.PID),
    ):
        math_processor = MathProcessor(PUMA_260, make_dynamics(PUMA_260, FULL), law)
        compliance = Compliance().changed(selection, frame)
        rows = math_processor.rows(7, q, compliance, NOTHING)
        assert (rows.number, rows.compliance) == (7, compliance)
        for i, row in enumerate(rows.values):
            assert row[:6] == pytest.approx(expected[i], abs=1e-9)
            assert row[6:12] == pytest.approx(dynamics.M[i], abs=1e-9)
            assert row[13:] == (7, wire, COMPLIANT_DAMPING, 0b100001, 1)


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
    sequence = fleet.move((0.1, 0.0, 0.0, 0.0, 0.0, 0.0), 0.6)
    first = len(fleet.pump.sent)
    fleet.run(250)
    setpoints = fleet.said("SETPOINT_1", first)
    cycles = [setpoint.cycle for setpoint in setpoints]
    assert cycles == list(range(cycles[0], cycles[0] + len(cycles)))
    assert setpoints[-1].sequence == sequence
    seconds = fleet.said("SETPOINT_2", first)
    assert len(seconds) == sum(setpoint.poses == 2 for setpoint in setpoints) > 0
    assert fleet.master.motion.is_over(sequence)


# --- what is refused before it is sent --------------------------------------------------------


def test_nothing_can_be_asked_of_an_arm_that_is_not_enabled(wire: Wire) -> None:
    fleet = Fleet(wire).reach(Phase.READY)
    with pytest.raises(ProgramError, match=r"not enabled \(phase READY\)"):
        fleet.master.handle(TransformMessage("a", Transform.identity()))


def test_a_t6_out_of_reach_is_refused_and_never_sent(fleet: Fleet) -> None:
    master = fleet.master
    far = direct(PUMA_260, PUMA_260.park)._replace(px=1.5)
    master.handle(TransformMessage("far", far))
    master.handle(PositionMessage("far away", ["t6"], ["far"]))
    master.handle(ModeMessage("swift", "joint", 0.1, 1.0))
    with pytest.raises(
        MoveError, match=r"to 'far away' with 'swift': move 1: the goal: puma260: too_far"
    ):
        master.handle(MoveRequest("far away", "swift"))
    first = len(fleet.pump.sent)
    fleet.run(20)
    assert master.phase is Phase.RUN
    assert {setpoint.p_x for setpoint in fleet.said("SETPOINT_1", first)} == {
        fleet.said("SETPOINT_1")[0].p_x
    }


def test_a_setpoint_the_arm_cannot_take_is_not_sent_and_the_arm_stays(fleet: Fleet) -> None:
    motion = fleet.master.motion
    good = motion.generator.tick()
    bad = good._replace(T6_1=good.T6_1._replace(px=1.9))
    first = len(fleet.pump.sent)
    motion.generator.tick = lambda: bad  # type: ignore[method-assign]  # a rule forgotten
    fleet.run(3)
    assert fleet.master.phase is Phase.RUN
    assert motion.stopped_short is not None
    assert motion.stopped_short.startswith("puma260: too_far")
    assert all(abs(setpoint.p_x) < 1.0 for setpoint in fleet.said("SETPOINT_1", first))


@pytest.mark.parametrize("theta5", [0.0005, 0.0, -1e-9])
def test_an_arm_with_a_straight_wrist_is_held_and_its_joints_are_told_theta4(
    fleet: Fleet, theta5: float
) -> None:
    """T6 alone would not tell them theta4 from theta6."""
    motion, park = fleet.master.motion, PUMA_260.park
    q = (*park[:3], 0.7, theta5, -0.4)
    motion.enable(q)
    for _ in range(3):
        motion.next_setpoint()
        told = motion.commanded.told
        assert told is not None and told.first == pytest.approx(q, abs=1e-6)
    assert motion.stopped_short is None

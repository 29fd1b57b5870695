"""Force control through the whole master: what goes out, what comes back, what is refused."""

import math
import re

import numpy as np
import pytest
from support.fleet import PushedFleet

from rfms_can.errors import MoveError
from rfms_can.kinematics import direct
from rfms_can.master.phases import Phase
from rfms_can.master.report import status_of
from rfms_can.master.trajectory.goal import Moment
from rfms_can.messages import (
    PauseRequest,
    PositionMessage,
    ResumeRequest,
    StopRequest,
    TransformMessage,
)
from rfms_can.transform import Transform
from rfms_can.wire.contract import BIAS_BELONGS, COMPLY_BELONGS, Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import Bias, Comply
from rfms_can.wire.vocabulary import FaultCode, NodeState

TOOL = Transform.translation(0.0, 0.0, 0.1) @ Transform.rpy(0.3, 0.0, 0.2)
ALONG_X = (12.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@pytest.fixture
def fleet(wire: Wire) -> PushedFleet:
    """Without friction: what is pushed moves, and what is not does not."""
    fleet = PushedFleet(wire, friction="none")
    fleet.enable()
    return fleet


def pushed_aside(fleet: PushedFleet) -> int:
    """Comply along x of T6 and be pushed; the move's number."""
    fleet.comply("fx")
    sequence = fleet.move()
    fleet.run(20)
    fleet.push = ALONG_X
    fleet.run(150)
    fleet.push = (0.0,) * 6
    fleet.run(100)
    return sequence


# --- what goes out -----------------------------------------------------------------------------


def test_rows_that_comply_are_named_by_the_next_sync_and_act_in_all_nodes(
    fleet: PushedFleet,
) -> None:
    fleet.run(3)
    since = len(fleet.pump.sent)
    fleet.comply("fx rz")
    fleet.move()
    fleet.run(8)
    rows = fleet.said("ROWS_4", since)
    first = next(row for row in rows if row.selection)
    assert (first.selection, first.specification) == (0b100001, 1)
    assert {(r.selection, r.specification) for r in rows} == {(0, 0), (0b100001, 1)}
    named = [sync.row_set for sync in fleet.said("SYNC", since)]
    assert first.set in named
    assert named.index(first.set) == [row.set for row in rows].index(first.set) + 1
    assert {node.rows.selection for node in fleet.joints} == {0b100001}
    assert status_of(fleet.master).complying == "fx rz"


def test_an_arm_pushed_where_it_complies_goes_and_one_that_is_rigid_does_not(
    fleet: PushedFleet,
) -> None:
    pushed_aside(fleet)
    x, *others = status_of(fleet.master).complied
    assert 0.003 < x < 0.1
    assert np.abs(others[:2]).max() < 0.05 * x
    before = direct(fleet.master.arm, fleet.plant.physics.true_q)
    fleet.push = (0.0, 12.0, 0.0, 0.0, 0.0, 0.0)
    fleet.run(60)
    after = direct(fleet.master.arm, fleet.plant.physics.true_q)
    moved = before.inverse() @ after  # along x it goes as the masses have it
    assert math.hypot(moved.py, moved.pz) < 0.003


def test_comply_goes_out_while_it_is_needed_and_no_longer(fleet: PushedFleet) -> None:
    since = len(fleet.pump.sent)
    fleet.run(5)
    assert not any("COMPLY" in names for names in fleet.names(since))
    pushed_aside(fleet)
    fleet.lock("fx")
    since = len(fleet.pump.sent)
    fleet.settle(fleet.move())
    fleet.run(50)
    went = ["COMPLY" in names for names in fleet.names(since)]
    last = max(k for k, sent in enumerate(went) if sent)
    assert all(went[1:last])
    assert last < len(went) - 20
    comply = fleet.said("COMPLY", since)
    sizes = [max(abs(angle) for angle in frame[:6]) for frame in comply]
    assert sizes[0] > 5e-3
    assert sizes[-1] == 0.0  # the last of them says so


def test_a_rigid_move_is_not_over_before_the_arm_is_back(fleet: PushedFleet) -> None:
    """The commanded trajectory has arrived long before; a gripper must not close then."""
    pushed_aside(fleet)
    fleet.lock("fx")
    sequence = fleet.move()
    while not fleet.master.motion.is_over(sequence):
        fleet.run(1)
    away = np.abs(np.subtract(fleet.plant.physics.true_q, fleet.master.arm.park)).max()
    assert away > 0.05
    assert not status_of(fleet.master).at_rest
    fleet.settle(sequence)
    away = np.abs(np.subtract(fleet.plant.physics.true_q, fleet.master.arm.park)).max()
    assert away < 2e-3
    fleet.run(5)
    assert status_of(fleet.master).at_rest


def test_a_set_point_says_what_belongs_to_it(fleet: PushedFleet) -> None:
    since = len(fleet.pump.sent)
    fleet.run(2)
    fleet.move(comply={"fx": 2.0})  # bias, then what it moves
    fleet.run(20)
    fleet.move()
    fleet.run(300)
    kinds = set()
    cycles: list[list[Frame]] = []
    for frame in fleet.pump.sent[since:]:
        name = fleet.reader.read(frame).name
        if name == "SYNC":
            cycles.append([])
        elif cycles and name in ("SETPOINT_1", "SETPOINT_2", "COMPLY", "BIAS"):
            cycles[-1].append(frame)
    for frames in cycles:
        heard = [fleet.reader.read(frame) for frame in frames]
        names = [h.name for h in heard]
        extras = ("COMPLY" in names) * COMPLY_BELONGS | ("BIAS" in names) * BIAS_BELONGS
        for h in heard:
            if h.name.startswith("SETPOINT"):
                assert h.values.extras == extras
                cycle = h.values.cycle & 0xFF
            else:
                assert h.values.cycle == cycle
        kinds.add(extras)
    assert kinds == {0, 1, 2, 3}


def test_the_commanded_trajectory_is_the_same_to_the_byte_whatever_complies(wire: Wire) -> None:
    """Encoder counts must not find their way into it: differenced twice they are accelerations."""
    way, said = (0.2, 0.1, -0.2, 0.1, 0.1, 0.2), []
    for complies in (False, True):
        fleet = PushedFleet(wire, friction="none")
        fleet.enable()
        since = len(fleet.pump.sent)
        if complies:
            fleet.comply("fx fy rz", 0.0, 2.0, 0.0)
            fleet.push = (4.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        fleet.move(way, seconds=0.6)
        fleet.run(60)
        fleet.push = (0.0,) * 6
        fleet.run(140)
        ids = {wire.codecs[name].id for name in ("SETPOINT_1", "SETPOINT_2")}
        frames = [frame for frame in fleet.pump.sent[since:] if frame.id in ids]
        assert any(fleet.force.complied) == complies
        said.append([(f.id, f.data[2:62], f.data[63:]) for f in frames])  # no CRC, no extras
    assert said[0] == said[1]


def test_bias_goes_out_in_the_cycle_of_its_set_point_and_comes_to_the_motors(
    fleet: PushedFleet,
) -> None:
    """Nothing holds the arm, so it drifts off; what counts is the torque in the frames."""
    since = len(fleet.pump.sent)
    fleet.move(comply={"fx": 6.0})
    fleet.run(40)
    told = np.array([list(bias[:6]) for bias in fleet.said("BIAS", since)])
    limits = np.array([drive.torque_limit for drive in fleet.master.arm.drives])
    assert (np.abs(np.diff(told, axis=0)) <= 0.01001 * limits).all()
    fine = [p[1] for p in fleet.master.inputs._torque_scales]
    for joint in JOINTS:
        code = fleet.said(f"DAC_{joint}", since)[-1].force_dac
        assert code * fine[joint - 1] == pytest.approx(
            told[-1, joint - 1], abs=0.51 * abs(fine[joint - 1])
        )
    assert np.abs(told[-1]).max() > 0.3


# --- frames that are lost ----------------------------------------------------------------------


@pytest.mark.parametrize("record", [Comply, Bias])
def test_what_belongs_to_a_set_point_and_is_lost_is_a_set_point_lost(
    fleet: PushedFleet, record: type[Comply | Bias]
) -> None:
    fleet.move(comply={"fx": 1.0})
    fleet.run(30)
    lost, third = fleet.id(record), fleet.joints[2]
    fleet.pump.lose(lambda frame, to: frame.id == lost and to is third)
    fleet.run(1)  # and what goes out with the next SYNC, at once when this cycle is closed
    fleet.pump.heal()
    fleet.run(4)
    assert third.state is NodeState.OPERATIONAL
    assert third.faults[FaultCode.SETPOINT_MISSING] == 2
    assert fleet.master.fault is None
    fleet.pump.lose(lambda frame, to: frame.id == lost and to is third)
    assert re.match(r"joint 3: (SETPOINT_MISSING|no ERROR_3)", fleet.halted())
    fleet.run(8)
    assert {third.state} == {NodeState.QUICKSTOP}


# --- guarded moves -----------------------------------------------------------------------------


def test_a_guarded_move_ends_where_it_meets_something_and_says_what(fleet: PushedFleet) -> None:
    """No sensor and no friction: the motors tell what they push against."""
    sequence = fleet.move((0.3, 0, 0, 0, 0, 0), 1.0, stop_on_force={"fx": 8.0})
    fleet.run(60)
    assert status_of(fleet.master).guard is None
    fleet.push = (-12.0, 0.0, 0.0, 0.0, 0.0, 0.0)  # so the hand pushes 12 N along x
    fleet.settle(sequence)
    status = status_of(fleet.master)
    assert status.guard is not None
    assert re.fullmatch(r"move 1: fx \d+\.?\d* N reached 8 N", status.guard)
    assert fleet.master.motion.commanded.theta[0] < fleet.master.arm.park[0] + 0.29
    fleet.push = (0.0,) * 6
    fleet.run(30)
    after = fleet.move()
    assert after == sequence + 1
    fleet.settle(after)
    assert fleet.master.fault is None
    assert status_of(fleet.master).guard == status.guard  # until another guarded one


def test_what_the_last_guarded_move_met_does_not_stop_the_next(fleet: PushedFleet) -> None:
    first = fleet.move((0.3, 0, 0, 0, 0, 0), 1.0, stop_on_force={"fx": 8.0})
    fleet.run(60)
    fleet.push = (-15.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    fleet.settle(first)
    fleet.push = (0.0,) * 6
    fleet.settle(fleet.move())
    fleet.run(60)
    assert status_of(fleet.master).force == (0.0,) * 6
    again = fleet.move((0.2, 0, 0, 0, 0, 0), 1.0, stop_on_force={"fx": 8.0})
    fleet.settle(again)
    assert status_of(fleet.master).guard is None
    assert fleet.master.motion.commanded.theta[0] == pytest.approx(
        fleet.master.arm.park[0] + 0.2, abs=1e-6
    )


def test_a_move_is_stopped_by_the_way_it_has_gone(fleet: PushedFleet) -> None:
    before = fleet.master.motion.commanded.theta
    sequence = fleet.move((0.0, 0.2, 0.0, 0, 0, 0), 1.0, frame=TOOL, stop_on_distance={"dx": 0.02})
    fleet.settle(sequence)
    guard = status_of(fleet.master).guard or ""
    assert re.fullmatch(r"move 1: dx -?0\.0\d+ m reached 0\.02 m", guard)
    stopped = fleet.master.motion.commanded.theta
    gone = (direct(fleet.master.arm, before) @ TOOL).inverse() @ (
        direct(fleet.master.arm, stopped) @ TOOL
    )
    assert 0.02 <= abs(gone.px) < 0.05  # and the way it takes to stop


def test_a_guard_ends_with_its_move(fleet: PushedFleet) -> None:
    """At its goal it is over: what is met later, a part in the jaws, stops nothing."""
    sequence = fleet.move((0.1, 0, 0, 0, 0, 0), 0.5, stop_on_force={"fx": 8.0})
    fleet.settle(sequence)
    fleet.run(30)
    fleet.push = (-20.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    fleet.run(60)
    assert status_of(fleet.master).guard is None


def test_a_move_behind_a_guarded_one_is_refused(fleet: PushedFleet) -> None:
    sequence = fleet.move((0.2, 0, 0, 0, 0, 0), 0.6, stop_on_distance={"dx": 0.5})
    with pytest.raises(MoveError, match=r"'there 2' .*move 1 is guarded, .*wait for it"):
        fleet.move()
    fleet.settle(sequence)
    assert fleet.move() == sequence + 1


# --- laws -----------------------------------------------------------------------------------------


def test_under_the_position_law_compliance_is_noted_and_does_nothing(wire: Wire) -> None:
    fleet = PushedFleet(wire, friction="none", law="position")
    fleet.enable()
    since = len(fleet.pump.sent)
    pushed_aside(fleet)
    status = status_of(fleet.master)
    assert (status.comply, status.complied) == ("fx", (0.0,) * 6)
    assert {row.selection for row in fleet.said("ROWS_2", since)} == {0}
    assert not any(set(names) & {"COMPLY", "BIAS"} for names in fleet.names(since))
    assert status.complying == ""


# --- what else a program and a person do -------------------------------------------------------


def test_a_stop_leaves_it_complying_where_it_stops(fleet: PushedFleet) -> None:
    fleet.comply("fx")
    fleet.move((0.4, 0.1, 0, 0, 0, 0), 1.0)
    fleet.run(60)
    fleet.push = (5.0, 0, 0, 0, 0, 0)
    fleet.run(20)
    fleet.push = (0.0,) * 6
    fleet.master.handle(StopRequest())
    fleet.run(200)
    assert fleet.master.motion.at_rest
    status = status_of(fleet.master)
    assert status.complying == "fx"
    assert status.complied[0] > 1e-3
    fleet.push = ALONG_X
    fleet.run(60)
    assert status_of(fleet.master).complied[0] > status.complied[0] + 2e-3
    assert fleet.master.fault is None


def test_paused_it_goes_on_complying(fleet: PushedFleet) -> None:
    fleet.comply("fx")
    sequence = fleet.move((0.3, 0.1, 0, 0, 0, 0), 1.0)
    fleet.run(60)
    fleet.master.handle(PauseRequest())
    fleet.run(100)
    assert not fleet.master.motion.is_over(sequence)
    fleet.push = ALONG_X
    fleet.run(60)
    fleet.push = (0.0,) * 6
    fleet.run(60)
    assert status_of(fleet.master).complied[0] > 3e-3
    fleet.master.handle(ResumeRequest())
    fleet.settle(sequence)
    assert fleet.master.fault is None


def test_an_emergency_stop_while_complying_holds_the_joints_where_they_are(
    fleet: PushedFleet,
) -> None:
    pushed_aside(fleet)
    fleet.master.emergency_stop("the red button")
    fleet.run(20)
    assert fleet.master.phase is Phase.HALT
    assert fleet.master.fault == "the red button"
    assert all(fleet.master.arm_state.braked)
    before = fleet.plant.physics.true_q
    fleet.push = ALONG_X
    fleet.run(50)
    assert fleet.plant.physics.true_q == pytest.approx(before, abs=1e-4)


def test_enabled_again_nothing_is_left_of_it(wire: Wire) -> None:
    fleet = PushedFleet(wire, friction="none")
    fleet.enable()
    pushed_aside(fleet)
    fleet.force.reset()
    assert fleet.force.follow(fleet.master.motion.commanded.theta) is None
    assert fleet.force.bias is None


def test_an_arm_pushed_too_far_halts_with_the_reason(fleet: PushedFleet) -> None:
    fleet.comply("fy")
    fleet.move()
    fleet.run(10)
    fleet.push = (0.0, 4.0, 0.0, 0.0, 0.0, 0.0)
    reason = fleet.halted()
    assert re.match(r"compliance has displaced the arm by 0\.2\d\d m and 0\.\d\d rad, ", reason)
    fleet.push = (0.0,) * 6
    fleet.run(60)
    assert {node.state for node in fleet.joints} == {NodeState.QUICKSTOP}


def test_pushed_out_of_reach_its_set_points_go_no_further(
    fleet: PushedFleet, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rfms_can.master.force.comply.MAX_DISPLACEMENT", 2.0)
    fleet.comply("fx")
    fleet.move()
    fleet.run(10)
    before = np.array(fleet.force.comply.displacement)
    fleet.force.comply.transform = Transform.translation(0.0, 0.0, -0.9)
    fleet.run(30)
    assert fleet.master.phase is Phase.RUN
    assert np.abs(fleet.force.comply.displacement - before).max() < 1e-4


def test_what_a_tool_weighs_comes_without_a_step_and_is_compensated(fleet: PushedFleet) -> None:
    """A mode says what the hand holds: rows change their specification, torque passes over."""
    since = len(fleet.pump.sent)
    fleet.move((0.05, 0, 0, 0, 0, 0), mass=0.5, mass_centre=(0.0, 0.0, 0.05))
    fleet.run(120)
    rows = fleet.said("ROWS_2", since)
    numbers = [row.specification for row in rows]
    assert sorted(set(numbers)) == [0, 1]
    jump = abs(rows[numbers.index(1)].gravity - rows[numbers.index(1) - 1].gravity)
    assert jump > 0.5
    scale = abs(fleet.master.inputs._torque_scales[1][0])
    torques = np.array([dac.current_dac for dac in fleet.said("DAC_2", since)]) * scale
    assert np.abs(np.diff(torques)).max() < 0.6 * jump


@pytest.mark.parametrize("law", ["hybrid", "free-joint", "raibert-craig"])
def test_every_law_complies_and_comes_back(wire: Wire, law: str) -> None:
    fleet = PushedFleet(wire, friction="none", law=law)
    fleet.enable()
    pushed_aside(fleet)
    assert status_of(fleet.master).complied[0] > 0.003
    fleet.lock("fx")
    fleet.settle(fleet.move())
    assert fleet.master.fault is None
    assert fleet.plant.physics.true_q == pytest.approx(list(fleet.master.arm.park), abs=2e-3)


def test_under_the_stiffness_law_a_push_goes_on_and_on(wire: Wire) -> None:
    """Its compliant directions have no stiffness, and so no damping; the others hold."""
    fleet = PushedFleet(wire, friction="none", law="stiffness")
    fleet.enable()
    fleet.comply("fx")
    fleet.move()
    fleet.run(110)
    fleet.push = (4.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    fleet.run(15)
    fleet.push = (0.0,) * 6
    fleet.run(30)
    first = status_of(fleet.master).complied[0]
    fleet.run(60)
    second = status_of(fleet.master).complied[0]
    fleet.run(60)
    third = status_of(fleet.master).complied[0]
    assert second - first > 0.002
    assert third - second > 0.4 * (second - first)  # damped as the others are: 0.06
    assert {row.damping for row in fleet.said("ROWS_2")} == {0.0}


def test_an_arm_without_a_model_complies_by_the_inertia_of_its_gains(wire: Wire) -> None:
    """Nothing is compensated then, its weight neither; but rows there must be."""
    fleet = PushedFleet(wire, friction="none", law="hybrid", dynamics="none")
    fleet.enable()
    fleet.comply("rz")
    since = len(fleet.pump.sent)
    fleet.move()
    fleet.run(10)
    row = fleet.said("ROWS_6", since)[-1]
    assert row.selection == 0b100000
    assert row[5] == pytest.approx(0.0, abs=1e-5)  # rz is joint 6's own ...
    assert fleet.said("ROWS_1", since)[-1][:6] == pytest.approx(
        (1.0, 0, 0, 0, 0, 0), abs=1e-5
    )  # ... and nobody else's


def test_singularities_met_while_complying_are_told_once_each(fleet: PushedFleet) -> None:
    reported = fleet.master.rows.reported
    way = 0.02 - fleet.master.arm.park[4]  # theta5 to a degree from zero
    fleet.settle(fleet.move((0.0, 0.0, 0.0, 0.0, way, 0.0), 1.5))
    assert reported == []
    fleet.comply("rx")
    fleet.move((0.0, 0.0, 0.0, 0.0, way, 0.0))
    fleet.run(40)
    assert len(reported) == len(set(reported)) == 1
    assert re.fullmatch(r"near a singularity [fr][xyz].* beside rx could not be held", reported[0])
    assert fleet.master.fault is None


def test_a_frame_in_the_world_does_not_ride_on_the_tool(fleet: PushedFleet) -> None:
    """The same directions in the world, wherever the arm has turned to."""
    master = fleet.master
    arm = master.arm
    world = Transform.rotation((0, 0, 1), 0.6)
    goal = direct(arm, [q + w for q, w in zip(arm.park, (0.3, 0, 0, 0.2, 0.3, 0.4), strict=True)])
    for name, value in (("task", world), ("part", world.inverse() @ goal)):
        master.handle(TransformMessage(name, value))
    position = PositionMessage("there", ["t6"], ["task", "part"], compliance="task")
    master.handle(position)
    frame = master.motion.world.position("there").compliance_frame
    for T6 in (goal, direct(arm, arm.park)):
        assert T6 @ frame(Moment(0), T6) == pytest.approx(world, abs=1e-12)

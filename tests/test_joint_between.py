"""A joint between states and cycles: braked, left alone, started over, stopped halfway."""

import pytest
from support.bench import Heard
from support.joint_bench import JointBench, step_limit

from rfms_can.joint_nodes.gripper import GripperNode
from rfms_can.wire.configuration import PARAMETERS
from rfms_can.wire.contract import ESTOP_VALUES, Wire
from rfms_can.wire.records import Config, Estop
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState, Parameter


@pytest.fixture
def ready(wire: Wire) -> JointBench:
    bench = JointBench(wire)
    bench.configure()
    bench.home()
    return bench


@pytest.fixture
def bench(ready: JointBench) -> JointBench:
    ready.start()
    return ready


def kinds(heard: list[Heard]) -> list[str]:
    return [h.name.partition("_")[0] for h in heard]


# --- torque off, where there is none -------------------------------------------------------------


def test_torque_off_sends_no_dac_to_a_joint_that_is_braked(ready: JointBench) -> None:
    """The board would open its brake for three cycles, with no current."""
    ready.sync(NodeState.READY)
    assert kinds(ready.say(Estop, None, *ESTOP_VALUES)) == ["EMCY"]


def test_torque_off_ends_the_hold_after_homing(ready: JointBench) -> None:
    assert kinds(ready.say(Estop, None, *ESTOP_VALUES)) == ["EMCY", "DAC"]


def test_torque_off_of_a_gripper_that_drives_nothing_sends_no_dac(wire: Wire) -> None:
    gripper = GripperNode(wire, 1)
    gripper.on_time(0)
    answers = gripper.on_frame(wire.sender(Estop).frame(*ESTOP_VALUES), 0)
    assert [frame.id & 0x780 for frame in answers] == [0x080]


# --- held again -----------------------------------------------------------------------------------


def hold(bench: JointBench) -> float:
    """A cycle in which SYNC says HOMING: the torque."""
    bench.sync(NodeState.HOMING)
    bench.measure()
    bench.reference()
    return bench.controller.torque


def test_a_hold_after_operation_holds_where_the_joint_is_then(bench: JointBench) -> None:
    """Not where it was homed, which may be radians away."""
    bench.reach(0.9 * bench.parameters[Parameter.SPEED_LIMIT])
    bench.run(60)
    bench.reach(0.0)
    bench.command(Command.STOP)
    assert abs(hold(bench)) < 0.05 * bench.parameters[Parameter.TORQUE_LIMIT]
    assert bench.controller.homing.error == 0.0
    assert bench.state is NodeState.READY


def test_a_hold_after_a_pause_holds_where_the_joint_was_moved_to(ready: JointBench) -> None:
    hold(ready)
    ready.sync(NodeState.READY)
    ready.q[ready.index] += 0.3
    hold(ready)
    assert ready.controller.homing.error == 0.0
    ready.q[ready.index] += 0.0005
    hold(ready)
    assert ready.controller.homing.error != 0.0


# --- cycles that end early ------------------------------------------------------------------------


def test_a_quickstop_after_the_sample_leaves_no_missing_frame_behind(bench: JointBench) -> None:
    bench.sync()
    bench.setpoint()
    bench.measure()
    bench.command(Command.QUICKSTOP)
    bench.sync(NodeState.QUICKSTOP)
    assert kinds(bench.measure()) == ["DAC"]
    assert not bench.node.faults


def test_a_quickstop_before_the_sample_still_needs_it(bench: JointBench) -> None:
    bench.sync()
    bench.setpoint()
    bench.command(Command.QUICKSTOP)
    bench.sync(NodeState.QUICKSTOP)
    assert set(bench.node.faults) == {FaultCode.MEASURE_MISSING}


def test_what_a_cycle_lacked_counts_also_where_the_next_sync_is_lost(bench: JointBench) -> None:
    bench.sync()
    bench.measure()
    bench.other_errors()  # no SETPOINT
    bench.miss_syncs(1)
    assert set(bench.node.faults) == {FaultCode.SETPOINT_MISSING, FaultCode.SYNC_MISSING}
    bench.run()
    assert bench.node.faults == {FaultCode.SETPOINT_MISSING: 1, FaultCode.SYNC_MISSING: 1}


def test_a_set_point_and_the_sync_after_it_lost_are_two_cycles_of_its_history(
    bench: JointBench,
) -> None:
    """The joint goes on as if both had come."""
    bench.speed = 0.15 * bench.parameters[Parameter.SPEED_LIMIT]
    bench.run(20)
    rate = bench.controller.trajectory.rate
    bench.sync()
    bench.measure()
    bench.miss_syncs(1)
    bench.run()
    assert bench.controller.trajectory.rate == pytest.approx(rate, rel=1e-3)


def test_a_second_sample_in_a_cycle_is_no_glitch(bench: JointBench) -> None:
    """Its cycles since the last one are none, but a joint moves all the same."""
    bench.sync()
    bench.setpoint()
    bench.measure()
    bench.measure(bench.q[bench.index] + 0.5 * step_limit(bench))
    assert not bench.node.faults


# --- starting over --------------------------------------------------------------------------------


def test_start_counts_as_the_sync_before_the_first(ready: JointBench) -> None:
    ready.command(Command.START)
    ready.cycle = 1  # 0 and 1 are lost
    ready.run()
    held = ready.controller
    assert held.trajectory.theta == pytest.approx(ready.q[ready.index], abs=1e-6)
    assert held.action.tells_error and not ready.node.faults


def test_what_came_before_start_has_no_part_in_the_cycle_under_way(ready: JointBench) -> None:
    ready.sync()
    ready.setpoint()
    ready.measure()
    ready.other_errors([0.5] * 6)
    ready.command(Command.START)
    assert ready.other_errors(without=(1, 3, 4, 5, 6)) == []
    ready.setpoint()
    assert kinds(ready.measure()) == ["ERROR"]
    ready.cycle = -1
    assert "DAC" in kinds(ready.run())
    assert not ready.node.faults


def test_reset_in_preop_forgets_the_rows_of_the_master_before(wire: Wire) -> None:
    bench = JointBench(wire)
    bench.configure()
    bench.rows(7, gravity=3.0)
    bench.command(Command.RESET)
    assert bench.node.rows.waiting(7) is None


def test_another_configuration_forgets_the_rows(wire: Wire) -> None:
    bench = JointBench(wire)
    bench.rows(7, gravity=3.0)
    bench.configure()
    assert bench.node.rows.waiting(7) is None


def test_a_void_configuration_is_not_watched(ready: JointBench) -> None:
    ready.command(Command.RESET)
    assert ready.node.next_deadline_ns() is not None
    ready.say(Config, ready.number, Parameter.KP, 0, 1.0, 0)
    assert ready.node.next_deadline_ns() is None


@pytest.mark.parametrize("parameter", list(PARAMETERS), ids=lambda p: p.name)
def test_the_bounds_of_a_range_can_be_sent(parameter: Parameter, ready: JointBench) -> None:
    """Also 0.0002, of which float32 makes a little less."""
    known = PARAMETERS[parameter]
    for bound in (known.low, known.high):
        assert known.refusal(bound) is None
        assert known.refusal(ready.wire_value(bound)) is None

"""The safety ladder of a joint node (R1 hold, R2 stop, R3 damp, R4 off), without any master."""

import pytest
from support.bench import PERIOD_NS
from support.joint_bench import ANY_SPEED, JointBench

from rfms_can.joint_nodes.ladder import LADDERS, Ladder, Reaction
from rfms_can.joint_nodes.sensing import HARD_MARGIN_RAD
from rfms_can.wire.contract import Wire
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState, Parameter

ROWS_SET = 1


@pytest.fixture
def bench(wire: Wire) -> JointBench:
    return JointBench(wire).enable()


def _free_run(bench: JointBench, cycles: int) -> list[int]:
    """SYNC fails; the plant goes on by itself. DAC codes the joint sends, in that time."""
    first = len(bench.dacs())
    for _ in range(cycles):
        bench.miss_syncs(1)
        bench.measure()
    return [dac.current_dac for dac in bench.dacs()[first:]]


# --- missing SYNC ------------------------------------------------------------------------------


def test_one_or_two_missing_syncs_hold_the_last_code(bench: JointBench) -> None:
    assert _free_run(bench, 2) == []  # the board holds what it was told last
    assert bench.state is NodeState.OPERATIONAL
    assert bench.emergencies() == []
    assert bench.dacs(bench.run())  # and the joint goes on with the next SYNC
    assert bench.node.faults[FaultCode.SYNC_MISSING] == 2


def test_a_sync_is_missed_half_a_period_after_it_was_due(bench: JointBench) -> None:
    assert bench.node.next_deadline_ns() == bench.now_ns + PERIOD_NS * 3 // 2
    bench.miss_syncs(1)
    assert bench.node.next_deadline_ns() == bench.now_ns + PERIOD_NS


@pytest.mark.parametrize("syncs", [3, 4])
def test_the_third_missing_sync_stops_the_joint_and_says_so_once(
    bench: JointBench, syncs: int
) -> None:
    codes = _free_run(bench, syncs)
    assert bench.state is NodeState.QUICKSTOP
    assert [e.fault for e in bench.emergencies()] == [FaultCode.SYNC_MISSING]
    assert len(codes) == syncs - 2  # it drives itself to rest with the plant's own MEASURE


def test_the_fifth_missing_sync_damps_with_a_capped_torque(wire: Wire) -> None:
    bench = JointBench(wire, changes=ANY_SPEED).enable()
    _free_run(bench, 4)
    cap = 0.2 * bench.parameters[Parameter.TORQUE_LIMIT]
    scale = bench.parameters[Parameter.TORQUE_PER_CODE]
    for speed in (0.05, -0.05, 2.0, -2.0):
        bench.speed = speed
        (code,) = _free_run(bench, 1)
        wanted = -bench.parameters[Parameter.KD] * bench.read_speed
        assert code * scale == pytest.approx(max(-cap, min(cap, wanted)), abs=0.51 * abs(scale))
    assert bench.state is NodeState.FAULT
    assert bench.node.reaction is Reaction.DAMP


def test_a_damped_joint_that_leaves_its_range_goes_off(wire: Wire) -> None:
    bench = JointBench(wire, changes={Parameter.TACHOMETER_LIMIT: 1.0})  # it is thrown at once
    end = bench.arm.joint_limits[bench.index][1]
    bench.q[bench.index] = end
    bench.enable()
    _free_run(bench, 5)
    assert bench.node.reaction is Reaction.DAMP
    bench.speed = 1.0
    codes = []
    while bench.node.reaction is Reaction.DAMP:
        codes += _free_run(bench, 1)
    assert 0.0 < bench.q[bench.index] - end - HARD_MARGIN_RAD < 1.0 * PERIOD_NS * 1e-9
    assert len(codes) > 10 and 0 not in codes[:-1]
    assert codes[-1] == 0
    assert bench.emergencies()[-1].fault == FaultCode.HARD_LIMIT
    assert _free_run(bench, 3) == []


def test_damping_carries_the_weight_of_the_arm(bench: JointBench) -> None:
    bench.rows(ROWS_SET, gravity=-2.5)
    bench.run()
    codes = _free_run(bench, 6)
    scale = bench.parameters[Parameter.TORQUE_PER_CODE]
    assert codes[-1] * scale == pytest.approx(-2.5, abs=0.51 * abs(scale))


def test_the_twenty_fifth_missing_sync_ends_torque_and_then_there_is_silence(
    bench: JointBench,
) -> None:
    bench.rows(ROWS_SET, gravity=5.0)
    bench.run()
    assert 0 not in _free_run(bench, 24)
    assert _free_run(bench, 1) == [0]
    assert _free_run(bench, 20) == []
    assert bench.state is NodeState.FAULT
    assert bench.node.reaction is Reaction.OFF
    codes = [FaultCode.SYNC_MISSING] * 3  # one for each rung
    assert [e.fault for e in bench.emergencies()] == codes


@pytest.mark.parametrize("syncs", [3, 5, 25])
def test_no_node_comes_back_when_sync_does(bench: JointBench, syncs: int) -> None:
    _free_run(bench, syncs)
    stopped = bench.state
    bench.run(50)
    bench.command(Command.HOME)
    bench.command(Command.START)
    bench.command(Command.STOP)
    bench.run(2)
    assert bench.state is stopped
    assert bench.errors(bench.run()) == []


def test_after_reset_and_homing_the_ladder_starts_from_the_ground(bench: JointBench) -> None:
    _free_run(bench, 30)
    bench.command(Command.RESET)
    assert bench.dacs(bench.run(3)) == []
    bench.home()
    bench.start()
    assert bench.node.error_register == 0
    assert _free_run(bench, 2) == []
    assert len(_free_run(bench, 1)) == 1
    assert bench.state is NodeState.QUICKSTOP


def test_missing_syncs_have_to_come_in_a_row(bench: JointBench) -> None:
    for _ in range(10):
        _free_run(bench, 2)
        bench.run()
    assert bench.state is NodeState.OPERATIONAL


def test_a_joint_at_rest_in_preop_has_no_ladder(bench: JointBench) -> None:
    bench.command(Command.STOP)
    bench.command(Command.RESET)
    _free_run(bench, 40)
    assert bench.state is NodeState.PREOP
    assert bench.emergencies() == []


def test_a_homing_joint_that_loses_sync_gives_up_and_waits_for_reset(wire: Wire) -> None:
    bench = JointBench(wire)
    bench.configure()
    bench.command(Command.HOME)
    bench.sync(NodeState.HOMING)
    _free_run(bench, 3)
    assert bench.state is NodeState.PREOP
    assert [e.fault for e in bench.emergencies()] == [FaultCode.SYNC_MISSING]
    bench.command(Command.HOME)
    assert bench.state is NodeState.PREOP
    assert bench.node.ignored["HOME before RESET"] == 1
    bench.command(Command.RESET)
    bench.home()


# --- missing set-points ------------------------------------------------------------------------


def _without_setpoint(bench: JointBench) -> list[int]:
    first = len(bench.dacs())
    bench.sync()
    bench.measure()
    bench.other_errors()
    return [dac.current_dac for dac in bench.dacs()[first:]]


def test_missing_setpoints_hold_then_stop(bench: JointBench) -> None:
    for _ in range(3):  # the miss is known when the next cycle begins
        assert _without_setpoint(bench) == []
        assert bench.state is NodeState.OPERATIONAL
    assert len(_without_setpoint(bench)) == 1
    assert bench.state is NodeState.QUICKSTOP
    (emergency,) = bench.emergencies()
    assert emergency.fault == FaultCode.SETPOINT_MISSING


def test_a_stopped_joint_that_nobody_leads_damps_and_goes_off(bench: JointBench) -> None:
    reached = []
    for _ in range(27):
        _without_setpoint(bench)
        reached.append(bench.node.reaction)
    assert reached[3:6] == [Reaction.STOP, Reaction.STOP, Reaction.DAMP]
    assert reached[24:26] == [Reaction.DAMP, Reaction.OFF]
    assert bench.dacs()[-1].current_dac == 0


def test_a_stopped_joint_holds_while_the_master_says_stop(bench: JointBench) -> None:
    for _ in range(4):
        _without_setpoint(bench)
    for _ in range(60):
        bench.sync(NodeState.QUICKSTOP)
        assert len(bench.dacs(bench.measure())) == 1
    assert bench.node.reaction is Reaction.STOP


def test_a_setpoint_in_between_clears_the_count(bench: JointBench) -> None:
    for _ in range(8):
        _without_setpoint(bench)
        _without_setpoint(bench)
        bench.run()
    assert bench.state is NodeState.OPERATIONAL


def test_an_operational_joint_on_a_bus_that_is_not_stops(bench: JointBench) -> None:
    """QUICKSTOP was lost: SYNC tells, and the missing set-points do the rest."""
    for _ in range(4):
        bench.sync(NodeState.QUICKSTOP)
        bench.measure()
    assert bench.state is NodeState.QUICKSTOP


# --- missing measurements, errors, rows --------------------------------------------------------


def _without_measure(bench: JointBench) -> list[int]:
    first = len(bench.dacs())
    bench.sync()
    bench.setpoint()
    bench.other_errors()
    return [dac.current_dac for dac in bench.dacs()[first:]]


def test_three_missing_measurements_end_torque(bench: JointBench) -> None:
    assert [_without_measure(bench) for _ in range(4)] == [[], [], [], [0]]
    assert bench.state is NodeState.FAULT
    (emergency,) = bench.emergencies()
    assert emergency.fault == FaultCode.MEASURE_MISSING
    assert [_without_measure(bench) for _ in range(5)] == [[]] * 5


@pytest.mark.parametrize("what", ["measure", "error"])
def test_missing_answers_have_to_come_in_a_row(bench: JointBench, what: str) -> None:
    for _ in range(8):
        for _ in range(2):
            bench.sync()
            bench.setpoint()
            if what == "error":
                bench.measure()
            bench.other_errors(without=(5,) if what == "error" else ())
        bench.run()
    assert bench.state is NodeState.OPERATIONAL
    assert bench.emergencies() == []


def test_a_stopped_joint_needs_its_measurements_too(bench: JointBench) -> None:
    bench.command(Command.QUICKSTOP)
    for _ in range(4):
        bench.sync(NodeState.QUICKSTOP)
    assert bench.node.reaction is Reaction.OFF
    assert bench.dacs()[-1].current_dac == 0


def test_three_missing_errors_of_another_joint_stop_this_one(bench: JointBench) -> None:
    for state in [NodeState.OPERATIONAL] * 3 + [NodeState.QUICKSTOP]:
        bench.sync()
        assert bench.state is state
        bench.setpoint()
        answers = bench.measure() + bench.other_errors(without=(5,))
        assert len(bench.dacs(answers)) == (state is NodeState.QUICKSTOP)
    assert [e.fault for e in bench.emergencies()] == [FaultCode.ERROR_MISSING]


def test_a_row_set_that_is_named_but_not_here_stops_the_joint_in_three_cycles(
    bench: JointBench,
) -> None:
    for number in (7, 8):
        assert bench.dacs(bench.run(row_set=number))  # the old rows go on
    bench.sync(row_set=9)
    assert bench.state is NodeState.QUICKSTOP
    assert [e.fault for e in bench.emergencies()] == [FaultCode.ROWS_MISSING]


# --- the ladder by itself ----------------------------------------------------------------------


@pytest.mark.parametrize("fault", LADDERS)
def test_rungs_are_reached_at_their_bounds_and_never_descend(fault: FaultCode) -> None:
    ladder, steps = Ladder(), dict(LADDERS[fault])
    expected = Reaction.NONE
    for count in range(1, 40):
        expected = steps.get(count, expected)
        assert ladder.miss(fault) is expected
    ladder.clear(fault)
    assert ladder.miss(fault) is steps.get(1, Reaction.NONE)


def test_the_bounds_are_those_of_the_protocol() -> None:
    for_leaders = ((1, Reaction.HOLD), (3, Reaction.STOP), (5, Reaction.DAMP), (25, Reaction.OFF))
    assert LADDERS[FaultCode.SYNC_MISSING] == for_leaders
    assert LADDERS[FaultCode.SETPOINT_MISSING] == for_leaders
    assert LADDERS[FaultCode.MEASURE_MISSING][-1] == (3, Reaction.OFF)
    assert LADDERS[FaultCode.SETPOINT_STEP] == ((1, Reaction.STOP),)

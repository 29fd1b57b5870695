"""The gripper node: homes on its stop, opens, closes and holds, and has the same ladder."""

import pytest
from support.bench import PERIOD_NS, FieldNodeBench, Heard

from rfms_can.arm import PUMA_260, Arm
from rfms_can.joint_nodes.gripper import AT_REST_CYCLES, HOMING_FRACTION, GripperNode
from rfms_can.joint_nodes.ladder import Reaction
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.node.port_counts import PortCounts
from rfms_can.plant.jaw import Jaw
from rfms_can.wire.codec import MessageCodec
from rfms_can.wire.contract import ESTOP_VALUES, Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import GRIPPER, PLANT
from rfms_can.wire.records import Config, Estop, Gripper, Measure, Sync
from rfms_can.wire.vocabulary import (
    Command,
    ConfigStatus,
    FaultCode,
    GripperCommand,
    NodeState,
    Parameter,
)

FULL = 2047  # 2048 codes are the force limit; the converter ends one before


class GripperBench(FieldNodeBench[GripperNode]):
    """The gripper node and its jaw's board."""

    def __init__(self, wire: Wire, arm: Arm = PUMA_260) -> None:
        node = GripperNode(wire, 0x107)
        super().__init__(node, wire, all_parameters(arm, "corke", PERIOD_NS * 1e-9)[GRIPPER])
        self.arm = arm

    def measure(self, counts: int, cycle: int | None = None) -> list[Heard]:
        """MEASURE of the jaw."""
        low = (self.cycle if cycle is None else cycle) & 0xFF
        return self.say(Measure, GRIPPER, counts, 0, 0, low, 0, 0)


@pytest.fixture
def bench(wire: Wire) -> GripperBench:
    bench = GripperBench(wire)
    bench.configure()
    return bench


def cycle(bench: GripperBench, counts: int, state: NodeState = NodeState.OPERATIONAL) -> list[int]:
    """One cycle with the jaw at some counts; DAC codes of it."""
    return [d.current_dac for d in bench.dacs(bench.sync(state) + bench.measure(counts))]


def home(bench: GripperBench, at: int = 4000) -> None:
    """Open to the stop, which is at some counts since power-up."""
    bench.command(Command.HOME)
    for _ in range(AT_REST_CYCLES + 1):
        cycle(bench, at, NodeState.HOMING)
    assert bench.state is NodeState.READY


def command(bench: GripperBench, what: GripperCommand, force: float) -> None:
    bench.say(Gripper, None, what, force, bench.cycle & 0xFF)


def enable(bench: GripperBench) -> GripperBench:
    home(bench)
    bench.command(Command.START)
    bench.cycle = -1
    cycle(bench, 4000)
    return bench


def test_homing_opens_gently_until_the_jaw_rests_on_its_stop(bench: GripperBench) -> None:
    bench.command(Command.HOME)
    for counts in range(0, 4000, 200):
        (code,) = cycle(bench, counts, NodeState.HOMING)
        assert code == round(HOMING_FRACTION * 2048)
        assert bench.state is NodeState.HOMING
    for _ in range(AT_REST_CYCLES):
        assert bench.state is NodeState.HOMING
        cycle(bench, 3801, NodeState.HOMING)  # one count does not count as motion
    assert bench.state is NodeState.READY
    cycle(bench, 3801, NodeState.HOMING)
    assert bench.node.opening == pytest.approx(PUMA_260.gripper.stroke)


def test_a_real_jaw_is_referenced_to_its_stroke(bench: GripperBench) -> None:
    jaw = Jaw(PUMA_260.gripper, 0.031)
    bench.command(Command.HOME)
    for _ in range(500):
        (code,) = cycle(bench, jaw.sample()[0], NodeState.HOMING)
        jaw.set_motor_current(code)
        for _ in range(4):
            jaw.step(0.001)
        if bench.state is NodeState.READY:
            break
    cycle(bench, jaw.sample()[0], NodeState.HOMING)
    assert jaw.opening == PUMA_260.gripper.stroke
    assert bench.node.opening == pytest.approx(jaw.opening, abs=1.1e-5)


@pytest.mark.parametrize(
    ("what", "force", "code"),
    [
        (GripperCommand.OPEN, 100.0, FULL),
        (GripperCommand.CLOSE, 100.0, -2048),
        (GripperCommand.OPEN, 50.0, 1024),
        (GripperCommand.CLOSE, 12.5, -256),
        (GripperCommand.HOLD, 100.0, 0),
    ],
)
def test_commands_become_forces_at_the_next_sync(
    bench: GripperBench, what: GripperCommand, force: float, code: int
) -> None:
    enable(bench)
    bench.sync()
    command(bench, what, force)
    assert [d.current_dac for d in bench.dacs(bench.measure(4000))] == [0]
    assert cycle(bench, 4000) == [code]
    assert cycle(bench, 3900) == [code]  # it stays, moving or not


def test_resting_counts_the_cycles_without_motion_since_the_command(bench: GripperBench) -> None:
    enable(bench)
    command(bench, GripperCommand.CLOSE, 100.0)
    for k in range(1, 6):
        cycle(bench, 4000 - 100 * k)
        assert bench.node.resting == 0
    for k in range(1, 20):
        cycle(bench, 3500)
        assert bench.node.resting == k
    command(bench, GripperCommand.OPEN, 100.0)
    cycle(bench, 3500)
    assert bench.node.resting == 1


def test_opening_is_known_in_metres(bench: GripperBench) -> None:
    enable(bench)
    gripper = PUMA_260.gripper
    cycle(bench, 4000 - round(0.02 * gripper.counts_per_metre))
    assert bench.node.opening == pytest.approx(gripper.stroke - 0.02)


def test_it_answers_every_cycle_once(bench: GripperBench) -> None:
    enable(bench)
    for _ in range(300):
        bench.sync()
        (dac,) = bench.dacs(bench.measure(4000))
        assert dac.cycle == bench.cycle & 0xFF


def test_stale_measurements_are_ignored(bench: GripperBench) -> None:
    enable(bench)
    bench.sync()
    assert bench.measure(4000, cycle=bench.cycle - 1) == []
    assert bench.node.ignored["stale MEASURE"] == 1
    assert len(bench.dacs(bench.measure(4000))) == 1


def test_three_missing_measurements_end_the_force(bench: GripperBench) -> None:
    enable(bench)
    command(bench, GripperCommand.CLOSE, 100.0)
    cycle(bench, 4000)
    answers = [bench.sync() for _ in range(4)]
    assert [bench.dacs(a) for a in answers[:3]] == [[], [], []]
    assert [d.current_dac for d in bench.dacs(answers[3])] == [0]
    assert [e.fault for e in bench.emergencies()] == [FaultCode.MEASURE_MISSING]
    assert bench.node.reaction is Reaction.OFF
    assert cycle(bench, 4000) == []


def test_it_climbs_the_ladder_of_missing_syncs(bench: GripperBench) -> None:
    enable(bench)
    assert bench.miss_syncs(2) == []
    reached = []
    for syncs in (1, 2, 20):
        answers = bench.miss_syncs(syncs)
        reached.append(bench.node.reaction)
    assert reached == [Reaction.STOP, Reaction.DAMP, Reaction.OFF]
    assert [d.current_dac for d in bench.dacs(answers)] == [0]
    bench.command(Command.START)
    assert bench.state is NodeState.FAULT


def test_emergency_stop_ends_the_force(bench: GripperBench) -> None:
    enable(bench)
    command(bench, GripperCommand.CLOSE, 100.0)
    cycle(bench, 4000)
    answers = bench.say(Estop, None, *ESTOP_VALUES)
    assert [d.current_dac for d in bench.dacs(answers)] == [0]
    assert cycle(bench, 4000) == []


def test_a_stopped_gripper_does_not_let_its_part_go(bench: GripperBench) -> None:
    """No frame is sent while the bus stops: the board keeps the last force."""
    enable(bench)
    command(bench, GripperCommand.CLOSE, 100.0)
    cycle(bench, 4000)
    bench.command(Command.QUICKSTOP)
    assert cycle(bench, 3000, NodeState.QUICKSTOP) == []


def test_a_gripper_that_joins_a_running_bus_stays_silent(wire: Wire) -> None:
    bench = GripperBench(wire)
    for state in (NodeState.HOMING, NodeState.OPERATIONAL):
        command(bench, GripperCommand.CLOSE, 100.0)
        assert cycle(bench, 4000, state) == []
    assert bench.state is NodeState.PREOP


@pytest.mark.parametrize("parameter", [Parameter.TORQUE_PER_CODE, Parameter.COUNTS_PER_UNIT])
def test_scales_nothing_can_be_divided_by_are_refused(wire: Wire, parameter: Parameter) -> None:
    bench = GripperBench(wire)
    bench.parameters[parameter] = 0.0
    for known, value in bench.parameters.items():
        bench.say(Config, 7, known, 0, value, 0)
    (answer,) = bench.commit()
    assert answer.values.status == ConfigStatus.WRONG_HASH


def test_a_jaw_that_never_comes_to_rest_ends_homing_in_its_time(bench: GripperBench) -> None:
    bench.command(Command.HOME)
    limit = bench.parameters[Parameter.HOMING_TIME]
    cycles, counts = 0, 0
    while bench.state is NodeState.HOMING:
        cycles += 1
        counts += 5  # a slipping belt
        codes = cycle(bench, counts, NodeState.HOMING)
    assert cycles * PERIOD_NS * 1e-9 == pytest.approx(limit, abs=0.01)
    (emergency,) = bench.emergencies()
    assert emergency.fault == FaultCode.HOMING_FAILED
    assert emergency.bound == pytest.approx(limit)
    assert codes == [0]
    assert bench.node.reaction is Reaction.OFF


# --- its bus ------------------------------------------------------------------------------------


def test_a_second_master_stops_it_and_its_force_stays(bench: GripperBench) -> None:
    enable(bench)
    command(bench, GripperCommand.CLOSE, 100.0)
    for _ in range(20):
        cycle(bench, 4000)
    sent = len(bench.dacs())
    bench.give(bench.wire.sender(Sync).frame(9, 4, 0, bench.wire.dbc_hash))
    (emergency,) = bench.emergencies()
    assert emergency.fault == FaultCode.FOREIGN_MASTER
    assert (emergency.value, emergency.bound) == (9, bench.cycle)
    assert bench.state is NodeState.QUICKSTOP
    assert len(bench.dacs()) == sent, "the board keeps the last force: nothing is let go"


def test_bad_samples_are_those_of_who_sends_them(bench: GripperBench) -> None:
    enable(bench)
    codec: MessageCodec[Measure] = bench.wire.codec(Measure, GRIPPER)
    for _ in range(3):
        cycle(bench, 4000)
        bench.give(Frame(codec.id, b"\xff" * codec.length))
    (emergency,) = bench.emergencies()
    assert emergency.fault == FaultCode.BAD_FRAMES
    assert (emergency.culprit, emergency.frame) == (PLANT, codec.id)


def test_it_tells_of_its_own_port(bench: GripperBench) -> None:
    enable(bench)
    bench.node.port_counts = lambda: PortCounts(overflows=bench.cycle)
    for _ in range(3):
        assert bench.emergencies() == []
        cycle(bench, 4000)
    assert [e.fault for e in bench.emergencies()] == [FaultCode.QUEUE_OVERFLOW]
    bench.node.port_counts = lambda: PortCounts(bus_offs=1, overflows=bench.cycle)
    cycle(bench, 4000)
    assert bench.emergencies()[-1].fault == FaultCode.BUS_OFF

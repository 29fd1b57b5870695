"""A joint node by itself: its solution, its errors, its answers, and whom it trusts."""

import random
from collections.abc import Callable

import pytest
from support.bench import PERIOD_NS, Heard
from support.joint_bench import ANY_SPEED, JointBench, step_limit

from rfms_can.arm import ARMS
from rfms_can.joint_nodes.joint import JointNode
from rfms_can.kinematics import configuration_of, direct, inverse
from rfms_can.transform import Transform
from rfms_can.wire.contract import ESTOP_VALUES, Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import Estop, Setpoint, Sync
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState

PERIOD = PERIOD_NS * 1e-9


@pytest.fixture
def bench(wire: Wire) -> JointBench:
    return JointBench(wire).enable()


# --- own solution, own error ------------------------------------------------------------------


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("joint", JOINTS)
def test_own_solution_is_the_full_solution_of_the_t6_on_the_wire(
    wire: Wire, name: str, joint: int
) -> None:
    arm, rng = ARMS[name], random.Random(joint)
    step = 0.25 * step_limit(JointBench(wire, joint, arm))
    bench = JointBench(wire, joint, arm, ANY_SPEED).enable()
    codec = wire.codec(Setpoint, 1)
    for _ in range(40):
        bench.q = [q + rng.uniform(-step, step) for q in bench.q]
        bench.sync()
        answers = bench.setpoint() + bench.measure(bench.q[bench.index] - 0.001)
        bench.other_errors()
        (error,) = bench.errors(answers)
        values = codec.unpack(bytes(bench.sender(Setpoint, 1)._buffer))
        assert values is not None
        on_wire = Transform.from_o_a_p(values[0:3], values[3:6], values[6:9])
        full = inverse(arm, on_wire, configuration_of(arm, bench.q), bench.q)
        assert bench.controller.trajectory.theta == pytest.approx(full[bench.index], abs=1e-12)
        assert bench.controller.trajectory.theta == pytest.approx(bench.q[bench.index], abs=2e-6)
        assert error.error == pytest.approx(
            full[bench.index] - bench.angle(bench.q[bench.index] - 0.001), abs=1e-7
        )


def test_solvers_of_all_joints_agree_where_the_arm_stands(wire: Wire) -> None:
    arm = ARMS["puma560"]
    told = []
    for joint in JOINTS:
        bench = JointBench(wire, joint, arm).enable()
        told.append(bench.controller.trajectory.theta)
    assert direct(arm, told) == pytest.approx(direct(arm, arm.park), abs=1e-6)


def test_error_tells_error_rate_and_the_commanded_acceleration(bench: JointBench) -> None:
    """Along theta = 1/2 a t2 the rate is a t, less the speed measured, and the acceleration a."""
    a = 2.0
    for k in range(1, 60):
        t = k * PERIOD
        bench.speed = a * (t - 0.5 * PERIOD)
        (error,) = bench.errors(bench.run())
        if k >= 5:  # the start has left the four set-points the rate is made of
            assert error.error == pytest.approx(bench.q[1] - bench.angle(), abs=3e-7)
            assert error.error_rate == pytest.approx(a * t - bench.read_speed, abs=1e-3)
            assert error.acceleration == pytest.approx(a, abs=0.25)  # float32 twice differenced
        assert error.cycle == bench.cycle


def test_error_goes_out_before_anybody_elses_is_heard_and_dac_after_all(bench: JointBench) -> None:
    bench.sync()
    assert [h.name for h in bench.setpoint() + bench.measure()] == ["ERROR_2"]
    assert bench.other_errors(without=(6,)) == []
    answers = bench.other_errors(without=(1, 3, 4, 5))
    assert [h.name for h in answers] == ["DAC_2"]


@pytest.mark.parametrize("order", ["smo", "mso", "osm", "oms"])
def test_frames_of_a_cycle_may_come_in_any_order(bench: JointBench, order: str) -> None:
    steps: dict[str, Callable[[], list[Heard]]] = {
        "s": bench.setpoint,
        "m": bench.measure,
        "o": bench.other_errors,
    }
    for _ in range(3):
        bench.sync()
        answers = [h for step in order for h in steps[step]()]
        assert [h.name for h in answers] == ["ERROR_2", "DAC_2"]


def test_dac_answers_in_its_cycle_and_only_once(bench: JointBench) -> None:
    for _ in range(300):  # the low byte wraps
        (dac,) = bench.dacs(bench.run())
        assert dac.cycle == bench.cycle & 0xFF
        assert bench.other_errors() == []


# --- whom it trusts ---------------------------------------------------------------------------


@pytest.mark.parametrize("enabled", [True, False])
def test_a_master_with_another_dbc_ends_torque_at_once(wire: Wire, enabled: bool) -> None:
    bench = JointBench(wire)
    if enabled:
        bench.enable()
    answers = bench.sync(dbc_hash=wire.dbc_hash ^ 0x1000)
    (emergency,) = bench.emergencies(answers)
    assert emergency.fault == FaultCode.DBC_MISMATCH
    assert emergency.value == wire.dbc_hash ^ 0x1000
    assert [dac.current_dac for dac in bench.dacs(answers)] == [0] * enabled
    assert bench.state is NodeState.FAULT
    cycle = bench.node.cycle
    assert bench.sync(dbc_hash=wire.dbc_hash ^ 0x1000) == []
    assert bench.node.cycle == cycle  # its cycles do not count


def test_a_node_that_has_not_booted_takes_no_offence_at_another_dbc(wire: Wire) -> None:
    node = JointNode(1, wire, 1)
    frame = wire.sender(Sync).frame(0, NodeState.PREOP, 0, wire.dbc_hash ^ 1)
    assert not node.on_frame(frame, 0)
    assert node.state is NodeState.INIT


def test_emergency_stop_ends_torque_at_once(bench: JointBench) -> None:
    answers = bench.say(Estop, None, *ESTOP_VALUES)
    assert [h.name for h in answers] == ["EMCY_2", "DAC_2"]
    assert [e.fault for e in bench.emergencies(answers)] == [FaultCode.EMERGENCY_STOP]
    assert bench.dacs(answers)[0].current_dac == 0
    assert bench.state is NodeState.FAULT
    assert bench.say(Estop, None, *ESTOP_VALUES) == []
    bench.run(5)
    assert bench.dacs()[-1] == bench.dacs(answers)[0]


def test_emergency_stop_latches_in_every_state(wire: Wire) -> None:
    for prepare in ("configure", "enable"):
        bench = JointBench(wire)
        getattr(bench, prepare)()
        bench.say(Estop, None, *ESTOP_VALUES)
        for command in (Command.HOME, Command.START, Command.STOP):
            bench.command(command)
            assert bench.node.ignored[f"{command.name} in FAULT"] == 1
        bench.command(Command.RESET)
        assert bench.state is NodeState.PREOP


def test_heartbeats_tell_state_hashes_and_what_was_discarded(bench: JointBench) -> None:
    bench.give(Frame(bench.wire.id(Sync), b"\0" * 12))
    bench.heard.clear()
    bench.run(24)
    beats = [h.values for h in bench.heard if h.name == "HEARTBEAT_2"]
    assert len(beats) == 2
    node = bench.node
    assert beats[-1] == (
        *(NodeState.OPERATIONAL, 0, 0, node.boot_id),
        *(bench.wire.dbc_hash, node.config_hash, 1, 0),
    )


def test_the_error_register_has_a_bit_for_each_fault(bench: JointBench) -> None:
    for faults, register in (
        ([], 0),
        ([FaultCode.SYNC_MISSING], 1 << 1 | 1),
        ([FaultCode.SETPOINT_MISSING, FaultCode.HOMING_FAILED], 1 << 2 | 1 << 10 | 1),
        (list(FaultCode)[1:], (1 << len(FaultCode)) - 1),
    ):
        bench.node.faults.clear()
        bench.node.faults.update(faults)
        assert bench.node.error_register == register

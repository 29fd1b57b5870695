"""A joint node by itself: its solution, its errors, and everything it must not take."""

import math
import random
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from nodes_rig import PERIOD_NS, Heard, JointBench

from rfms_can.arm import ARMS
from rfms_can.codec import load_database
from rfms_can.frame import FD_LENGTHS, Frame
from rfms_can.joint_nodes.joint import JointNode
from rfms_can.joint_nodes.ladder import Reaction
from rfms_can.kinematics import configuration_of, direct, inverse
from rfms_can.protection import Refusal
from rfms_can.transform import Transform
from rfms_can.wire import ESTOP_VALUES, JOINTS, MESSAGES, Wire
from rfms_can.wire.records import Config, Estop, Nmt, Setpoint, Sync
from rfms_can.wire.vocabulary import (
    Command,
    ConfigStatus,
    FaultCode,
    NodeState,
    Parameter,
)

PERIOD = PERIOD_NS * 1e-9


@pytest.fixture
def bench(wire: Wire) -> JointBench:
    return JointBench(wire).enable()


def step_limit(bench: JointBench) -> float:
    """Largest step of a set-point or a measurement, rad in one cycle."""
    return 1.5 * bench.parameters[Parameter.SPEED_LIMIT] * PERIOD


def code_of_one_cycle(bench: JointBench) -> int:
    (dac,) = bench.dacs(bench.run())
    return dac.current_dac


# --- own solution, own error -------------------------------------------------------------------


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("joint", JOINTS)
def test_own_solution_is_the_full_solution_of_the_t6_on_the_wire(
    wire: Wire, name: str, joint: int
) -> None:
    arm, rng = ARMS[name], random.Random(joint)
    bench = JointBench(wire, joint, arm).enable()
    codec = wire.codec(Setpoint, 1)
    for _ in range(40):
        bench.q = [q + rng.uniform(-0.6, 0.6) * step_limit(bench) for q in bench.q]
        bench.sync()
        answers = bench.setpoint() + bench.measure(bench.q[bench.index] - 0.001)
        bench.other_errors()
        (error,) = bench.errors(answers)
        values = codec.unpack(bytes(bench.sender(Setpoint, 1)._buffer))
        assert values is not None
        on_wire = Transform.from_o_a_p(values[0:3], values[3:6], values[6:9])
        full = inverse(arm, on_wire, configuration_of(arm, bench.q), bench.q)
        assert bench.node._trajectory.theta == pytest.approx(full[bench.index], abs=1e-12)
        assert bench.node._trajectory.theta == pytest.approx(bench.q[bench.index], abs=2e-6)
        assert error.error == pytest.approx(
            full[bench.index] - bench.angle(bench.q[bench.index] - 0.001), abs=1e-7
        )


def test_error_tells_error_rate_and_the_commanded_acceleration(bench: JointBench) -> None:
    """Along theta = 1/2 a t2 the rate is a t, less the speed measured, and the acceleration a."""
    start, a = bench.q[bench.index], 2.0
    for k in range(1, 60):
        t = k * PERIOD
        bench.q[bench.index] = start + 0.5 * a * t * t
        bench.speed = 0.3
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


# --- frames that are not taken -----------------------------------------------------------------


def test_stale_frames_are_ignored_and_counted(bench: JointBench) -> None:
    bench.sync()
    old = bench.cycle - 1
    assert bench.setpoint(cycle=old) == []
    assert bench.measure(cycle=old) == []
    assert bench.other_errors(cycle=old) == []
    ignored = bench.node.ignored
    assert (ignored["stale SETPOINT"], ignored["stale MEASURE"]) == (1, 1)
    assert ignored["stale ERROR"] == 5
    answers = bench.setpoint() + bench.measure() + bench.other_errors()
    assert [h.name for h in answers] == ["ERROR_2", "DAC_2"]


def _state_of(node: JointNode) -> tuple[Any, ...]:
    """What a refused frame must not change."""
    return (
        *(node.state, node.cycle, node.bus_state, node.reaction, node.theta, node.speed),
        *(node.torque, dict(node.parameters), node.config_hash, dict(node.faults)),
        *(node.rows.number, node.next_deadline_ns()),
    )


@pytest.mark.parametrize("spoil", ["bit", "short", "long", "classic", "repeated", "old"])
def test_refused_frames_are_counted_and_change_nothing(
    bench: JointBench, wire: Wire, spoil: str
) -> None:
    bench.run(3)
    node = bench.node
    for frame in _good_frames(bench, wire):
        refused, before = node.discarded, _state_of(node)
        if spoil == "bit":
            data = bytearray(frame.data)
            data[-1] ^= 0x10
            bad = [Frame(frame.id, bytes(data))]
        elif spoil == "short":
            bad = [Frame(frame.id, frame.data[:7])]
        elif spoil == "long":
            length = min((n for n in FD_LENGTHS if n > len(frame.data)), default=8)
            bad = [Frame(frame.id, frame.data[:length].ljust(length, b"\0"))]
        elif spoil == "classic":
            bad = [Frame(frame.id, frame.data[:8], fd=False)]
        elif frame.id in (wire.id(Nmt), wire.id(Estop)):
            continue  # constant, or heard from any master: no counter
        else:  # the counter stays, or goes back by one
            bench.give(frame)
            if spoil == "old":
                (later,) = [f for f in _good_frames(bench, wire) if f.id == frame.id]
                bench.give(later)
            before, refused = _state_of(node), node.discarded
            bad = [frame]
        assert bench.give(bad[0]) == []
        assert node.discarded == refused + 1
        assert _state_of(node) == before
    reasons = {"bit": Refusal.CRC, "short": Refusal.LENGTH, "long": Refusal.LENGTH}
    reasons |= {"classic": Refusal.KIND, "repeated": Refusal.DUPLICATE, "old": Refusal.ORDER}
    allowed = {reasons[spoil], Refusal.RANGE if spoil == "bit" else reasons[spoil]}
    assert set(node.refused) <= allowed


def _good_frames(bench: JointBench, wire: Wire) -> list[Frame]:
    """One good, harmless frame of everything the node hears."""
    frames = []
    for record, node in _heard_messages(bench.node, wire):
        values = dict.fromkeys(record._fields, 0)
        if record is Estop:
            values = ESTOP_VALUES._asdict()
        elif record is Sync:
            values = {**values, "cycle": bench.cycle, "dbc_hash": wire.dbc_hash}
            values |= {"state": NodeState.OPERATIONAL, "row_set": bench.row_set}
        elif record is Setpoint:
            values["poses"] = 1
        frames.append(bench.sender(record, node).frame(*values.values()))
    return frames


def _heard_messages(node: JointNode, wire: Wire) -> list[tuple[Any, int | None]]:
    by_id = {
        wire.id(record, n): (record, n)
        for record, template in MESSAGES.items()
        for n in ((None,) if "{}" not in template else range(1, 10))
        if template.format(n) in wire.codecs
    }
    return [by_id[identifier] for identifier in sorted(node.accepts)]


def test_frames_nobody_sent_us_are_not_even_counted(bench: JointBench) -> None:
    assert bench.node.on_frame(Frame(0x7FF, b""), 0) == ()
    assert bench.node.discarded == 0


# --- set-points and measurements out of bounds -------------------------------------------------


@pytest.mark.parametrize("step", [0.05, -0.05, 0.5, 1.0, -1.0])
def test_a_setpoint_step_beyond_the_speed_limit_is_refused_and_stops_the_joint(
    bench: JointBench, step: float
) -> None:
    bench.run(10)
    rest = code_of_one_cycle(bench)
    held = bench.q[bench.index]
    bench.sync()
    bench.setpoint([*bench.q[:1], held + step, *bench.q[2:]])
    assert bench.errors(bench.measure()) == []
    (emergency,) = bench.emergencies()
    assert emergency.fault == FaultCode.SETPOINT_STEP
    assert emergency.value == pytest.approx(step, abs=1e-5)
    assert bench.state is NodeState.QUICKSTOP
    for _ in range(50):  # and nothing of the step acts: the joint holds where it was
        bench.sync(NodeState.QUICKSTOP)
        (dac,) = bench.dacs(bench.measure())
        assert abs(dac.current_dac - rest) <= 1


def test_a_setpoint_as_fast_as_the_joint_may_run_is_taken(bench: JointBench) -> None:
    for sign in (1.0, -1.0):
        for _ in range(20):
            bench.q[bench.index] += sign * step_limit(bench) / 1.5
            assert bench.errors(bench.run())
    assert not bench.node.faults


@pytest.mark.parametrize("lost", [1, 2])
def test_setpoints_lost_at_full_speed_are_no_step(bench: JointBench, lost: int) -> None:
    for k in range(30):
        bench.q[bench.index] += step_limit(bench) / 1.5
        bench.speed = bench.parameters[Parameter.SPEED_LIMIT]
        if 10 <= k < 10 + lost:
            bench.sync()
            bench.measure()
            bench.other_errors()
        else:
            (error,) = bench.errors(bench.run())
            assert abs(error.acceleration) < 1.0 or k < 4
    assert set(bench.node.faults) == {FaultCode.SETPOINT_MISSING}


def test_setpoints_lost_before_a_new_start_excuse_no_step_after_it(bench: JointBench) -> None:
    for _ in range(2):
        bench.sync()
        bench.measure()
    bench.command(Command.STOP)
    bench.command(Command.START)
    bench.cycle = -1
    bench.sync()
    bench.measure()
    bench.setpoint([bench.q[0], bench.q[1] + 1.2 * step_limit(bench), *bench.q[2:]])
    assert bench.state is NodeState.QUICKSTOP


@pytest.mark.parametrize("lost", [1, 2])
def test_syncs_lost_at_full_speed_are_neither_step_nor_glitch(bench: JointBench, lost: int) -> None:
    for k in range(30):
        bench.q[bench.index] += step_limit(bench) / 1.5
        bench.speed = bench.parameters[Parameter.SPEED_LIMIT]
        if 10 <= k < 10 + lost:
            bench.sync(lost=True)
        else:
            (error,) = bench.errors(bench.run())
            assert abs(error.acceleration) < 1.0 or k < 4
    assert bench.state is NodeState.OPERATIONAL
    assert set(bench.node.faults) <= {FaultCode.SYNC_MISSING}


@pytest.mark.parametrize("lost", [1, 2])
def test_measurements_lost_at_full_speed_are_no_glitch(bench: JointBench, lost: int) -> None:
    for k in range(30):
        bench.q[bench.index] += step_limit(bench) / 1.5
        bench.speed = bench.parameters[Parameter.SPEED_LIMIT]
        if 10 <= k < 10 + lost:
            bench.sync()
            bench.setpoint()
            bench.other_errors()
        else:
            bench.run()
    assert set(bench.node.faults) == {FaultCode.MEASURE_MISSING}


def test_an_encoder_glitch_is_predicted_over(bench: JointBench) -> None:
    quiet = code_of_one_cycle(bench)
    for glitches in (1, 2):
        for _ in range(glitches):
            bench.sync()
            bench.setpoint()
            answers = bench.measure(bench.q[bench.index] + 0.3) + bench.other_errors()
            (dac,) = bench.dacs(answers)
            assert abs(dac.current_dac - quiet) <= 1
            assert abs(bench.errors(answers)[0].error) < 1e-3
        bench.run()
    assert bench.node.faults[FaultCode.ENCODER_GLITCH] == 3
    assert bench.state is NodeState.OPERATIONAL


def test_prediction_goes_on_at_the_measured_speed(bench: JointBench) -> None:
    bench.speed = 0.4
    bench.run()
    theta = bench.node.theta
    for k in (1, 2):
        bench.sync()
        bench.setpoint()
        bench.measure(3.0)
        assert bench.node.theta == pytest.approx(theta + k * bench.read_speed * PERIOD)


def test_an_encoder_that_stays_elsewhere_stops_the_joint_where_it_is(bench: JointBench) -> None:
    """What moved is the encoder, not the joint: no torque may try to bring it back."""
    bench.run(10)
    quiet = code_of_one_cycle(bench)
    elsewhere = bench.q[bench.index] + 0.3
    for k in range(40):
        bench.sync(NodeState.OPERATIONAL if k < 3 else NodeState.QUICKSTOP)
        bench.setpoint()
        for dac in bench.dacs(bench.measure(elsewhere) + bench.other_errors()):
            assert abs(dac.current_dac - quiet) <= 1
    assert bench.state is NodeState.QUICKSTOP
    assert [e.fault for e in bench.emergencies()] == [FaultCode.ENCODER_GLITCH]


# --- limits ------------------------------------------------------------------------------------


def near_limit(wire: Wire, upper: bool, inside: float) -> JointBench:
    """A joint enabled near an end of its range."""
    bench = JointBench(wire)
    lower, upper_limit = bench.arm.joint_limits[bench.index]
    bench.q[bench.index] = upper_limit - inside if upper else lower + inside
    return bench.enable()


@pytest.mark.parametrize("upper", [True, False])
def test_beyond_the_range_torque_goes_off(wire: Wire, upper: bool) -> None:
    bench = near_limit(wire, upper, 0.005)
    outwards = 1.0 if upper else -1.0
    where = bench.q[bench.index]
    bench.run()
    while bench.state is NodeState.OPERATIONAL:
        where += outwards * 0.5 * step_limit(bench)
        bench.sync()
        bench.setpoint()
        bench.measure(where)
        bench.other_errors()
    (emergency,) = bench.emergencies()
    assert emergency.fault == FaultCode.HARD_LIMIT
    lower, upper_limit = bench.arm.joint_limits[bench.index]
    beyond = where - upper_limit if upper else lower - where
    assert 0.05 <= beyond <= 0.05 + step_limit(bench)
    assert bench.node.reaction is Reaction.OFF
    assert bench.dacs()[-1].current_dac == 0
    count = len(bench.dacs())
    bench.run(5)
    assert len(bench.dacs()) == count


@pytest.mark.parametrize("upper", [True, False])
def test_too_fast_towards_the_end_of_the_range_stops_in_time(wire: Wire, upper: bool) -> None:
    inside = 0.1
    bench = near_limit(wire, upper, inside)
    deceleration = bench.parameters[Parameter.ACCELERATION_LIMIT]
    fast = math.sqrt(2.0 * deceleration * (inside + 0.05))
    assert fast < bench.parameters[Parameter.SPEED_LIMIT]
    outwards = 1.0 if upper else -1.0
    bench.speed = 0.95 * fast * outwards
    bench.run()
    bench.speed = 1.05 * fast * -outwards  # away from the end: as fast as it likes
    assert len(bench.dacs(bench.run())) == 1
    bench.speed = 1.05 * fast * outwards
    bench.run()
    assert [e.fault for e in bench.emergencies()] == [FaultCode.SOFT_LIMIT]
    assert bench.state is NodeState.QUICKSTOP


@pytest.mark.parametrize("upper", [True, False])
def test_a_controlled_stop_ends_inside_the_range(wire: Wire, upper: bool) -> None:
    """A motion that would have slowed down for its goal, and is stopped before it did."""
    bench = near_limit(wire, upper, 0.2)
    outwards = 1.0 if upper else -1.0
    speed = 0.9 * bench.parameters[Parameter.SPEED_LIMIT]
    for _ in range(int(0.18 / (speed * PERIOD))):
        bench.q[bench.index] += outwards * speed * PERIOD
        bench.run()
    assert bench.state is NodeState.OPERATIONAL
    bench.command(Command.QUICKSTOP)
    ramp = bench.node._ramp
    assert ramp is not None
    assert abs(ramp.speed) == pytest.approx(speed, rel=0.01)
    while ramp.speed:
        ramp.step()
    lower, upper_limit = bench.arm.joint_limits[bench.index]
    assert lower - 1e-3 <= ramp.position <= upper_limit + 1e-3


def test_a_stopped_joint_pushed_out_of_its_range_goes_off(wire: Wire) -> None:
    bench = near_limit(wire, True, 0.02)
    bench.command(Command.QUICKSTOP)
    where = bench.q[bench.index]
    for _ in range(30):
        where += 0.3 * step_limit(bench)
        bench.sync(NodeState.QUICKSTOP)
        bench.measure(where)
    assert [e.fault for e in bench.emergencies()] == [FaultCode.HARD_LIMIT]
    assert bench.dacs()[-1].current_dac == 0


# --- configuration -----------------------------------------------------------------------------


def test_each_parameter_is_acknowledged_with_what_was_taken(wire: Wire) -> None:
    bench = JointBench(wire)
    (answer,) = bench.say(Config, 2, Parameter.KP, 0, 0.1, 0)
    assert answer.name == "CONFIG_ACK_2"
    assert answer.values == (Parameter.KP, ConfigStatus.TAKEN, bench.wire_value(0.1), 0)


def test_unknown_parameters_are_refused_by_number(wire: Wire) -> None:
    bench = JointBench(wire)
    (answer,) = bench.say(Config, 2, 200, 0, 1.0, 0)
    assert answer.values[:2] == (200, ConfigStatus.UNKNOWN)
    assert not bench.node.parameters


@pytest.mark.parametrize("change", ["hash", "total", "missing", "arm", "value"])
def test_a_configuration_that_does_not_hold_together_is_refused(wire: Wire, change: str) -> None:
    bench = JointBench(wire)
    if change == "arm":
        bench.parameters[Parameter.ARM_ID] = 261.0
    if change == "value":
        bench.parameters[Parameter.COUNTS_PER_UNIT] = 0.0
    if change == "missing":
        del bench.parameters[Parameter.KD]
    for parameter, value in bench.parameters.items():
        bench.say(Config, 2, parameter, 0, value, 0)
    (answer,) = bench.commit(
        total=3 if change == "total" else None, digest=7 if change == "hash" else None
    )
    assert answer.values.status == ConfigStatus.WRONG_HASH
    bench.command(Command.HOME)
    assert bench.state is NodeState.PREOP
    assert bench.node.ignored["HOME without configuration"] == 1


@pytest.mark.parametrize(
    ("parameter", "value"),
    [
        (Parameter.PERIOD, 0.0),
        (Parameter.TORQUE_LIMIT, 0.0),
        (Parameter.SPEED_LIMIT, -1.0),
        (Parameter.ACCELERATION_LIMIT, 0.0),
        (Parameter.INDEX_INTERVAL_COUNTS, 0.4),
        (Parameter.COUNTS_PER_UNIT, 0.0),
        (Parameter.TORQUE_PER_CODE, 0.0),
    ],
)
def test_scales_nothing_can_be_divided_by_are_refused(
    wire: Wire, parameter: Parameter, value: float
) -> None:
    bench = JointBench(wire, changes={parameter: value})
    for known, number in bench.parameters.items():
        bench.say(Config, 2, known, 0, number, 0)
    (answer,) = bench.commit()
    assert answer.values.status == ConfigStatus.WRONG_HASH


def test_an_enabled_joint_takes_no_configuration(bench: JointBench) -> None:
    (answer,) = bench.say(Config, 2, Parameter.KP, 0, 1.0, 0)
    assert answer.values.status == ConfigStatus.REFUSED_STATE
    assert bench.node.parameters[Parameter.KP] == bench.wire_value(bench.parameters[Parameter.KP])


def test_changed_parameters_need_a_new_hash_before_homing(wire: Wire) -> None:
    bench = JointBench(wire)
    bench.configure()
    bench.say(Config, 2, Parameter.KP, 0, 1.0, 0)
    bench.command(Command.HOME)
    assert bench.state is NodeState.PREOP
    bench.configure()
    bench.home()


def test_start_for_another_configuration_is_ignored(wire: Wire) -> None:
    bench = JointBench(wire)
    bench.configure()
    bench.home()
    digest = bench.node.config_hash
    bench.command(Command.START, argument=digest ^ 1)
    assert bench.node.ignored["START for another configuration"] == 1
    bench.command(Command.START, argument=digest)
    assert bench.state is NodeState.OPERATIONAL


# --- whom it trusts ----------------------------------------------------------------------------


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
    node = JointNode(1, wire, 1, PERIOD_NS)
    frame = wire.sender(Sync).frame(0, NodeState.PREOP, 0, wire.dbc_hash ^ 1)
    assert not node.on_frame(frame, 0)
    assert node.state is NodeState.INIT


def test_emergency_stop_ends_torque_at_once(bench: JointBench) -> None:
    answers = bench.say(Estop, None, *ESTOP_VALUES)
    assert [h.name for h in answers] == ["EMCY_2", "DAC_2"]
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
        *(NodeState.OPERATIONAL, 0, node.boot_id),
        *(bench.wire.dbc_hash, node.config_hash, 1),
    )


def test_the_error_register_names_the_class_of_every_fault(bench: JointBench) -> None:
    for faults, register in (
        ([], 0),
        ([FaultCode.SYNC_MISSING], 1 << 3 | 1),
        ([FaultCode.LOST_FRAME, FaultCode.HOMING_FAILED], 1 << 2 | 1),  # 1 and 16 share a class
        (list(FaultCode)[1:], 0xFFFF),
    ):
        bench.node.faults.clear()
        bench.node.faults.update(faults)
        assert bench.node.register == register


# --- whatever comes ----------------------------------------------------------------------------

STATES = ("boot", "preop", "homing", "ready", "operational", "quickstop", "damped", "fault")


def node_in(state: str, wire: Wire) -> JointBench:
    bench = JointBench(wire)
    if state == "boot":
        bench.field_node = bench.node = JointNode(2, wire, 1, PERIOD_NS)
    elif state in ("homing", "ready"):
        bench.configure()
        bench.command(Command.HOME)
        if state == "ready":
            bench.home()
        bench.sync(NodeState.HOMING)
    elif state != "preop":
        bench.enable()
    if state == "quickstop":
        bench.command(Command.QUICKSTOP)
    if state in ("damped", "fault"):
        bench.miss_syncs(5 if state == "damped" else 30)
    return bench


@pytest.mark.parametrize("state", STATES)
@settings(max_examples=25)
@given(data=st.data())
def test_arbitrary_bytes_never_raise_and_change_nothing(
    state: str, wire: Wire, data: st.DataObject
) -> None:
    bench = node_in(state, wire)
    before = _state_of(bench.node)
    stop = wire.id(Estop)
    for _ in range(5):
        identifier = data.draw(st.sampled_from(sorted(bench.node.accepts - {stop})))
        length = data.draw(st.sampled_from(sorted(FD_LENGTHS)))
        payload = data.draw(st.binary(min_size=length, max_size=length))
        fd = length > 8 or data.draw(st.booleans())
        assert bench.give(Frame(identifier, payload, fd)) == []
    assert _state_of(bench.node) == before


@pytest.mark.parametrize("state", STATES)
@settings(max_examples=25)
@given(data=st.data())
def test_whole_frames_with_any_values_never_raise(
    state: str, wire: Wire, data: st.DataObject
) -> None:
    """A peer that keeps every rule of the wire and none of sense."""
    bench = node_in(state, wire)
    heard = _heard_messages(bench.node, wire)
    for _ in range(data.draw(st.integers(1, 12))):
        record, number = data.draw(st.sampled_from(heard))
        values = [_any_value(data, wire, record, number, field) for field in record._fields]
        if record is Sync:
            values[-1] = data.draw(st.sampled_from((wire.dbc_hash, 1)))
        if "cycle" in record._fields and record is not Sync and data.draw(st.booleans()):
            values[record._fields.index("cycle")] = max(bench.node.cycle, 0) & 0xFF
        bench.say(record, number, *values)
        bench.now_ns += data.draw(st.sampled_from((0, PERIOD_NS, 10 * PERIOD_NS)))
        bench.let_time_pass()


def _any_value(
    data: st.DataObject, wire: Wire, record: Any, number: int | None, field: str
) -> float:
    """Any value the DBC allows, its bounds and zero above all."""
    signal = _signal(wire.codec(record, number).name, field)
    low, high = signal.minimum, signal.maximum
    likely = st.sampled_from([low, high, min(max(0, low), high)])
    anything = (
        st.floats(low, high, width=32) if signal.is_float else st.integers(int(low), int(high))
    )
    value: float = data.draw(st.one_of(likely, anything))
    return value if signal.is_float else int(value)


def _signal(message: str, field: str) -> Any:
    return load_database().get_message_by_name(message).get_signal_by_name(field)


def test_solvers_of_all_joints_agree_where_the_arm_stands(wire: Wire) -> None:
    arm = ARMS["puma560"]
    told = []
    for joint in JOINTS:
        bench = JointBench(wire, joint, arm).enable()
        told.append(bench.node._trajectory.theta)
    assert direct(arm, told) == pytest.approx(direct(arm, arm.park), abs=1e-6)

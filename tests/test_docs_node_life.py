"""What docs/node.md says of the life of a joint beyond its tables, seen from the bus."""

import pytest
from node_book.pump import JOINT, Pump, parameters

from rfms_can.wire.contract import ESTOP_VALUES
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import MASTER
from rfms_can.wire.records import (
    Config,
    ConfigAck,
    Dac,
    Emcy,
    Estop,
    Heartbeat,
    JointError,
    Measure,
    Sync,
)
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState, Parameter

OPERATIONAL = NodeState.OPERATIONAL


@pytest.fixture
def pump() -> Pump:
    return Pump().enabled()


def names(pump: Pump, frames: list[Frame]) -> list[str]:
    by_id = {codec.id: codec.name.removesuffix(f"_{JOINT}") for codec in pump.wire.codecs.values()}
    return [by_id[frame.id] for frame in frames]


def counters(pump: Pump, record: type, since: int = 0) -> list[int]:
    identifier = pump.wire.id(record, JOINT)
    return [f.data[2] for f, own in pump.passed[since:] if own and f.id == identifier]


def test_start_sets_the_counters_of_all_frames_back_and_reset_none() -> None:
    pump = Pump()
    pump.introduce()
    pump.command(Command.ANNOUNCE)
    pump.command(Command.RESET)
    pump.command(Command.ANNOUNCE)
    assert counters(pump, Heartbeat) == [0, 1, 2]
    pump.configure()
    pump.home()
    since = len(pump.passed)
    pump.command(Command.START)
    pump.run(2)
    assert counters(pump, Heartbeat, since) == [0]
    assert counters(pump, JointError, since) == counters(pump, Dac, since) == [0, 1]
    pump.command(Command.START)  # not taken in OPERATIONAL
    pump.run()
    assert counters(pump, Dac, since) == [0, 1, 2]


def test_a_frame_that_the_joint_does_not_hear_counts_nowhere(pump: Pump) -> None:
    before = pump.node.discarded
    assert pump.say(Heartbeat, 5, OPERATIONAL, 0, 0, 1, 2, 3, 4, 5) == []
    assert pump.say(Measure, 5, 0, 0, 0, 0, 0, 0) == []
    assert pump.node.discarded == before


def test_a_frame_of_another_cycle_is_ignored_and_not_discarded(pump: Pump) -> None:
    before = pump.node.discarded
    pump.sync(OPERATIONAL)
    assert pump.say(Measure, JOINT, 0, 0, 0, pump.low - 1 & 0xFF, 0, 0) == []
    assert pump.node.discarded == before


def test_error_goes_out_with_the_later_of_measure_and_setpoint_and_dac_with_the_sixth(
    pump: Pump,
) -> None:
    for first, second in ((pump.measure, pump.setpoint), (pump.setpoint, pump.measure)):
        pump.sync(OPERATIONAL)
        assert first() == []
        assert names(pump, second()) == ["ERROR"]
        assert names(pump, pump.other_errors()) == ["DAC"]
    pump.sync(OPERATIONAL)
    pump.measure()
    assert pump.other_errors() == []
    assert names(pump, pump.setpoint()) == ["ERROR", "DAC"]


def test_a_quickstop_before_the_sixth_error_leaves_the_cycle_without_a_dac(pump: Pump) -> None:
    pump.sync(OPERATIONAL)
    pump.setpoint()
    pump.measure()
    pump.command(Command.QUICKSTOP)
    assert pump.other_errors() == []
    pump.sync(NodeState.QUICKSTOP)
    assert names(pump, pump.measure()) == ["DAC"]
    assert pump.node.state is NodeState.QUICKSTOP


def test_a_stop_that_the_sample_causes_sends_its_first_dac_at_once(pump: Pump) -> None:
    p = parameters()
    pump.sync(OPERATIONAL)
    beyond = round((p[Parameter.POSITION_MAX] + 0.04) * p[Parameter.COUNTS_PER_UNIT])
    zero = pump.node.controller.sensing.encoder.zero_counts  # type: ignore[union-attr]
    pump.node.controller.sensing.theta = p[Parameter.POSITION_MAX] + 0.04  # type: ignore[union-attr]
    fast = round(1.0 / p[Parameter.RATE_PER_CODE])
    answers = pump.say(Measure, JOINT, beyond + (zero or 0), 0, fast, pump.low, 0, 0)
    assert names(pump, answers) == ["EMCY", "DAC"]
    assert pump.node.state is NodeState.QUICKSTOP


def test_reference_before_measure_is_not_taken() -> None:
    pump = Pump()
    pump.introduce()
    pump.configure()
    pump.command(Command.HOME)
    pump.sync(NodeState.HOMING)
    assert pump.reference() == []
    assert pump.measure() == []
    pump.sync(NodeState.HOMING)
    pump.measure()
    assert names(pump, pump.reference()) == ["DAC"]
    assert pump.node.state is NodeState.READY
    pump.sync(NodeState.READY)
    assert pump.measure() + pump.reference() == []


@pytest.mark.parametrize("state", ["PREOP", "READY", "OPERATIONAL"])
def test_estop_is_emcy_one_dac_and_silence_but_for_heartbeats(state: str) -> None:
    pump = Pump()
    pump.introduce()
    pump.configure()
    if state != "PREOP":
        pump.home()
    if state == "OPERATIONAL":
        pump.command(Command.START)
        pump.run()
    assert pump.node.state.name == state
    answers = pump.say(Estop, None, *ESTOP_VALUES)
    driven = state != "PREOP"  # a DAC would open the brake of a joint that is braked
    assert names(pump, answers) == ["EMCY", "DAC"] if driven else ["EMCY"]
    for answer in answers[1:]:
        dac = pump.wire.codec(Dac, JOINT).unpack(answer.data)
        assert dac is not None and dac[:2] == (0, 0)
    assert pump.say(Estop, None, *ESTOP_VALUES) == []
    heard = []
    for _ in range(24):
        heard += pump.sync(OPERATIONAL) + pump.setpoint() + pump.measure() + pump.other_errors()
    assert names(pump, heard) == ["HEARTBEAT"] * 2
    pump.command(Command.START)
    assert pump.node.state.name == "FAULT"
    pump.command(Command.RESET)
    assert pump.node.state.name == "PREOP"


def test_heartbeat_tells_homing_with_the_first_sync_after_home() -> None:
    pump = Pump()
    pump.introduce()
    pump.configure()
    pump.command(Command.HOME)
    (beat,) = pump.sync(NodeState.HOMING)
    values = pump.wire.codec(Heartbeat, JOINT).unpack(beat.data)
    assert values is not None
    assert values.state == NodeState.HOMING


def test_a_hold_is_in_the_error_register_and_in_no_emcy(pump: Pump) -> None:
    pump.sync(OPERATIONAL)
    pump.setpoint()
    pump.other_errors()
    since = len(pump.passed)
    pump.run()
    assert counters(pump, Emcy, since) == []
    assert pump.node.error_register == 1 << FaultCode.MEASURE_MISSING | 1
    assert pump.node.state is OPERATIONAL


def test_a_sync_of_another_layout_is_a_fault_once_and_no_cycle(pump: Pump) -> None:
    wrong = (OPERATIONAL, 0, pump.wire.dbc_hash ^ 1)
    assert names(pump, pump.say(Sync, None, 12, *wrong)) == ["EMCY", "DAC"]
    assert pump.say(Sync, None, 24, *wrong) == []


def test_a_refused_parameter_after_commit_leaves_the_set_in_force() -> None:
    pump = Pump()
    pump.introduce()
    pump.configure()
    digest = pump.node.config_hash
    assert digest
    for parameter, value in ((200, 1.0), (Parameter.PERIOD, 0.0)):
        (answer,) = pump.say(Config, JOINT, parameter, 0, value, 0)
        values = pump.wire.codec(ConfigAck, JOINT).unpack(answer.data)
        assert values is not None and values.value == value and values.hash == 0
        assert pump.node.config_hash == digest
    pump.say(Config, JOINT, Parameter.KP, 0, 1.0, 0)
    assert pump.node.config_hash == 0


@pytest.mark.parametrize("driven", [True, False])
def test_another_boot_id_of_the_master_resets_its_frames_unless_one_drives(driven: bool) -> None:
    pump = Pump().enabled()
    if not driven:
        pump.command(Command.STOP)
        pump.sync(NodeState.READY)
    values = (NodeState.PREOP, 0, 0, 0xB, pump.wire.dbc_hash, 0, 0, 0)
    pump.give(pump.wire.sender(Heartbeat, MASTER).frame(*values))
    pump.give(pump.wire.sender(Heartbeat, MASTER).frame(*values))
    fresh = Pump()
    fresh.command(Command.ANNOUNCE)
    announce = fresh.passed[-2].frame  # counter 0, of a master that has just started
    for _ in range(40):
        pump.command(Command.ANNOUNCE)
    pump.give(pump.wire.sender(Heartbeat, MASTER).frame(*(*values[:3], 0xC, *values[4:])))
    assert bool(pump.give(announce)) is not driven

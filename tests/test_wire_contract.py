"""The DBC against the protocol it writes down, and the code against the DBC."""

import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any, Final

import cantools
import pytest
from cantools.database.can import Message
from e2e.p05 import e2e_p05_protect
from support.wire_messages import MESSAGES, every_message, kind_of, node_of, payload_of

from rfms_can.wire.codec import HEADER_SIGNALS, database_hash, database_path, load_database
from rfms_can.wire.contract import ESTOP_VALUES, Wire
from rfms_can.wire.contract import MESSAGES as RECORDS
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import (
    BOARDS,
    FORCE_SENSOR,
    GRIPPER,
    HEARTBEAT_EVERY,
    JOINTS,
    MASTER,
    NODE_NAMES,
    PLANT,
)
from rfms_can.wire.records import Sync

ROOT = Path(__file__).parents[1]
DATABASE = load_database()
CYCLE_MS: Final = 4  # GenMsgCycleTime is written for the default 250 Hz

EVENT: Final = 0
CYCLE: Final = 1


NODES: Final = {
    **{n: f"JOINT_{n}" for n in JOINTS},
    GRIPPER: "GRIPPER",
    MASTER: "MASTER",
    PLANT: "PLANT",
    FORCE_SENSOR: "FORCE_SENSOR",
    **{board: f"BOARD_{driven}" for driven, board in BOARDS.items()},
}


def protocol() -> dict[str, tuple[int, int, list[str], int]]:
    """The frame map of the protocol: identifier, bytes, senders, period in cycles."""
    driven = (*JOINTS, GRIPPER)
    master = ["MASTER"]

    def boards(n: int) -> list[str]:
        """Who may be configured to send the samples of a joint."""
        return ["PLANT", NODES[n], NODES[BOARDS[n]]]

    return {
        "NMT": (0x001, 8, master, EVENT),
        "SYNC": (0x080, 12, master, CYCLE),
        **{f"EMCY_{n}": (0x080 + n, 20, [NODES[n]], EVENT) for n in NODES},
        **{f"MEASURE_{n}": (0x100 + n, 12, boards(n), CYCLE) for n in driven},
        "FORCE": (0x110, 32, ["PLANT", "FORCE_SENSOR"], CYCLE),
        "SETPOINT_1": (0x140, 64, master, CYCLE),
        "SETPOINT_2": (0x141, 64, master, CYCLE),
        "COMPLY": (0x142, 32, master, CYCLE),
        "JOINT_SETPOINT_1": (0x144, 32, master, CYCLE),
        "JOINT_SETPOINT_2": (0x145, 32, master, CYCLE),
        "BIAS": (0x148, 32, master, CYCLE),
        "GRIPPER": (0x150, 8, master, 50 // CYCLE_MS),
        **{f"REFERENCE_{n}": (0x180 + n, 12, boards(n), EVENT) for n in driven},
        **{f"ERROR_{n}": (0x200 + n, 16, [NODES[n]], CYCLE) for n in JOINTS},
        **{f"DAC_{n}": (0x280 + n, 8, [NODES[n]], CYCLE) for n in driven},
        **{f"POSITION_{n}": (0x290 + n, 16, [NODES[n]], CYCLE) for n in driven},
        **{f"ROWS_{n}": (0x300 + n, 64, master, CYCLE) for n in JOINTS},
        **{f"CONFIG_{n}": (0x500 + n, 12, master, EVENT) for n in driven},
        **{f"CONFIG_ACK_{n}": (0x580 + n, 12, [NODES[n]], EVENT) for n in driven},
        **{f"HEARTBEAT_{n}": (0x700 + n, 20, [NODES[n]], HEARTBEAT_EVERY) for n in NODES},
    }


WHEN_USED: Final = {
    *("SETPOINT_2", "COMPLY", "BIAS", "FORCE", "JOINT_SETPOINT_1", "JOINT_SETPOINT_2"),
    *(f"POSITION_{n}" for n in (*JOINTS, GRIPPER)),
}
"""Sent every cycle, but only while the state, the program or a sensor needs them."""


def attributes_of(message: Message) -> dict[str, Any]:
    return {name: attribute.value for name, attribute in message.dbc.attributes.items()}


def facts(message: Message) -> dict[str, Any]:
    """Everything of a message that two nodes must agree on."""
    return {
        "message": (message.name, message.frame_id, message.length, message.comment),
        "senders": sorted(message.senders),
        # cantools leaves a cycle time of 0, the default, out of its text
        "attributes": {"GenMsgCycleTime": 0, **attributes_of(message)},
        "signals": [
            (
                *(s.name, s.start, s.length, s.byte_order, s.is_signed, s.is_float, s.unit),
                *(s.conversion.scale, s.conversion.offset, s.minimum, s.maximum, s.raw_initial),
                *(s.comment, sorted(s.receivers), s.choices and dict(s.choices)),
            )
            for s in message.signals
        ],
    }


# the frame map


def test_every_frame_of_the_protocol_is_there_and_no_other() -> None:
    assert {m.name for m in MESSAGES} == {"ESTOP", *protocol()}
    assert len({m.frame_id for m in MESSAGES}) == len(MESSAGES) == 99


@pytest.mark.parametrize("name", protocol())
def test_identifier_size_sender_and_period_are_the_protocols(wire: Wire, name: str) -> None:
    message = DATABASE.get_message_by_name(name)
    identifier, length, senders, every = protocol()[name]
    assert (message.frame_id, message.length) == (identifier, length)
    assert message.senders == senders
    assert attributes_of(message)["RfmsEvery"] == wire.codecs[name].every == every


def test_anyone_may_send_the_emergency_stop(wire: Wire) -> None:
    message = DATABASE.get_message_by_name("ESTOP")
    assert (message.frame_id, message.length) == (0x000, 8)
    nodes = {node.name for node in DATABASE.nodes}
    assert set(message.senders) == nodes == set(NODES.values())
    assert set(NODES) == set(NODE_NAMES)
    bounds = [(s.minimum, s.maximum, s.raw_initial) for s in message.signals]
    assert bounds == [(value, value, value) for value in ESTOP_VALUES]
    assert ESTOP_VALUES.code.to_bytes(4, "little") == b"STOP"
    assert ESTOP_VALUES.code ^ ESTOP_VALUES.inverse == 0xFFFFFFFF
    assert wire.codecs["ESTOP"].every == EVENT


@every_message
def test_nobody_hears_itself_and_somebody_hears_everything(message: Message) -> None:
    nodes = {node.name for node in DATABASE.nodes}
    for signal in message.signals:
        assert set(signal.receivers) <= nodes
        assert signal.receivers == message.signals[0].receivers
        assert signal.receivers
        if len(message.senders) == 1:
            assert message.senders[0] not in signal.receivers


# attributes


def test_the_bus_is_can_fd() -> None:
    assert DATABASE.dbc.attributes["BusType"].value == "CAN FD"


@every_message
def test_frame_format_and_timing_attributes_are_written_out(message: Message) -> None:
    attributes = attributes_of(message)
    formats = DATABASE.dbc.attribute_definitions["VFrameFormat"].choices
    assert formats[attributes["VFrameFormat"]] == "StandardCAN_FD"
    assert attributes["CANFD_BRS"] == 1
    assert message.is_fd
    assert attributes["GenMsgCycleTime"] == CYCLE_MS * attributes["RfmsEvery"]
    cyclic = attributes["RfmsEvery"] != EVENT and message.name not in WHEN_USED
    assert message.send_type == ("cyclic" if cyclic else "event")
    assert "GenMsgSendType" in attributes
    assert message.comment


@every_message
def test_all_but_the_emergency_stop_carry_profile_5(message: Message) -> None:
    attributes = attributes_of(message)
    profiles = DATABASE.dbc.attribute_definitions["RfmsE2EProfile"].choices
    header = [(s.name, s.start, s.length) for s in message.signals if s.name in HEADER_SIGNALS]
    if message.name == "ESTOP":
        assert profiles[attributes["RfmsE2EProfile"]] == "None"
        assert "RfmsE2EDataId" not in attributes
        assert header == []
        # nothing but its ranges protects it, so that no bit may be left unsaid
        assert sum(s.length for s in message.signals) == 8 * message.length
    else:
        assert profiles[attributes["RfmsE2EProfile"]] == "Profile5"
        assert attributes["RfmsE2EDataId"] > 0
        assert header == [("e2e_crc", 0, 16), ("e2e_counter", 16, 8)]


def test_data_ids_are_unique() -> None:
    ids = [attributes_of(m)["RfmsE2EDataId"] for m in MESSAGES if m.name != "ESTOP"]
    assert len(set(ids)) == len(ids) == 98


# the code against the DBC


def test_every_message_has_a_record_and_every_record_a_message(wire: Wire) -> None:
    assert set(wire.codecs) == {m.name for m in MESSAGES}
    kinds = {template.removesuffix("_{}"): record for record, template in RECORDS.items()}
    assert set(kinds) == {kind_of(m) for m in MESSAGES}
    for message in MESSAGES:
        record = kinds[kind_of(message)]
        assert record._fields == tuple(s.name for s in payload_of(message))
        codec = wire.codec(record, node_of(message))
        assert (codec.name, codec.id, codec.length) == (
            message.name,
            message.frame_id,
            message.length,
        )
        assert codec.data_id == attributes_of(message).get("RfmsE2EDataId")
        assert wire.id(record, node_of(message)) == message.frame_id


@pytest.mark.parametrize("name", ["ERROR_3", "DAC_7", "CONFIG_ACK_1", "HEARTBEAT_9"])
def test_what_a_node_answers_has_a_response_time(name: str) -> None:
    """Microseconds after what the message's comment names."""
    message = DATABASE.get_message_by_name(name)
    response_us = attributes_of(message)["RfmsResponseTime"]
    cyclic = name.startswith(("ERROR", "DAC"))
    assert 0 < response_us <= (CYCLE_MS * 1000 / 4 if cyclic else 100_000)
    assert "RfmsResponseTime of" in message.comment


def test_reserved_bits_are_sent_as_0_and_taken_whatever_they_are(wire: Wire) -> None:
    codec = wire.codec(Sync)
    frame = wire.sender(Sync).frame(7, 4, 1, 2)
    assert codec.unpack(frame.data) == Sync(7, 4, 1, 2, 0)
    later = bytearray(frame.data)
    later[-1] = 0x5A
    assert codec.data_id is not None
    e2e_p05_protect(later, codec.data_id, increment_counter=False)
    assert wire.receiver(Sync).take(Frame(frame.id, bytes(later))) == Sync(7, 4, 1, 2, 0x5A)


# the template and the generated C


def test_the_file_and_the_header_are_what_the_template_makes() -> None:
    tool = ROOT / "tools" / "make_dbc.py"
    done = subprocess.run(
        [sys.executable, str(tool), "--check"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("node", [None, "JOINT_3"])
def test_generated_c_compiles_without_a_warning(tmp_path: Path, node: str | None) -> None:
    """What a firmware developer does first; gcc is asked to be as strict as it can."""
    if shutil.which("gcc") is None:
        pytest.skip("no gcc on this machine: apt-get install gcc libc6-dev")
    generate = [sys.executable, "-m", "cantools", "generate_c_source", "--database-name", "rfms"]
    generate += ["--node", node] if node else []
    subprocess.run([*generate, str(database_path())], cwd=tmp_path, check=True, capture_output=True)
    (tmp_path / "all.c").write_text(
        '#include "rfms.c"\n#include "rfms_wire.h"\n'
        "int check[RFMS_SYNC_DATA_ID == RFMS_DATA_ID_BASE + RFMS_SYNC_FRAME_ID ? 1 : -1];\n"
    )
    strict = ["-std=c99", "-Wall", "-Wextra", "-Werror", f"-I{ROOT / 'dbc'}"]
    done = subprocess.run(
        ["gcc", *strict, "-c", "all.c"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


def test_no_signal_is_a_keyword_of_c() -> None:
    keywords = re.findall(
        r"\w+",
        "auto break case char const continue default do double else enum extern float for goto if "
        "inline int long register restrict return short signed sizeof static struct switch typedef "
        "union unsigned void volatile while",
    )
    assert len(keywords) == 34
    assert not set(keywords) & {s.name for m in MESSAGES for s in m.signals}


# the text


def test_the_text_is_plain_and_survives_cantools() -> None:
    text = database_path().read_bytes()
    assert text.isascii()
    assert b"\r" not in text
    again = cantools.database.load_string(DATABASE.as_dbc_string(), "dbc", strict=True)
    assert [facts(m) for m in again.messages] == [facts(m) for m in MESSAGES]
    assert [node.name for node in again.nodes] == [node.name for node in DATABASE.nodes]


def test_the_hash_on_the_wire_is_the_layouts(wire: Wire) -> None:
    signal = DATABASE.get_message_by_name("SYNC").get_signal_by_name("dbc_hash")
    assert signal.minimum <= wire.dbc_hash == database_hash() <= signal.maximum

"""Every signal says what it is, exactly; enumerations are the DBC's value tables."""

import json
import struct
from enum import IntEnum
from typing import Final

from cantools.database.can import Message
from support.wire_messages import MESSAGES, every_message, kind_of

from rfms_can.wire import vocabulary
from rfms_can.wire.frame import FD_LENGTHS, MAX_ID
from rfms_can.wire.nodes import JOINTS

ENUMERATIONS: Final[dict[tuple[str, str], type[IntEnum]]] = {
    ("NMT", "command"): vocabulary.Command,
    ("SYNC", "state"): vocabulary.NodeState,
    ("EMCY", "fault"): vocabulary.FaultCode,
    ("SETPOINT", "state"): vocabulary.TrajectoryState,
    ("SETPOINT", "mode"): vocabulary.Mode,
    ("SETPOINT", "blend"): vocabulary.Blend,
    ("GRIPPER", "command"): vocabulary.GripperCommand,
    ("ROWS", "law"): vocabulary.Law,
    ("CONFIG", "parameter"): vocabulary.Parameter,
    ("CONFIG_ACK", "parameter"): vocabulary.Parameter,
    ("CONFIG_ACK", "status"): vocabulary.ConfigStatus,
    ("HEARTBEAT", "state"): vocabulary.NodeState,
}
"""Enumeration of each signal that has a value table, by message kind."""

RESERVED: Final = {
    "command": 31,
    "fault": 39,
    "parameter": 255,
}
"""Greatest value that is reserved for an enumeration, where it is not 15; by signal."""
GRIPPER_RESERVED: Final = 15

WITHOUT_UNIT: Final = {
    *("o_x", "o_y", "o_z", "a_x", "a_y", "a_z", "r", "blend_p"),  # ratios
    *(f"law_{column}" for column in JOINTS),  # a projector's elements
    *("value", "bound"),  # their unit depends on the parameter or fault it belongs to
}
"""Floats that have no unit."""


@every_message
def test_identifier_and_length_exist_on_the_wire(message: Message) -> None:
    assert not message.is_extended_frame
    assert 0 <= message.frame_id <= MAX_ID
    assert message.length in FD_LENGTHS
    needed = max(s.start + s.length for s in message.signals)
    shorter = [length for length in FD_LENGTHS if 8 <= length < message.length]
    assert all(8 * length < needed for length in shorter), "a shorter frame would do"


@every_message
def test_signals_do_not_overlap_and_are_little_endian(message: Message) -> None:
    bits = [bit for s in message.signals for bit in range(s.start, s.start + s.length)]
    assert len(set(bits)) == len(bits)
    assert max(bits) < 8 * message.length
    assert {s.byte_order for s in message.signals} == {"little_endian"}
    assert not message.is_multiplexed()


@every_message
def test_every_signal_says_its_range_unit_and_meaning(message: Message) -> None:
    for signal in message.signals:
        assert signal.comment, signal.name
        assert signal.minimum is not None, signal.name
        assert signal.maximum is not None, signal.name
        start = 0 if signal.raw_initial is None else signal.raw_initial
        assert signal.minimum <= start <= signal.maximum, "the start value is out of range"
        if signal.is_float:
            assert bool(signal.unit) == (signal.name not in WITHOUT_UNIT), signal.name
        elif signal.unit:
            assert signal.unit in {"counts", "codes", "frames", "%"}, signal.name


@every_message
def test_bounds_are_exact_in_every_notation(message: Message) -> None:
    """As float32, as raw value, and as JSON number, so that no reader rounds one inward."""
    for signal in message.signals:
        for bound in (signal.minimum, signal.maximum):
            assert json.loads(json.dumps(bound)) == bound
            if signal.is_float:
                assert struct.unpack("<f", struct.pack("<f", bound))[0] == bound
            else:
                raw = signal.conversion.numeric_scaled_to_raw(bound)
                assert raw == int(raw)
                assert signal.conversion.raw_to_scaled(raw, decode_choices=False) == bound


def test_messages_of_one_kind_differ_in_node_only() -> None:
    kinds: dict[str, set[str]] = {}
    for message in MESSAGES:
        layout = [
            (s.name, s.start, s.length, s.is_signed, s.is_float, s.unit, s.minimum, s.maximum)
            for s in message.signals
        ]
        kinds.setdefault(kind_of(message), set()).add(json.dumps(layout))
    assert {kind: len(layouts) for kind, layouts in kinds.items() if len(layouts) > 1} == {}


@every_message
def test_enumerations_are_the_value_tables(message: Message) -> None:
    for signal in message.signals:
        key = (kind_of(message), signal.name)
        if key not in ENUMERATIONS:
            assert not signal.choices, f"no enumeration for {key}"
            continue
        values = ENUMERATIONS[key]
        assert {n: str(label) for n, label in signal.choices.items()} == {
            member.value: member.name for member in values
        }
        reserved = GRIPPER_RESERVED if key[0] == "GRIPPER" else RESERVED.get(signal.name, 15)
        assert (signal.minimum, signal.maximum) == (0, reserved)
        assert max(values) <= reserved


def test_every_enumeration_of_the_vocabulary_travels() -> None:
    defined = {
        value
        for value in vars(vocabulary).values()
        if isinstance(value, type) and issubclass(value, IntEnum) and value is not IntEnum
    }
    assert defined == set(ENUMERATIONS.values())

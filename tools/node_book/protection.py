"""Vectors of the CRC and of the counters."""

from typing import Any, Final

from generated import table

from node_book.printed import hex_bytes
from node_book.pump import JOINT, Pump
from rfms_can.wire.contract import ESTOP_VALUES, Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.protection import Sender
from rfms_can.wire.records import (
    ConfigAck,
    Dac,
    Emcy,
    Estop,
    Heartbeat,
    JointError,
    Measure,
    Nmt,
    Sync,
)
from rfms_can.wire.vocabulary import Command, ConfigStatus, FaultCode, NodeState, Parameter

CHECK: Final = b"123456789"

# the record, the number, the values, the counter
VECTORS: Final = (
    (Nmt, None, (Command.ANNOUNCE, 0, 0), 0),
    (Sync, None, (0, NodeState.OPERATIONAL, 0, 0x8B50), 0),
    (Sync, None, (0x01020304, NodeState.HOMING, 7, 0x8B50), 255),
    (Measure, JOINT, (-606, -212, -212, 0x3C, 0, 1), 60),
    (JointError, JOINT, (0.001, -0.02, 1.5, 206), 206),
    (Dac, JOINT, (-632, 5, 206), 206),
    (ConfigAck, JOINT, (Parameter.KP, ConfigStatus.TAKEN, 69.5, 0), 2),
    (Emcy, JOINT, (FaultCode.SYNC_MISSING, 8, 0x80, 3.0, 3.0, 0x3C, 0x3), 0),
    (Heartbeat, JOINT, (NodeState.READY, 0, 0, 0x5EED0003, 0x8B50, 0xC107, 2, 0), 7),
)


def crc(data: bytes) -> int:
    """CRC-16 bit by bit, as the page prints it."""
    value = 0xFFFF
    for byte in data:
        value ^= byte << 8
        for _ in range(8):
            value = (value << 1 ^ 0x1021 if value & 0x8000 else value << 1) & 0xFFFF
    return value


def frame_with(sender: Sender[Any], values: tuple[float, ...], counter: int) -> Frame:
    """The frame that a sender sends after ``counter`` others."""
    for _ in range(counter):
        sender.frame(*values)
    return sender.frame(*values)


def crc_vectors() -> str:
    """Frames of several messages, each with its data ID."""
    wire = Wire()
    rows = []
    for record, node, values, counter in VECTORS:
        codec = wire.codec(record, node)
        frame = frame_with(wire.sender(record, node), values, counter)
        assert codec.data_id is not None
        names = record._fields[: len(values)]
        fields = [f"{name} {_value(value)}" for name, value in zip(names, values, strict=True)]
        told = (codec.name, f"0x{codec.data_id:04X}", str(counter), ", ".join(fields))
        rows.append((*told, f"`{hex_bytes(frame.data)}`"))
    estop = hex_bytes(wire.sender(Estop).frame(*ESTOP_VALUES).data)
    rows.append(("ESTOP", "none", "none", "the letters STOP, then their complement", f"`{estop}`"))
    return table(("message", "data ID", "counter", "values", "bytes of the frame"), rows)


def _value(value: float) -> str:
    if isinstance(value, float):
        return f"{value:g}"
    return f"0x{value:X}" if value > 0x7FFF else str(int(value))


STREAM: Final = (
    *(200, 203, 203, 202, 219, 236, 5, 6, 8, 10, 11),
    *(100, 101, 120, 121, 122, 200, 201, 202, 203, 204, 205),
)
"""Counters of NMT ANNOUNCE as they come in."""


def counter_vectors() -> str:
    """A stream of counters, and what becomes of each frame."""
    pump = Pump()
    since = pump.node.discarded
    rows = []
    for counter in STREAM:
        wire = pump.wire
        frame = frame_with(wire.sender(Nmt), (Command.ANNOUNCE, 0, 0), counter)
        taken = bool(pump.give(frame))
        reasons = {reason.value: count for reason, count in pump.node.refused.items()}
        rows.append((counter, taken, sum(reasons.values()) - since, dict(reasons)))
    lines = []
    before: dict[str, int] = {}
    for counter, taken, discarded, reasons in rows:
        new = [reason for reason, count in reasons.items() if count != before.get(reason, 0)]
        before = reasons
        lines.append((str(counter), "taken" if taken else "refused: " + new[0], str(discarded)))
    return table(("counter", "NMT ANNOUNCE is", "discarded so far"), lines)

"""How the pages print frames and numbers."""

import struct
from typing import Any, Final

from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.vocabulary import (
    Command,
    ConfigStatus,
    FaultCode,
    NodeState,
    Parameter,
    name_of,
)

_NAMED: Final = {
    ("NMT", "command"): Command,
    ("SYNC", "state"): NodeState,
    ("EMCY", "fault"): FaultCode,
    ("CONFIG", "parameter"): Parameter,
    ("CONFIG_ACK", "parameter"): Parameter,
    ("CONFIG_ACK", "status"): ConfigStatus,
    ("HEARTBEAT", "state"): NodeState,
}
"""Signals printed by name."""
_HEX: Final = ("dbc_hash", "config_hash", "boot_id", "hash", "error_register", "frame")
_SILENT: Final = ("reserved",)
MOST_VALUES: Final = 6
"""Values of a frame that are printed in words."""


def hex_bytes(data: bytes) -> str:
    """Bytes as candump prints them."""
    return data.hex(" ").upper()


def float32_hex(value: float) -> str:
    """The four bytes of a float32 as they travel."""
    return struct.pack("<f", value).hex(" ").upper()


def as_float32(value: float) -> float:
    """What arrives of a number."""
    (rounded,) = struct.unpack("<f", struct.pack("<f", value))
    return float(rounded)


def number(value: float, digits: int = 12) -> str:
    """A number to so many digits, without a sign on zero."""
    text = f"{value:.{digits}g}"
    return "0" if float(text) == 0.0 else text


def candump(frame: Frame) -> str:
    """The line candump prints, without the interface."""
    size = f"[{len(frame.data):02d}]" if frame.fd else f"[{len(frame.data)}]"
    return f"{frame.id:03X}  {size}  {hex_bytes(frame.data)}"


def _kind(name: str) -> str:
    head, _, last = name.rpartition("_")
    return head if last.isdigit() else name


def in_words(wire: Wire, frame: Frame) -> str:
    """The message and its values, those that are 0 left out."""
    codec = next(codec for codec in wire.codecs.values() if codec.id == frame.id)
    values: Any = codec.unpack(frame.data)
    said = []
    for field, value in zip(values._fields, values, strict=True):
        kind = _NAMED.get((_kind(codec.name), field))
        if kind is not None:
            said.append(f"{field} {name_of(kind, value)}")
        elif value and field not in _SILENT:
            shown = f"0x{value:x}" if field in _HEX else number(value, 6)
            said.append(f"{field} {shown}")
    if len(said) > MOST_VALUES:
        said[MOST_VALUES:] = ["..."]
    return f"{codec.name}: {', '.join(said)}" if said else codec.name

"""Frames to fields and back, by a parser of its own for ``dbc/rfms.dbc``.

It knows just what this DBC has: little-endian signals, scale 1, offset 0.
"""

import re
import struct
from pathlib import Path
from typing import Any

DBC = Path(__file__).resolve().parents[2] / "dbc" / "rfms.dbc"

Fields = dict[str, Any]
"""Signals by name: whole numbers and floats."""
CanFrame = tuple[int, bytes]
"""Identifier and payload."""

MESSAGE = re.compile(r"^BO_ (\d+) (\w+): (\d+) (\w+)")
SIGNAL = re.compile(r"^ SG_ (\w+) : (\d+)\|(\d+)@1([+-]) \(1,0\) \[([^|]*)\|([^\]]*)\]")
FLOAT = re.compile(r"^SIG_VALTYPE_ (\d+) (\w+) : 1;")
NAMES = re.compile(r"^VAL_ (\d+) (\w+) (.*);")
TAKES_UNKNOWN = re.compile(r'^BA_ "RfmsUnknownValue" SG_ (\d+) (\w+) 1;')
HASH = re.compile(r'^BA_ "RfmsDbcHash" (\d+);')


class Signal:
    """One signal: its bits, its range, its names."""

    def __init__(
        self, name: str, start: int, length: int, signed: bool, low: float, high: float
    ) -> None:
        self.name = name
        self.start = start
        self.length = length
        self.signed = signed
        self.low = low
        self.high = high
        self.is_float = False
        self.names: dict[int, str] | None = None  # of an enumeration
        self.takes_unknown = False  # a value without a name is no fault

    def takes(self, value: float) -> bool:
        """Whether a value is in its range; NaN and infinity fail the comparison by themselves."""
        if self.name == "reserved":
            return True
        if not self.low <= value <= self.high:
            return False
        return self.names is None or self.takes_unknown or value in self.names


class Message:
    """One message: identifier, length in bytes, signals."""

    def __init__(self, can_id: int, name: str, length: int) -> None:
        self.can_id = can_id
        self.name = name
        self.length = length
        self.signals: dict[str, Signal] = {}


def number(text: str) -> float:
    """A number of the DBC."""
    return int(text) if re.fullmatch(r"-?\d+", text) else float(text)


def read_dbc(path: Path = DBC) -> tuple[dict[int, Message], int]:
    """The messages by identifier, and the hash of the layout."""
    messages: dict[int, Message] = {}
    current = Message(-1, "", 0)
    layout_hash = 0
    for line in path.read_text(encoding="utf-8").splitlines():
        if found := MESSAGE.match(line):
            current = Message(int(found[1]), found[2], int(found[3]))
            messages[current.can_id] = current
        elif found := SIGNAL.match(line):
            place = (int(found[2]), int(found[3]), found[4] == "-")
            signal = Signal(found[1], *place, number(found[5]), number(found[6]))
            current.signals[signal.name] = signal
        elif found := FLOAT.match(line):
            messages[int(found[1])].signals[found[2]].is_float = True
        elif found := NAMES.match(line):
            pairs = re.findall(r'(\d+) "([^"]*)"', found[3])
            messages[int(found[1])].signals[found[2]].names = {int(v): n for v, n in pairs}
        elif found := TAKES_UNKNOWN.match(line):
            messages[int(found[1])].signals[found[2]].takes_unknown = True
        elif found := HASH.match(line):
            layout_hash = int(found[1])
    return messages, layout_hash


MESSAGES, DBC_HASH = read_dbc()


def unpack(can_id: int, data: bytes) -> Fields:
    """The fields of a frame, as they are: ranges are not looked at."""
    bits = int.from_bytes(data, "little")
    fields: Fields = {}
    for signal in MESSAGES[can_id].signals.values():
        raw = (bits >> signal.start) & ((1 << signal.length) - 1)
        if signal.is_float:
            fields[signal.name] = struct.unpack("<f", raw.to_bytes(4, "little"))[0]
        elif signal.signed and raw >> (signal.length - 1):
            fields[signal.name] = raw - (1 << signal.length)
        else:
            fields[signal.name] = raw
    return fields


def pack(can_id: int, fields: Fields) -> bytes:
    """The bytes of a frame; fields left out are 0. Counter and CRC come later."""
    message = MESSAGES[can_id]
    bits = 0
    for signal in message.signals.values():
        value = fields.get(signal.name, 0)
        if signal.is_float:
            raw = int.from_bytes(struct.pack("<f", value), "little")
        else:
            raw = int(value) & ((1 << signal.length) - 1)
        bits |= raw << signal.start
    return bits.to_bytes(message.length, "little")


def in_range(can_id: int, fields: Fields) -> bool:
    """Whether all fields of a frame are in their ranges."""
    signals = MESSAGES[can_id].signals
    return all(signal.takes(fields[name]) for name, signal in signals.items())


def float32(value: float) -> float:
    """A number as it travels: rounded to binary32."""
    rounded: float = struct.unpack("<f", struct.pack("<f", value))[0]
    return rounded

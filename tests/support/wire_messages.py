"""What the tests of the wire share: every message, values for it, and cantools' word on it."""

import struct
from typing import Any, Final

import pytest
from cantools.database.can import Message, Signal

from rfms_can.wire.codec import HEADER_SIGNALS, MessageCodec, load_database
from rfms_can.wire.frame import Frame
from rfms_can.wire.protection import Sender

MESSAGES: Final[list[Message]] = load_database().messages
PROTECTED: Final = [m.name for m in MESSAGES if "RfmsE2EDataId" in m.dbc.attributes]

HEADER: Final = {"e2e_crc": 0xBEEF, "e2e_counter": 0x5A}
"""Any header: the codec must leave it alone."""

every_message = pytest.mark.parametrize("message", MESSAGES, ids=lambda message: message.name)
every_protected_message = pytest.mark.parametrize("name", PROTECTED)


def payload_of(message: Message) -> list[Signal]:
    """The signals behind the end-to-end header."""
    return [signal for signal in message.signals if signal.name not in HEADER_SIGNALS]


def kind_of(message: Message) -> str:
    """The message's name without its node."""
    stem, _, node = str(message.name).rpartition("_")
    return stem if node.isdigit() else str(message.name)


def node_of(message: Message) -> int | None:
    """The node (or pose) in the message's name."""
    node = message.name.rpartition("_")[2]
    return int(node) if node.isdigit() else None


def quiet_values(message: Message) -> dict[str, float]:
    """For each signal the value in its range that lies nearest to zero."""
    return {s.name: min(max(0, s.minimum), s.maximum) for s in payload_of(message)}


def known_of(signal: Signal) -> tuple[int, ...]:
    """Values of an enumeration that may travel; empty where all of its range may.

    Written down here once more, by hand: a node answers UNKNOWN to a parameter that it does not
    know, and tells of a fault or refusal that only a later version names; all else it refuses.
    """
    if signal.name in ("fault", "parameter", "status"):
        return ()
    return tuple(sorted(signal.choices or ()))


def is_taken(signal: Signal, value: float) -> bool:
    """Whether a receiver takes a value of a signal."""
    known = known_of(signal)
    return bool(signal.minimum <= value <= signal.maximum) and (not known or value in known)


def some_values(codec: MessageCodec[Any]) -> list[float]:
    """A value for each signal, neither zero nor a bound where the range allows it."""
    message = load_database().get_message_by_name(codec.name)
    return [
        s.minimum + (s.maximum - s.minimum) * 0.37
        if s.is_float
        else max(known_of(s))
        if known_of(s)
        else s.minimum + (s.maximum - s.minimum) * 3 // 7
        for s in payload_of(message)
    ]


def frames_of(codec: MessageCodec[Any], count: int) -> list[Frame]:
    """The first frames a sender of the message sends."""
    sender, values = Sender(codec), some_values(codec)
    return [sender.frame(*values) for _ in range(count)]


def oracle(message: Message, values: dict[str, float], *, raw: bool = False) -> bytes:
    """cantools' payload; ``raw`` forges: raw values, and no look at ranges."""
    header = HEADER if message.name in PROTECTED else {}
    return bytes(message.encode({**header, **values}, scaling=not raw, strict=not raw))


def pack(codec: MessageCodec[Any], values: dict[str, float]) -> bytes:
    """Our payload, written into a dirty buffer that holds the header."""
    buffer = bytearray(b"\xff" * codec.length)
    if codec.data_id is not None:
        buffer[:3] = struct.pack("<HB", HEADER["e2e_crc"], HEADER["e2e_counter"])
    codec.pack_into(buffer, *values.values())
    return bytes(buffer)

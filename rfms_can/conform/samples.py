"""What a joint hears: a frame of each message that does nothing in PREOP, and wrong ones."""

import math
import struct
from collections.abc import Iterator
from typing import Any, Final, NamedTuple

from cantools.database.can import Signal

from rfms_can.conform.tester import Tester
from rfms_can.wire.codec import HEADER_SIGNALS, load_database
from rfms_can.wire.layout import bounds, known_values
from rfms_can.wire.nodes import GRIPPER, JOINTS, MASTER
from rfms_can.wire.records import (
    Bias,
    Comply,
    Config,
    ConfigAck,
    Dac,
    Emcy,
    Force,
    Gripper,
    Heartbeat,
    JointAngles,
    JointError,
    Measure,
    Nmt,
    Reference,
    Rows,
    Setpoint,
    Sync,
)
from rfms_can.wire.vocabulary import NodeState

UNKNOWN_PARAMETER: Final = 200
"""A number that contract 2.0 leaves to makers."""
_FLOAT: Final = struct.Struct("<f")
_ZERO6: Final = (0.0,) * 6

Message = tuple[type[NamedTuple], int | None]


def heard(t: Tester) -> dict[Message, tuple[float, ...]]:
    """Messages that the joint hears and values that do no harm."""
    n, rest = t.joint, t.vectors.rest_pose
    setpoint = (*rest.o, *rest.a, *rest.p, 0.0, 0.0, 0.2, 0, 0, rest.configuration, 1, 0, 0, 1, 0)
    beat = (NodeState.PREOP, 0, 0, t.boot_id, t.wire.dbc_hash, 0, 0, 0)
    return {
        (Nmt, None): (0, 31, 0),
        (Heartbeat, MASTER): beat,
        (Sync, None): (1, NodeState.PREOP, 0, t.wire.dbc_hash),
        (Config, n): (UNKNOWN_PARAMETER, 0, 1.0, 0),
        (Measure, n): (0, 0, 0, 0, 0, 0, 0),
        (Reference, n): (0, 0, 0, 0),
        (Rows, n): (*_ZERO6, *_ZERO6, 0.0, 1, 0, 0.0, 0, 0),
        (Setpoint, 1): setpoint,
        (Setpoint, 2): setpoint,
        (JointAngles, 1): (*_ZERO6, 0, 0),
        (JointAngles, 2): (*_ZERO6, 0, 0),
        (Comply, None): (*_ZERO6, 0),
        (Bias, None): (*_ZERO6, 0),
        **{(JointError, j): (0.0, 0.0, 0.0, 0) for j in JOINTS if j != n},
    }


def not_heard(t: Tester) -> dict[Message, tuple[float, ...]]:
    """Messages that are for others."""
    n, other = t.joint, t.joint % len(JOINTS) + 1
    beat = (NodeState.PREOP, 0, 0, 1, t.wire.dbc_hash, 0, 0, 0)
    return {
        (Measure, other): (0, 0, 0, 0, 0, 0, 0),
        (Reference, other): (0, 0, 0, 0),
        (Rows, other): (*_ZERO6, *_ZERO6, 0.0, 1, 0, 0.0, 0, 0),
        (Config, other): (0, 0, 260.0, 0),
        (Config, GRIPPER): (0, 0, 260.0, 0),
        (ConfigAck, other): (0, 0, 0.0, 0),
        (Dac, other): (0, 0, 0),
        (Emcy, other): (12, 0, 0, 0.0, 0.0, 0, 0),
        (Heartbeat, other): beat,
        (Heartbeat, 9): beat,
        (Force, None): (*_ZERO6, 0, 0),
        (Gripper, None): (0, 0.0, 0),
        (Measure, GRIPPER): (0, 0, 0, n, 0, 0, 0),
    }


class Wrong(NamedTuple):
    """A payload with one value that must be refused.

    Attributes:
        signal: its name.
        value: what it says.
        body: the payload, its header open.
    """

    signal: str
    value: float
    body: bytearray


def out_of_range(t: Tester, message: Message, values: tuple[float, ...]) -> Iterator[Wrong]:
    """Payloads of a message with one value that is out of range, no number, or without a name."""
    for signal in _signals(t, message):
        for raw, value in _wrong_values(signal):
            body = t.body(*message, *values)
            _put(body, signal, raw)
            yield Wrong(signal.name, value, body)


def at_the_bounds(t: Tester, message: Message, values: tuple[float, ...]) -> Iterator[bytearray]:
    """Payloads of a message with one value at an end of its range."""
    for signal in _signals(t, message):
        named = known_values(signal)
        low, high = (named[0], named[-1]) if named else bounds(signal)
        for value in (low, high):
            body = t.body(*message, *values)
            _put(body, signal, _raw(signal, value))
            yield body


def _signals(t: Tester, message: Message) -> list[Signal]:
    name = t.codec(*message).name
    found: Any = load_database().get_message_by_name(name)
    return [s for s in found.signals if s.name not in HEADER_SIGNALS]


def _wrong_values(signal: Signal) -> Iterator[tuple[int, float]]:
    """Raw values that must be refused, and what they say."""
    low, high = bounds(signal)
    if signal.is_float:
        for value in (math.nan, math.inf, -math.inf, _beyond(high, 1), _beyond(low, -1)):
            yield _raw(signal, value), value
        return
    size = 1 << signal.length
    least = -size // 2 if signal.is_signed else 0
    scale, offset = signal.conversion.scale, signal.conversion.offset
    raw_low, raw_high = (round((bound - offset) / scale) for bound in (low, high))
    for raw in (raw_low - 1, raw_high + 1):
        if least <= raw < least + size:
            yield raw, raw * scale + offset
    named = known_values(signal)
    if named and named[-1] + 1 <= raw_high:
        yield named[-1] + 1, named[-1] + 1
        yield raw_high, raw_high


def _raw(signal: Signal, value: float) -> int:
    if signal.is_float:
        return int.from_bytes(_FLOAT.pack(value), "little")
    raw: float = (value - signal.conversion.offset) / signal.conversion.scale
    return round(raw)


def _beyond(bound: float, direction: int) -> float:
    """The float32 number next to a bound, away from zero on the side of ``direction``."""
    bits = int.from_bytes(_FLOAT.pack(bound), "little")
    if bound == 0.0:
        return direction * float(_FLOAT.unpack(b"\x01\x00\x00\x00")[0])
    step = 1 if (bound > 0.0) == (direction > 0) else -1
    value: float = _FLOAT.unpack((bits + step).to_bytes(4, "little"))[0]
    return value


def _put(body: bytearray, signal: Signal, raw: int) -> None:
    """Write the bits of a signal."""
    mask = (1 << signal.length) - 1 << signal.start
    word = int.from_bytes(body, "little") & ~mask | (raw << signal.start) & mask
    body[:] = word.to_bytes(len(body), "little")


def flipped(data: bytes) -> Iterator[bytes]:
    """A payload with one bit changed, each in turn."""
    word = int.from_bytes(data, "little")
    for bit in range(8 * len(data)):
        yield (word ^ 1 << bit).to_bytes(len(data), "little")

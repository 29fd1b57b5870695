"""From bytes of a peer to a message, or to the reason why they cannot be read as one."""

import math
from typing import Annotated, Final, TypeVar

import msgspec

from rfms_can.messages import MAX_BYTES, AnyRequest, EmergencyLift, EmergencyStop

Special = TypeVar("Special", EmergencyStop, EmergencyLift)
LARGEST: Final = 1e9
"""Largest magnitude of a number in a message: beyond it none has a meaning in SI units."""


class Head(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An ``Envelope`` whose message has not been read yet; the fields are the same.

    So a message that cannot be read is refused under its own serial number.
    """

    session: Annotated[str, msgspec.Meta(min_length=16, max_length=64)]
    serial: Annotated[int, msgspec.Meta(ge=1)]
    message: msgspec.Raw


_heads: Final = msgspec.msgpack.Decoder(Head)
_requests: Final[msgspec.msgpack.Decoder[AnyRequest]] = msgspec.msgpack.Decoder(AnyRequest)
_emergencies: Final = msgspec.msgpack.Decoder(EmergencyStop)
_lifts: Final = msgspec.msgpack.Decoder(EmergencyLift)
_UNREADABLE: Final = (msgspec.DecodeError, UnicodeDecodeError, RecursionError, OverflowError)
"""What msgspec raises for bytes that are not a message: also bad UTF-8, and nesting without end."""


def read_head(data: bytes) -> Head | str:
    """Who speaks and under which number, or why the bytes are not a request."""
    if len(data) > MAX_BYTES:
        return f"a message of {len(data)} bytes: {MAX_BYTES} at most"
    try:
        return _heads.decode(data)
    except _UNREADABLE as error:
        return _reason(error)


def read_request(head: Head) -> AnyRequest | str:
    """The message of a request, or why it cannot be read."""
    try:
        request = _requests.decode(head.message)
    except _UNREADABLE as error:
        return _reason(error)
    return _wrong_number(request) or request


def read_emergency(data: bytes) -> EmergencyStop | str:
    """An emergency stop, or why the bytes are not one."""
    return _read(_emergencies, data)


def read_lift(data: bytes) -> EmergencyLift | str:
    """The lift of an emergency stop, or why the bytes are not one."""
    return _read(_lifts, data)


def _read(decoder: "msgspec.msgpack.Decoder[Special]", data: bytes) -> Special | str:
    if len(data) > MAX_BYTES:
        return f"a message of {len(data)} bytes: {MAX_BYTES} at most"
    try:
        return decoder.decode(data)
    except _UNREADABLE as error:
        return _reason(error)


def _reason(error: Exception) -> str:
    text = f"{type(error).__name__}: {error}" if not str(error) else str(error)
    return f"not a message: {text}"


def _wrong_number(value: object, place: str = "") -> str:
    """What is wrong with a number anywhere in a message; empty if nothing is."""
    if isinstance(value, float):
        if math.isfinite(value) and abs(value) <= LARGEST:
            return ""
        return f"{place} is {value:g}: numbers are finite, and at most {LARGEST:g} in SI units"
    if isinstance(value, msgspec.Struct):
        for name in value.__struct_fields__:
            wrong = _wrong_number(getattr(value, name), f"{place}.{name}" if place else name)
            if wrong:
                return wrong
    elif isinstance(value, tuple | list):
        for index, one in enumerate(value):
            wrong = _wrong_number(one, f"{place}[{index}]")
            if wrong:
                return wrong
    return ""

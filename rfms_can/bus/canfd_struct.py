"""Linux' ``struct canfd_frame`` and ``struct can_frame`` (linux/can.h), for SocketCAN and the hub.
Bytes 0-3 identifier with three flags, 4 length, 5 FD flags, 8 on payload; native order.
"""

import struct
import sys
from typing import Final

from rfms_can.errors import FrameError
from rfms_can.wire.frame import MAX_ID, Frame

CANFD_BYTES: Final = 72
CLASSIC_BYTES: Final = 16
EXTENDED_FLAG: Final = 0x80000000
REMOTE_FLAG: Final = 0x40000000
ERROR_FLAG: Final = 0x20000000
BIT_RATE_SWITCH: Final = 0x01
FD_FORMAT: Final = 0x04  # distinguishes FD from classic where both use the longer struct

CANFD_STRUCT: Final = struct.Struct("=IBB2x64s")
CLASSIC_STRUCT: Final = struct.Struct("=IB3x8s")

_FD_FLAGS: Final = BIT_RATE_SWITCH | FD_FORMAT
_pack_canfd = CANFD_STRUCT.pack
_unpack_canfd_from = CANFD_STRUCT.unpack_from


def pack_canfd(frame: Frame) -> bytes:
    """The frame in 72 bytes with its format in the flags, as on the hub."""
    return _pack_canfd(frame.id, len(frame.data), _FD_FLAGS if frame.fd else 0, frame.data)


def pack_socketcan(frame: Frame) -> bytes:
    """The frame for SocketCAN: FD in 72 bytes, classic in 16."""
    if frame.fd:
        return _pack_canfd(frame.id, len(frame.data), _FD_FLAGS, frame.data)
    return CLASSIC_STRUCT.pack(frame.id, len(frame.data), frame.data)


def unpack_canfd(packet: bytes, offset: int = 0) -> Frame | None:
    """The hub's 72 bytes as a frame; None unless it is a data frame with an 11-bit identifier."""
    can_id, length, flags, data = _unpack_canfd_from(packet, offset)
    return _as_frame(can_id, data[:length], bool(flags & FD_FORMAT))


def unpack_socketcan(packet: bytes) -> Frame | None:
    """A packet of SocketCAN as a frame, its format given by its size; None as above."""
    if len(packet) == CANFD_BYTES:
        can_id, length, _, data = _unpack_canfd_from(packet)
        return _as_frame(can_id, data[:length], True)
    if len(packet) == CLASSIC_BYTES:
        can_id, length, data = CLASSIC_STRUCT.unpack(packet)
        return _as_frame(can_id, data[:length], False)
    return None


def can_id_of(packet: bytes) -> int:
    """Identifier and flags of either struct."""
    return int.from_bytes(packet[:4], sys.byteorder)


def _as_frame(can_id: int, data: bytes, fd: bool) -> Frame | None:
    if can_id > MAX_ID:
        return None
    try:
        return Frame(can_id, data, fd)
    except FrameError:
        return None

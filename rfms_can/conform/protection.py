"""Headers of the tester's frames and of the node's: CRC and counter, apart from the nodes' own.

Whole frames with their CRC stand in ``vectors/frames.json``.
"""

import binascii
from typing import Final

from rfms_can.wire.frame import Frame

HEADER: Final = 3
"""Bytes of the header: CRC low, CRC high, counter."""


def crc(data: bytes, data_id: int) -> int:
    """CRC-16 (0x1021 from 0xFFFF) of all behind the CRC, and of the data ID, low byte first."""
    return binascii.crc_hqx(data[2:] + data_id.to_bytes(2, "little"), 0xFFFF)


def sealed(identifier: int, body: bytes | bytearray, counter: int, data_id: int) -> Frame:
    """A frame around a ``body`` whose header, not yet set, says ``counter`` then."""
    data = bytearray(body)
    data[2] = counter & 0xFF
    data[0:2] = crc(bytes(data), data_id).to_bytes(2, "little")
    return Frame(identifier, bytes(data))


def fits(data: bytes, data_id: int) -> bool:
    """Whether the CRC is that of the data."""
    return int.from_bytes(data[0:2], "little") == crc(data, data_id)

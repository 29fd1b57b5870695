"""Frames with other values, a right CRC and a right counter: what a faulty node would send."""

import struct
from typing import Any, Final

from e2e.p05 import e2e_p05_protect

from rfms_can.wire.codec import MessageCodec, load_database
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame

COUNTER: Final = 2
"""Byte of the end-to-end header that holds the counter."""
_BYTE: Final = 8


class Forge:
    """Makes frames of others.

    Args:
        wire: compiled codecs.
    """

    def __init__(self, wire: Wire) -> None:
        self._codecs: dict[int, MessageCodec[Any]] = {c.id: c for c in wire.codecs.values()}

    def read(self, frame: Frame) -> Any:
        """The values of a good frame; None if one is out of range."""
        return self._codecs[frame.id].unpack(frame.data)

    def changed(self, frame: Frame, **values: float) -> Frame:
        """The frame with other values.

        Raises:
            EncodeError: a value is out of its range: take ``patched``.
        """
        codec = self._codecs[frame.id]
        buffer = bytearray(codec.length)
        codec.pack_into(buffer, *self.read(frame)._replace(**values))
        return self._protected(codec, buffer, frame.data[COUNTER])

    def patched(self, frame: Frame, signal: str, value: float) -> Frame:
        """The frame with any number in a signal of 32 bits, as a float: NaN, or out of range."""
        codec = self._codecs[frame.id]
        message = load_database().get_message_by_name(codec.name)
        buffer = bytearray(frame.data)
        struct.pack_into("<f", buffer, message.get_signal_by_name(signal).start // _BYTE, value)
        return self._protected(codec, buffer, frame.data[COUNTER])

    def counted(self, frame: Frame, counter: int) -> Frame:
        """The frame with another counter."""
        return self._protected(self._codecs[frame.id], bytearray(frame.data), counter)

    def _protected(self, codec: MessageCodec[Any], buffer: bytearray, counter: int) -> Frame:
        if codec.data_id is not None:
            buffer[COUNTER] = (counter - 1) & 0xFF  # protecting counts on
            e2e_p05_protect(buffer, codec.data_id)
        return Frame(codec.id, bytes(buffer))

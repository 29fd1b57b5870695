"""End-to-end protection of a stream of frames: AUTOSAR E2E profile 5 and its refusals.

A ``Sender`` packs and protects the frames of one identifier; a ``Receiver`` accepts a frame as a
whole or refuses it, and counts refusals by reason (``PROTOCOL`` R0). CRC and header are those of
the library (``autosar-e2e``); the counter rules are here: an equal counter is a duplicate, one up
to half the range ahead is accepted and the gap counted, any other is an old frame.
"""

from collections import Counter
from enum import Enum
from typing import Final, Generic

from e2e.p05 import e2e_p05_check, e2e_p05_protect

from rfms_can.wire.codec import MessageCodec, Record
from rfms_can.wire.frame import Frame

_COUNTER: Final = 2  # byte of the header that holds the counter
_BEFORE_FIRST: Final = 255


class Refusal(Enum):
    """Why a frame was refused."""

    KIND = "not a CAN FD frame"
    LENGTH = "wrong length"
    CRC = "wrong CRC"
    RANGE = "a value out of range or not a number"
    DUPLICATE = "counter unchanged"
    ORDER = "counter went back"


class Sender(Generic[Record]):
    """Packs the frames of one message, counting them."""

    __slots__ = ("_buffer", "_data_id", "_id", "_pack_into", "codec")

    def __init__(self, codec: MessageCodec[Record]) -> None:
        self.codec = codec
        self._id = codec.id
        self._pack_into = codec.pack_into
        self._data_id = codec.data_id
        self._buffer = bytearray(codec.length)
        self.reset()

    def reset(self) -> None:
        """Restart the counter at 0, as every sender does when the arm is enabled."""
        if self._data_id is not None:
            self._buffer[_COUNTER] = _BEFORE_FIRST

    def frame(self, *values: float) -> Frame:
        """The next frame of this message; values in the record's order.

        Raises:
            EncodeError: a value does not fit its signal; the counter is unchanged.
        """
        buffer = self._buffer
        self._pack_into(buffer, *values)
        if self._data_id is not None:
            e2e_p05_protect(buffer, self._data_id)
        return Frame(self._id, bytes(buffer))


class Decoder(Generic[Record]):
    """Checks and unpacks the frames of one message; caches the last result.

    Decoding is a pure function of the frame, so nodes of one process may share a decoder; the
    counter is each receiver's own.

    Attributes:
        frame, result: the frame decoded last, and its values or why it was refused.
    """

    __slots__ = ("_data_id", "_length", "_unpack", "codec", "frame", "result")

    def __init__(self, codec: MessageCodec[Record]) -> None:
        self.codec = codec
        self._length = codec.length
        self._data_id = codec.data_id
        self._unpack = codec.unpack
        self.frame: Frame | None = None
        self.result: Record | Refusal = Refusal.LENGTH

    def decode(self, frame: Frame) -> Record | Refusal:
        """The frame's values, or why it is refused (counter rules apart)."""
        if frame is not self.frame:
            self.result = self._check(frame)
            self.frame = frame
        return self.result

    def _check(self, frame: Frame) -> Record | Refusal:
        data = frame.data
        if not frame.fd:
            return Refusal.KIND
        if len(data) != self._length:
            return Refusal.LENGTH
        if self._data_id is not None and not e2e_p05_check(data, self._data_id):
            return Refusal.CRC
        values = self._unpack(data)
        return Refusal.RANGE if values is None else values


class Receiver(Generic[Record]):
    """Receives the frames of one message for one node, and counts refusals.

    Args:
        decoder: checks and unpacks.
        refused: counts refusals by reason; one for all receivers of a node.
        ordered: whether the counter is checked; not where a restarted sender must be accepted
            immediately.

    Attributes:
        lost: frames missed, by gaps of the counter.
        refused: refusals by reason, shared with the node's other receivers if one is given.
    """

    __slots__ = ("_counter", "_ordered", "decoder", "lost", "refused")

    def __init__(
        self,
        decoder: Decoder[Record],
        refused: "Counter[Refusal] | None" = None,
        *,
        ordered: bool = True,
    ) -> None:
        self.decoder = decoder
        self._ordered = ordered and decoder.codec.data_id is not None
        self._counter: int | None = None
        self.lost = 0
        self.refused: Counter[Refusal] = Counter() if refused is None else refused

    def reset(self) -> None:
        """Accept the next frame with any counter: the sender may have restarted."""
        self._counter = None

    def take(self, frame: Frame) -> Record | None:
        """The frame's values, or None if it is refused (counted)."""
        decoder = self.decoder
        # ``decode`` inlined for the cached result: several nodes receive each frame
        values = decoder.result if frame is decoder.frame else decoder.decode(frame)
        if values.__class__ is Refusal:
            self.refused[values] += 1
            return None
        if self._ordered:
            counter = frame.data[_COUNTER]
            if self._counter is not None:
                step = (counter - self._counter) & 0xFF
                if step != 1:
                    if step == 0 or step >= 128:
                        self.refused[Refusal.ORDER if step else Refusal.DUPLICATE] += 1
                        return None
                    self.lost += step - 1
            self._counter = counter
        return values  # type: ignore[return-value]  # refusals left above

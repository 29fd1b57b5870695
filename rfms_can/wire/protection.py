"""End-to-end protection of a stream of frames: AUTOSAR E2E profile 5 and its refusals.

A ``Sender`` packs and protects the frames of one identifier, a ``Receiver`` takes them whole or
not at all and counts what it refused and why. The CRC and header are the library's
(``autosar-e2e``); the rule of the counters is here, one for all messages:

- The first frame is taken whatever its counter: after power-up, after START or RESET (``reset``),
  after a HEARTBEAT of the sender with another boot id. It may have been under way since before;
  so the second one is too, if its counter is another.
- Then a counter 1 to ``COUNTER_WINDOW`` ahead of the last one taken is in step; the gap is counted.
- Every other frame is refused: the same counter is a duplicate, the rest out of order. The
  ``COUNTER_RESTART``-th of them in a row that count on among themselves is taken all the same, for
  the receiver may have been deaf for long. Each such leap doubles how many the next one takes: an
  old recording that is played into the bus does not get far.
"""

from collections import Counter
from enum import Enum
from typing import Any, Final, Generic

from e2e.p05 import e2e_p05_check, e2e_p05_protect

from rfms_can.wire.codec import MessageCodec, Record
from rfms_can.wire.frame import Frame

_COUNTER: Final = 2  # byte of the header that holds the counter
_BEFORE_FIRST: Final = 255

_ANY: Final = -1
"""Expected counter of a receiver that takes the next frame whatever it is."""
_PROVISIONAL: Final = 0x100
"""Beside the expected counter, after the first frame: no counter is equal to it."""

COUNTER_WINDOW: Final = 16
"""Largest step of a counter that is taken; the DBC's RfmsCounterWindow."""
COUNTER_RESTART: Final = 3
"""Refused frames in a row, in step among themselves, of which the last is taken; the DBC's
RfmsCounterRestart."""


class Refusal(Enum):
    """Why a frame was refused."""

    KIND = "not a CAN FD frame"
    LENGTH = "wrong length"
    CRC = "wrong CRC"
    RANGE = "a value out of range or not a number"
    DUPLICATE = "counter unchanged"
    ORDER = "counter out of order"


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

    __slots__ = ("_classic", "_data_id", "_length", "_unpack", "codec", "frame", "result")

    def __init__(self, codec: MessageCodec[Record]) -> None:
        self.codec = codec
        self._length = codec.length
        self._classic = codec.classic
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
        if not frame.fd and not self._classic:
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

    Attributes:
        lost: frames missed, by gaps of the counter.
        leaps: times a counter out of step was taken up (``COUNTER_RESTART``).
        refused: refusals by reason, shared with the node's other receivers if one is given.
        bad: refusals of its own by reason.
    """

    __slots__ = (
        "_counted",
        "_expected",
        "_in_row",
        "_needed",
        "_stray",
        "_stray_base",
        "bad",
        "decoder",
        "leaps",
        "lost",
        "refused",
    )

    def __init__(self, decoder: Decoder[Record], refused: "Counter[Refusal] | None" = None) -> None:
        self.decoder = decoder
        self._counted = decoder.codec.data_id is not None
        self.lost = self.leaps = 0
        self.refused: Counter[Refusal] = Counter() if refused is None else refused
        self.bad: Counter[Refusal] = Counter()
        self.reset()

    def reset(self) -> None:
        """Take the next frame whatever its counter: its sender has started again."""
        self._expected = _ANY
        self._needed = COUNTER_RESTART
        self._in_row = 0
        self._stray = self._stray_base = -1

    def take(self, frame: Frame) -> Record | None:
        """The frame's values, or None if it is refused (counted)."""
        decoder = self.decoder
        # ``decode`` inlined for the cached result: several nodes receive each frame
        values = decoder.result if frame is decoder.frame else decoder.decode(frame)
        if values.__class__ is Refusal:
            self._refuse(values)
            return None
        if self._counted:
            counter = frame.data[_COUNTER]
            if counter == self._expected:
                self._expected = counter + 1 & 0xFF
            elif not self._is_taken_up(counter):
                return None
        return values  # type: ignore[return-value]  # refusals left above

    def _is_taken_up(self, counter: int) -> bool:
        """Whether a frame is taken that does not follow the last one directly; goes on from it."""
        follower = counter + 1 & 0xFF
        if self._expected == _ANY:
            self._expected = follower | _PROVISIONAL
            return True
        provisional = self._expected & _PROVISIONAL
        last = self._expected - 1 & 0xFF
        step = counter - last & 0xFF
        if 0 < step <= COUNTER_WINDOW:
            self.lost += step - 1
        elif not (provisional and step) and not self._ends_a_row(counter, last):
            self._refuse(Refusal.ORDER if step else Refusal.DUPLICATE)
            return False
        self._expected = follower
        return True

    def _refuse(self, reason: Any) -> None:
        self.refused[reason] += 1
        self.bad[reason] += 1

    def _ends_a_row(self, counter: int, last: int) -> bool:
        """Whether enough frames in a row were out of step, and in step among themselves."""
        follows = 0 < (counter - self._stray) & 0xFF <= COUNTER_WINDOW
        # in a row: none was taken between this one and the stray before
        self._in_row = self._in_row + 1 if follows and last == self._stray_base else 1
        self._stray, self._stray_base = counter, last
        if self._in_row < self._needed:
            return False
        self._in_row, self._needed = 0, 2 * self._needed
        self.leaps += 1
        return True


class HeartbeatReceiver(Receiver[Record]):
    """Takes heartbeats: another boot id means another start, whose counters begin at 0.

    Attributes:
        boot_id: of the heartbeat taken last; None before the first.
    """

    __slots__ = ("boot_id",)

    def __init__(self, decoder: Decoder[Record], refused: "Counter[Refusal] | None" = None) -> None:
        super().__init__(decoder, refused)
        self.boot_id: int | None = None

    def take(self, frame: Frame) -> Record | None:
        """The heartbeat's values, or None if it is refused (counted)."""
        values: Any = self.decoder.decode(frame)
        if values.__class__ is not Refusal and values.boot_id != self.boot_id:
            self.boot_id = values.boot_id
            self.reset()
        return super().take(frame)

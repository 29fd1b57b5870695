"""What the master has sent, and hears back: the transmit confirmation of its controller.

A frame under an identifier of the master's is its own if it is bit for bit what it has sent; the
frames of one identifier go out in their order. What it has not sent comes from another master.
"""

from collections import deque
from typing import Final

from rfms_can.wire.frame import Frame

KEPT: Final = 8
"""Frames of one identifier that may wait for their confirmation; older ones never went out."""


class OwnFrames:
    """The frames that are on their way.

    Args:
        identifiers: of the messages that the master alone sends.

    Attributes:
        confirmed: frames that have gone out.
        altered: frames that have gone out otherwise than they were handed over, by identifier.
    """

    __slots__ = ("_last", "_waiting", "altered", "confirmed")

    def __init__(self, identifiers: frozenset[int]) -> None:
        self._waiting: dict[int, deque[Frame]] = {i: deque(maxlen=KEPT) for i in identifiers}
        self._last: dict[int, Frame] = {}
        self.altered: dict[int, int] = dict.fromkeys(identifiers, 0)
        self.confirmed = 0

    def sent(self, frame: Frame) -> None:
        """A frame has been handed over; others than the master's own are not kept."""
        waiting = self._waiting.get(frame.id)
        if waiting is not None:
            waiting.append(frame)

    def confirm(self, frame: Frame) -> bool:
        """Whether a frame that is heard is one that was sent; else another master has sent it.

        One that differs from all that wait stands for the oldest: something between the master and
        the bus has altered it, or it is foreign, which shows when the own one comes after it. The
        same frame once more is a repetition by the bus.
        """
        waiting, last = self._waiting[frame.id], self._last.get(frame.id)
        if frame in waiting:
            while waiting.popleft() != frame:
                pass  # those before it never went out
        elif waiting:
            waiting.popleft()
            self.altered[frame.id] += 1
        elif last is None or frame != last:
            return False
        self._last[frame.id] = frame
        self.confirmed += 1
        return True

"""Disturbances of transmissions on the simulated bus, for fault tests.

A *disturber* is called once for every transmission, retransmissions included, at its start of
frame. It returns None (no disturbance) or a ``Disturbance``.
"""

from collections.abc import Callable, Container
from typing import Final

import msgspec

from rfms_can.errors import BusError
from rfms_can.wire.frame import Frame


class _Everyone:
    """A container of every name."""

    def __contains__(self, name: object) -> bool:
        return True


EVERYONE: Final[Container[str]] = _Everyone()
"""For ``Disturbance.lost_at``: no receiver gets the frame."""


class Disturbance(msgspec.Struct, frozen=True):
    """Disturbance of one transmission; fields combine, but ``error_at`` ends the transmission.

    What a sender hears of its own frame, its transmit confirmation, is not disturbed: it comes at
    the end of the frame, once, as it was sent.

    Attributes:
        error_at: fraction of the frame (0 to 1) after which an error flag destroys it. The bus
            carries the error frame, all error counters count it, the sender retransmits.
        lost_at: names of receivers that miss the frame, as in a receive overrun: the bus and
            the sender notice nothing.
        data: payload delivered instead, as by a faulty gateway: CAN's own checksum is valid. It
            may have another length.
        fd: whether it is delivered as a CAN FD frame or as a classic one; None: as it was sent.
        delay_ns: the receivers get the frame by so much after its end, after frames that were
            sent later.
        copies: number of additional deliveries at the same instant.

    Raises:
        BusError: a fraction outside 0..1, a negative delay or number of copies.
    """

    error_at: float | None = None
    lost_at: Container[str] = frozenset()
    data: bytes | None = None
    fd: bool | None = None
    delay_ns: int = 0
    copies: int = 0

    def __post_init__(self) -> None:
        if self.error_at is not None and not 0.0 <= self.error_at <= 1.0:
            raise BusError(f"error_at {self.error_at} is outside 0..1 (a fraction of the frame)")
        if self.delay_ns < 0 or self.copies < 0:
            raise BusError(f"delay {self.delay_ns} ns and {self.copies} copies must not be < 0")


Disturber = Callable[[int, Frame, str], Disturbance | None]
"""``disturber(time_ns, frame, sender_name)``, asked at the start of each transmission."""

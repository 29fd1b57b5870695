"""What can be done to a transmission on the simulated bus, for fault tests.

A *disturber* is asked once for every transmission, retransmissions included, at its start of
frame. It answers with None (leave it alone) or with a ``Disturbance``.
"""

from collections.abc import Callable, Container
from typing import Final

import msgspec

from rfms_can.errors import BusError
from rfms_can.wire.frame import Frame


class _Everyone:
    """A container that holds every name."""

    def __contains__(self, name: object) -> bool:
        return True


EVERYONE: Final[Container[str]] = _Everyone()
"""For ``Disturbance.lost_at``: no receiver gets the frame."""


class Disturbance(msgspec.Struct, frozen=True):
    """One transmission's misfortune; fields combine, except that ``error_at`` ends it all.

    Attributes:
        error_at: fraction of the frame (0 to 1) after which an error flag destroys it. The bus
            carries the error frame, every error counter moves, the sender retransmits.
        lost_at: names of receivers that miss the frame, as in a receive overrun: the bus and
            the sender notice nothing.
        data: payload the receivers get instead, as from a broken gateway: CAN's own checksum
            is right.
        delay_ns: the receivers get the frame so much after its end, behind frames that were
            sent later.
        copies: how many further times the receivers get it, at the same instant.

    Raises:
        BusError: a fraction outside 0..1, a negative delay or number of copies.
    """

    error_at: float | None = None
    lost_at: Container[str] = frozenset()
    data: bytes | None = None
    delay_ns: int = 0
    copies: int = 0

    def __post_init__(self) -> None:
        if self.error_at is not None and not 0.0 <= self.error_at <= 1.0:
            raise BusError(f"error_at {self.error_at} is outside 0..1 (a fraction of the frame)")
        if self.delay_ns < 0 or self.copies < 0:
            raise BusError(f"delay {self.delay_ns} ns and {self.copies} copies must not be < 0")


Disturber = Callable[[int, Frame, str], Disturbance | None]
"""``disturber(time_ns, frame, sender_name)``, asked at the start of each transmission."""

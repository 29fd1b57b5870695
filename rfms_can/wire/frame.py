"""A CAN frame, immutable and validated, used by every node and every bus."""

from typing import Final

import msgspec

from rfms_can.errors import FrameError

MAX_ID: Final = 0x7FF
IDENTIFIERS: Final = frozenset(range(MAX_ID + 1))
FD_LENGTHS: Final = frozenset((*range(9), 12, 16, 20, 24, 32, 48, 64))
"""Payload lengths CAN FD can carry (ISO 11898-1, DLC 0 to 15)."""

CLASSIC_LENGTHS: Final = frozenset(range(9))


class Frame(msgspec.Struct, frozen=True, gc=False):
    """One data frame with an 11-bit identifier.

    Attributes:
        id: identifier, 0 to 0x7FF; the lower, the higher the priority.
        data: payload; 0 to 8 bytes, or an FD length if ``fd``.
        fd: CAN FD with bit-rate switching (our frames), or classic CAN.

    Raises:
        FrameError: the identifier or the length is invalid.
    """

    id: int
    data: bytes
    fd: bool = True

    def __post_init__(self) -> None:
        if not 0 <= self.id <= MAX_ID:
            raise FrameError(f"identifier {self.id:#x} is outside 0..0x7ff (11-bit identifiers)")
        if len(self.data) not in (FD_LENGTHS if self.fd else CLASSIC_LENGTHS):
            kind = "CAN FD" if self.fd else "classic CAN"
            raise FrameError(f"frame {self.id:#05x}: {len(self.data)} bytes is not a {kind} length")

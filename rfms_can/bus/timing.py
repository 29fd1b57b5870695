"""How long a frame occupies the bus: classic CAN, and CAN FD (ISO) with bit-rate switching.

Times run from start of frame to the end of the three bits of intermission, the first moment at
which the next frame may start. 11-bit identifiers.

Fields of an FD data frame of s bytes, stuff bits apart::

    nominal rate   SOF 1, identifier 11, RRS, IDE, FDF, reserved, BRS             17
    data rate      ESI 1, DLC 4, payload 8 s, stuff count 4, CRC 17 or 21,
                   fixed stuff bits 6 or 7
    nominal rate   CRC delimiter 1, ACK 2, end of frame 7, intermission 3         13
"""

from typing import Final

from rfms_can.bus.stuffing import (
    FD_DLC_LENGTHS,
    classic_stuff_bits,
    fd_arbitration_stuff_bits,
    fd_data_stuff_bits,
)
from rfms_can.errors import BusError
from rfms_can.wire.frame import CLASSIC_LENGTHS, Frame

NS_PER_S: Final = 1_000_000_000
INTERMISSION_BITS: Final = 3
MAX_NOMINAL_BIT_RATE: Final = 1_000_000
MAX_DATA_BIT_RATE: Final = 8_000_000

_FD_NOMINAL_BITS: Final = 30
_FD_WORST_ARBITRATION_STUFF: Final = 4
_CLASSIC_BITS: Final = 47  # SOF to intermission, without payload and stuff bits
_CLASSIC_STUFFED_BITS: Final = 34  # SOF to the end of the CRC, without payload
_MOST_NOMINAL_BITS: Final = 55 + 10 * 8
_MOST_DATA_BITS: Final = 678


def _fd_data_bits(length: int) -> int:
    """Bits of the data phase without dynamic stuff bits."""
    checksum, fixed_stuff = (17, 6) if length <= 16 else (21, 7)
    return 5 + 8 * length + 4 + checksum + fixed_stuff


def _fd_worst_data_stuff(length: int) -> int:
    """Largest number of dynamic stuff bits of the data phase."""
    return (22 + 8 * length - 1) // 4 - _FD_WORST_ARBITRATION_STUFF


class BusTiming:
    """Bit rates of one bus, and the duration of frames on it.

    Args:
        nominal_bit_rate: bit/s of arbitration and of classic frames, at most 1 Mbit/s.
        data_bit_rate: bit/s of the FD data phase, at least the nominal rate and at most
            8 Mbit/s; None for a classic bus, which carries no FD frames.

    Raises:
        BusError: a rate out of range.
    """

    __slots__ = ("_data_ns", "_fd_bits", "_nominal_ns", "data_bit_rate", "nominal_bit_rate")

    def __init__(
        self, nominal_bit_rate: int = 1_000_000, data_bit_rate: int | None = 5_000_000
    ) -> None:
        if not 0 < nominal_bit_rate <= MAX_NOMINAL_BIT_RATE:
            raise BusError(
                f"nominal bit rate {nominal_bit_rate} bit/s is outside 1..{MAX_NOMINAL_BIT_RATE}"
            )
        if data_bit_rate is not None and not (
            nominal_bit_rate <= data_bit_rate <= MAX_DATA_BIT_RATE
        ):
            raise BusError(
                f"data bit rate {data_bit_rate} bit/s is outside the nominal rate "
                f"{nominal_bit_rate}..{MAX_DATA_BIT_RATE} (None makes the bus classic CAN)"
            )
        self.nominal_bit_rate = nominal_bit_rate
        self.data_bit_rate = data_bit_rate
        self._nominal_ns = _durations_ns(nominal_bit_rate, _MOST_NOMINAL_BITS)
        self._data_ns = _durations_ns(data_bit_rate or nominal_bit_rate, _MOST_DATA_BITS)
        self._fd_bits = {length: _fd_data_bits(length) for length in FD_DLC_LENGTHS}

    def __repr__(self) -> str:
        return f"BusTiming({self.nominal_bit_rate}, {self.data_bit_rate})"

    @property
    def bit_ns(self) -> float:
        """One bit at the nominal rate, ns."""
        return NS_PER_S / self.nominal_bit_rate

    def nominal_ns(self, bits: int) -> int:
        """Duration of ``bits`` bits (at most 135) at the nominal rate, ns."""
        return self._nominal_ns[bits]

    def worst_case_ns(self, length: int, fd: bool = True) -> int:
        """Bus time of a frame of ``length`` bytes with the most stuff bits, ns.

        Raises:
            BusError: an FD frame on a classic bus, or a length that the format does not have.
        """
        if not fd:
            if length not in CLASSIC_LENGTHS:
                raise BusError(f"{length} bytes do not fit in a classic frame (0..8): split it")
            stuff = (_CLASSIC_STUFFED_BITS + 8 * length - 1) // 4
            return self._nominal_ns[_CLASSIC_BITS + 8 * length + stuff]
        self._require_fd(length)
        data_bits = self._fd_bits[length] + _fd_worst_data_stuff(length)
        return (
            self._nominal_ns[_FD_NOMINAL_BITS + _FD_WORST_ARBITRATION_STUFF]
            + (self._data_ns[data_bits])
        )

    def exact_ns(self, frame: Frame) -> int:
        """Bus time of this frame with its stuff bits, ns.

        Raises:
            BusError: an FD frame on a classic bus.
        """
        data = frame.data
        if not frame.fd:
            bits = _CLASSIC_BITS + 8 * len(data) + classic_stuff_bits(frame.id, data)
            return self._nominal_ns[bits]
        if self.data_bit_rate is None:
            self._require_fd(len(data))
        return (
            self._nominal_ns[_FD_NOMINAL_BITS + fd_arbitration_stuff_bits(frame.id)]
            + self._data_ns[self._fd_bits[len(data)] + fd_data_stuff_bits(data)]
        )

    def _require_fd(self, length: int) -> None:
        if self.data_bit_rate is None:
            raise BusError(
                f"a CAN FD frame of {length} bytes on a classic bus "
                f"({self.nominal_bit_rate} bit/s): give a data bit rate"
            )
        if length not in self._fd_bits:
            raise BusError(f"{length} bytes is not a CAN FD payload length: {FD_DLC_LENGTHS}")


def _durations_ns(bit_rate: int, most_bits: int) -> tuple[int, ...]:
    """Duration of 0, 1, ... ``most_bits`` bits, rounded to ns (a bit may not be whole ns)."""
    return tuple((bits * NS_PER_S + bit_rate // 2) // bit_rate for bits in range(most_bits + 1))

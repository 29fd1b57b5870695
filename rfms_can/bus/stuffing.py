"""Stuff bits of one frame, counted exactly and fast.

After five equal bits CAN sends one of the opposite level, which itself counts as the first bit
of the next run (ISO 11898-1), so the length of a frame depends on its payload. The count is a small
state machine over (level of the last bit, length of its run), tabulated for 16 bits at a step: a
64-byte payload takes 32 list look-ups.

A run of five leaves its stuff bit *pending*: it is counted when the next bit comes. That is how
CAN FD ends its data field: the first fixed stuff bit, sent in any case, takes the place of a
pending one. Classic CAN sends it, after the last bit of the checksum too.

The error state indicator is taken as dominant: the sender is error-active.
"""

import functools
import struct
from collections.abc import Callable
from typing import Any, Final

STUFF_RUN: Final = 5
"""Equal bits in a row that are followed by a stuff bit."""

FD_DLC_LENGTHS: Final = (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64)
"""Payload bytes by data length code (ISO 11898-1, table 5)."""

_STATES: Final = 2 * STUFF_RUN  # level * STUFF_RUN + run - 1
_CRC15_POLYNOMIAL: Final = 0x4599

# A row maps the next chunk of bits to (row to go on with, stuff bits met); rows form a graph.
_Row = list[tuple[Any, int]]


def _push(state: int, bit: int) -> tuple[int, int]:
    """The state after one more bit, and the stuff bits (0 or 1) sent before it."""
    level, run = state // STUFF_RUN, state % STUFF_RUN + 1
    stuffed = 0
    if run == STUFF_RUN:
        level, run, stuffed = 1 - level, 1, 1
    run = run + 1 if bit == level else 1
    return bit * STUFF_RUN + run - 1, stuffed


def _push_bits(state: int, value: int, width: int) -> tuple[int, int]:
    """The state after the ``width`` bits of ``value``, most significant first, and stuff bits."""
    stuffed = 0
    for shift in range(width - 1, -1, -1):
        state, more = _push(state, value >> shift & 1)
        stuffed += more
    return state, stuffed


_START_OF_FRAME: Final = 0  # the bus was recessive, one dominant bit: level 0, run 1


@functools.cache
def _byte_steps() -> list[list[tuple[int, int]]]:
    """[state][byte] -> (next state, stuff bits)."""
    return [[_push_bits(state, byte, 8) for byte in range(256)] for state in range(_STATES)]


@functools.cache
def _byte_rows() -> list[_Row]:
    """The rows that take 8 bits at a step, by state."""
    rows: list[_Row] = [[] for _ in range(_STATES)]
    for row, steps in zip(rows, _byte_steps(), strict=True):
        row.extend((rows[state], stuffed) for state, stuffed in steps)
    return rows


@functools.cache
def _word_rows() -> list[_Row]:
    """The rows that take 16 bits at a step, by state: 5 MB, built in milliseconds.

    All entries of a row that end alike share one tuple, and the 256 entries behind one first
    byte are one of few lists, so that filling a row is copying lists.
    """
    rows: list[_Row] = [[] for _ in range(_STATES)]
    steps = _byte_steps()
    most = 16 // (STUFF_RUN - 1) + 1
    ends = [[(rows[state], stuffed) for stuffed in range(most)] for state in range(_STATES)]

    @functools.cache
    def second_byte(state: int, already: int) -> _Row:
        return [ends[following][already + stuffed] for following, stuffed in steps[state]]

    for state in range(_STATES):
        for middle, stuffed in steps[state]:
            rows[state].extend(second_byte(middle, stuffed))
    return rows


@functools.cache
def _fd_data_start(length: int) -> tuple[_Row, int, Callable[[bytes], tuple[int, ...]]]:
    """Row to start an FD payload with, stuff bits met in ESI and DLC, and the payload's chunks.

    The data phase always starts after a recessive BRS that follows a dominant reserved bit.
    """
    after_brs = STUFF_RUN  # level 1, run 1
    state, stuffed = _push_bits(after_brs, FD_DLC_LENGTHS.index(length), 5)  # ESI = 0, DLC
    if length % 2:
        return _byte_rows()[state], stuffed, struct.Struct(f">{length}B").unpack
    return _word_rows()[state], stuffed, struct.Struct(f">{length // 2}H").unpack


@functools.cache
def fd_arbitration_stuff_bits(identifier: int) -> int:
    """Stuff bits an FD frame sends at the nominal rate: start of frame to bit-rate switch."""
    # after the identifier: RRS 0, IDE 0, FDF 1, reserved 0, BRS 1
    return _push_bits(_START_OF_FRAME, identifier << 5 | 0b00101, 16)[1]


def fd_data_stuff_bits(data: bytes) -> int:
    """Dynamic stuff bits an FD frame sends at the data rate: ESI to the end of the payload."""
    row, count, chunks = _fd_data_start(len(data))
    for chunk in chunks(data):
        row, stuffed = row[chunk]
        count += stuffed
    return count


@functools.cache
def _crc15_table() -> tuple[int, ...]:
    return tuple(_crc15_shift(byte << 7, 8) for byte in range(256))


def _crc15_shift(register: int, bits: int) -> int:
    for _ in range(bits):
        register = register << 1 ^ (_CRC15_POLYNOMIAL if register & 0x4000 else 0)
        register &= 0x7FFF
    return register


def classic_crc15(identifier: int, data: bytes) -> int:
    """The checksum of a classic data frame: start of frame to the end of the payload."""
    table = _crc15_table()
    # 19 bits of header; leading zeros leave a register that starts at zero as it is
    header = identifier << 7 | len(data)
    register = 0
    for byte in header.to_bytes(3, "big") + data:
        register = register << 8 & 0x7FFF ^ table[register >> 7 ^ byte]
    return register


def classic_stuff_bits(identifier: int, data: bytes) -> int:
    """Stuff bits of a classic data frame: start of frame to the end of its CRC-15."""
    # 34 + 8 s bits from start of frame on: one dominant, one identifier bit, then whole bytes
    bits = identifier << 7 | len(data)
    bits = bits << 8 * len(data) | int.from_bytes(data, "big")
    bits = bits << 15 | classic_crc15(identifier, data)
    state, count = _push(_START_OF_FRAME, identifier >> 10)
    rest = bits & ((1 << 32 + 8 * len(data)) - 1)
    row: _Row = _byte_rows()[state]
    for byte in rest.to_bytes(4 + len(data), "big"):
        row, stuffed = row[byte]
        count += stuffed
    return count + _pending(row)


def _pending(row: _Row) -> int:
    """1 if a run of five awaits its stuff bit, else 0."""
    rows = _byte_rows()
    return int(any(row is rows[level * STUFF_RUN + STUFF_RUN - 1] for level in (0, 1)))

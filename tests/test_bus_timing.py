"""Bus time: the closed forms, the exact count, and a naive bit-by-bit encoder as the oracle."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfms_can.bus.stuffing import classic_crc15
from rfms_can.bus.timing import BusTiming
from rfms_can.errors import BusError
from rfms_can.wire.frame import Frame

FD_1_5 = BusTiming(1_000_000, 5_000_000)
CLASSIC = BusTiming(1_000_000, None)
FD_LENGTHS = (*range(9), 12, 16, 20, 24, 32, 48, 64)


def bits_of(value: int, width: int) -> list[int]:
    return [value >> shift & 1 for shift in range(width - 1, -1, -1)]


def stuff(bits: list[int], stuff_after_last: bool) -> list[tuple[int, int]]:
    """The bits as sent: (level, index of the bit it is or follows); ISO 11898-1, 10.5."""
    sent: list[tuple[int, int]] = []
    run = 0
    for index, bit in enumerate(bits):
        run = run + 1 if sent and sent[-1][0] == bit else 1
        sent.append((bit, index))
        if run == 5 and (index < len(bits) - 1 or stuff_after_last):
            sent.append((1 - bit, index))
            run = 1
    return sent


def naive_fd_ns(frame: Frame, nominal_bit_ns: int, data_bit_ns: int) -> int:
    dlc = FD_LENGTHS.index(len(frame.data))
    arbitration = [0, *bits_of(frame.id, 11), 0, 0, 1, 0, 1]
    payload = [bit for byte in frame.data for bit in bits_of(byte, 8)]
    sent = stuff([*arbitration, 0, *bits_of(dlc, 4), *payload], stuff_after_last=False)
    nominal = sum(1 for _, index in sent if index < len(arbitration))
    crc = 17 if len(frame.data) <= 16 else 21
    fixed = 1 + (4 + crc) // 4
    data = len(sent) - nominal + 4 + crc + fixed
    return (nominal + 1 + 2 + 7 + 3) * nominal_bit_ns + data * data_bit_ns


def naive_crc15(bits: list[int]) -> int:
    """The procedure printed in Bosch's CAN 2.0 specification."""
    register = 0
    for bit in bits:
        feedback = bit ^ register >> 14 & 1
        register = register << 1 & 0x7FFF
        if feedback:
            register ^= 0x4599
    return register


def naive_classic_ns(frame: Frame, bit_ns: int) -> int:
    payload = [bit for byte in frame.data for bit in bits_of(byte, 8)]
    body = [0, *bits_of(frame.id, 11), 0, 0, 0, *bits_of(len(frame.data), 4), *payload]
    body += bits_of(naive_crc15(body), 15)
    return (len(stuff(body, stuff_after_last=True)) + 1 + 2 + 7 + 3) * bit_ns


identifiers = st.integers(0, 0x7FF)
# bytes that make long runs are what stuffing is about
payload_bytes = st.sampled_from([0x00, 0xFF, 0x0F, 0xF0, 0x1F, 0x83, 0xC1]) | st.integers(0, 255)


@st.composite
def fd_frames(draw: st.DrawFn) -> Frame:
    length = draw(st.sampled_from(FD_LENGTHS))
    payload = draw(st.lists(payload_bytes, min_size=length, max_size=length))
    return Frame(draw(identifiers), bytes(payload))


classic_frames = st.builds(
    lambda identifier, payload: Frame(identifier, bytes(payload), fd=False),
    identifiers,
    st.lists(payload_bytes, max_size=8),
)


@pytest.mark.parametrize(
    ("length", "microseconds"), [(8, 56.6), (24, 89.6), (32, 105.6), (48, 137.6), (64, 169.6)]
)
def test_worst_case_fd_frames_on_1_and_5_mbit_per_s(length: int, microseconds: float) -> None:
    assert FD_1_5.worst_case_ns(length) == round(microseconds * 1000)


@pytest.mark.parametrize("length", range(9))
def test_worst_case_classic_frame_is_55_plus_10_s_bits(length: int) -> None:
    assert CLASSIC.worst_case_ns(length, fd=False) == (55 + 10 * length) * 1000


@given(fd_frames())
def test_exact_fd_time_is_the_naive_encoders(frame: Frame) -> None:
    assert FD_1_5.exact_ns(frame) == naive_fd_ns(frame, 1000, 200)


@given(classic_frames)
def test_exact_classic_time_is_the_naive_encoders(frame: Frame) -> None:
    assert CLASSIC.exact_ns(frame) == naive_classic_ns(frame, 1000)


@given(st.one_of(fd_frames(), classic_frames), st.sampled_from([1_000_000, 3_000_000, 8_000_000]))
def test_no_frame_is_longer_than_the_worst_case(frame: Frame, data_bit_rate: int) -> None:
    timing = BusTiming(1_000_000, data_bit_rate)
    assert timing.exact_ns(frame) <= timing.worst_case_ns(len(frame.data), frame.fd)


def test_alternating_runs_reach_the_classic_worst_case_within_the_crc() -> None:
    # 1 + 4 zeros, then 1111 0000 ...: a stuff bit every four bits up to the checksum
    frame = Frame(0x078, bytes([0x3C] * 8), fd=False)
    free = CLASSIC.exact_ns(Frame(0x555, bytes([0x55] * 8), fd=False))
    assert free < CLASSIC.exact_ns(frame) <= CLASSIC.worst_case_ns(8, fd=False)


def test_a_run_that_ends_the_fd_payload_costs_nothing_before_the_fixed_stuff_bit() -> None:
    run_of_four, run_of_five = Frame(0x555, b"\x50"), Frame(0x555, b"\xa0")
    assert FD_1_5.exact_ns(run_of_four) == FD_1_5.exact_ns(run_of_five)
    # followed by a further byte the pending stuff bit is sent
    assert FD_1_5.exact_ns(Frame(0x555, b"\xa0\xaa")) - FD_1_5.exact_ns(run_of_five) == 9 * 200


def test_crc15_of_an_empty_frame_with_identifier_zero_is_zero() -> None:
    assert classic_crc15(0, b"") == 0
    assert classic_crc15(0x123, b"\x01\x02") == naive_crc15(
        bits_of(0x123 << 7 | 2, 19) + bits_of(0x0102, 16)
    )


@pytest.mark.parametrize(
    ("nominal", "data"), [(0, None), (2_000_000, None), (1_000_000, 500_000), (500_000, 9_000_000)]
)
def test_impossible_bit_rates_are_refused(nominal: int, data: int | None) -> None:
    with pytest.raises(BusError, match="bit rate"):
        BusTiming(nominal, data)


def test_a_classic_bus_carries_no_fd_frame() -> None:
    with pytest.raises(BusError, match="classic bus"):
        CLASSIC.exact_ns(Frame(1, b"12345678"))
    with pytest.raises(BusError, match="classic bus"):
        CLASSIC.worst_case_ns(8)
    with pytest.raises(BusError, match="split it"):
        CLASSIC.worst_case_ns(64, fd=False)

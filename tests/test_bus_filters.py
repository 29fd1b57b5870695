"""Acceptance filters pass what they shall, and nothing else."""

from hypothesis import given
from hypothesis import strategies as st

from rfms_can.bus.filters import cover
from rfms_can.wire.contract import Wire

IDENTIFIERS = st.sets(st.integers(0, 0x7FF), max_size=200)


def passes(filters: list[tuple[int, int]], identifier: int) -> bool:
    return any(identifier & mask == wanted & mask for wanted, mask in filters)


@given(IDENTIFIERS)
def test_a_cover_passes_exactly_the_identifiers(identifiers: set[int]) -> None:
    filters = cover(identifiers)
    assert {i for i in range(0x800) if passes(filters, i)} == identifiers


def test_all_identifiers_need_one_filter_and_a_pair_one() -> None:
    assert cover(range(0x800)) == [(0, 0)]
    assert cover([0x100, 0x101]) == [(0x100, 0x7FE)]


def test_all_but_the_contract_fits_a_socket(wire: Wire) -> None:
    known = {codec.id for codec in wire.codecs.values()}
    assert len(cover(set(range(0x800)) - known)) < 512  # CAN_RAW_FILTER_MAX

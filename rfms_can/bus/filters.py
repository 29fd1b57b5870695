"""Acceptance filters: a set of identifiers as few (identifier, mask) pairs, as controllers have."""

from collections.abc import Iterable

Filter = tuple[int, int]
"""(identifier, mask): a frame passes if its identifier equals this one where the mask is 1."""

_ALL_BITS = 0x7FF


def cover(identifiers: Iterable[int]) -> list[Filter]:
    """Filters that pass exactly these 11-bit identifiers: aligned blocks, the largest that fit."""
    wanted = set(identifiers)
    filters: list[Filter] = []
    for start in sorted(wanted):
        if start not in wanted:
            continue
        size = 1
        while start % (2 * size) == 0 and all(start + size + i in wanted for i in range(size)):
            size *= 2
        wanted.difference_update(range(start, start + size))
        filters.append((start, _ALL_BITS & ~(size - 1)))
    return filters

"""The table of faults: whole, and each variant can be provoked."""

import pytest

from rfms_can.faults import frames
from rfms_can.faults.catalogue import INJECTORS
from rfms_can.faults.context import Seam
from rfms_can.faults.processes.injectors import PROCESS_INJECTORS, Shows
from rfms_can.faults.table import (
    BUS,
    FOREIGN,
    GOAL,
    GOES_ON,
    JOINT,
    ROWS,
    Expected,
    State,
    Variant,
    Where,
    variants,
)

ALL = variants()


def test_there_are_39_rows_each_with_a_variant() -> None:
    assert list(ROWS) == list(range(1, 40))
    assert all(row.variants for row in ROWS.values())


def test_names_of_variants_are_unique() -> None:
    names = [variant.name for _, variant in ALL]
    assert len(names) == len(set(names))


def test_every_injector_is_used_and_every_variant_has_one() -> None:
    def used(where: Where) -> set[str]:
        return {variant.fault for _, variant in ALL if variant.where is where}

    assert set(INJECTORS) == used(Where.SIM)
    assert set(PROCESS_INJECTORS) == used(Where.PROCESSES)
    assert {injector.shows for injector in PROCESS_INJECTORS.values()} == set(Shows)
    assert {seam for seam in Seam if any(i.seam is seam for i in INJECTORS.values())} == set(Seam)


@pytest.mark.parametrize(("row", "variant"), ALL, ids=[f"{r} {v.name}" for r, v in ALL])
def test_each_variant_has_a_bound_a_reaction_and_a_culprit(row: int, variant: Variant) -> None:
    bound_of_rows = {"-", "0", "before enable", "before swap"}
    at_once = variant.state is State.START or variant.expected is Expected.REJECTED
    assert variant.bound > 0 or ROWS[row].bound in bound_of_rows or at_once
    if variant.expected in GOES_ON:
        assert variant.culprit == "", "where nothing stops no one is named"
    else:
        assert variant.culprit in {JOINT, FOREIGN, BUS, GOAL, "master", "plant"}
    assert (variant.state is State.START) == (variant.expected is Expected.REFUSED)


def test_a_burst_is_longer_than_its_bound() -> None:
    assert max(v.bound for v in ROWS[2].variants) < frames.BURST

"""docs/soak.md: what it says has been run was run, and nothing tripped."""

from pathlib import Path

import pytest
from soak.kinds import KINDS
from soak.results import FILE
from soak.table import LONG, MEMORY_MB, beyond_bounds, grown, shortfall
from soak.trial import Result

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "soak.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def soak() -> list[Result]:
    return FILE.read(ROOT / "docs" / "data" / "soak.jsonl")[1]


def test_a_soak_that_is_short_is_not_told_as_a_whole_one(soak: list[Result]) -> None:
    assert (shortfall(soak) == "") is ("No whole soak yet" not in PAGE)
    assert "10 of 200 programs" in shortfall(soak[:10])


def test_the_soak_is_of_all_kinds(soak: list[Result]) -> None:
    made = {(result.kind, result.arm) for result in soak if result.worn}
    assert made == {(name, arm) for name, kind in KINDS.items() for arm in kind.arms}


def test_nothing_tripped_in_the_soak(soak: list[Result]) -> None:
    assert [result.job.name for result in soak if result.trips] == []
    assert beyond_bounds(soak) == []


def test_the_number_of_the_cycle_went_on_from_0_in_the_soak(soak: list[Result]) -> None:
    assert {result.arm for result in soak if result.passed} == {"puma260", "puma560"}


def test_memory_is_flat_in_the_soak(soak: list[Result]) -> None:
    long = [result for result in soak if result.kind == LONG]
    assert min(result.cycles for result in long) > 30_000
    assert max(map(grown, long)) <= MEMORY_MB

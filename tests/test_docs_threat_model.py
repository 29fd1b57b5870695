"""docs/threat-model.md: each claim names what shows it; rows are those of docs/faults.md."""

import re
from pathlib import Path

import pytest

from rfms_can.faults.table import ROWS

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "threat-model.md").read_text(encoding="utf-8")
DEFENDED = PAGE.partition("## What is defended")[2].partition("\n## ")[0]
CLAIMS = [line.split("|")[1:-1] for line in DEFENDED.splitlines() if line.startswith("| ")][1:]


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim[0].strip()[:40])
def test_each_claim_names_a_row_a_page_or_a_test_that_there_is(claim: list[str]) -> None:
    shown = claim[2]
    tests = re.findall(r"`(tests/\w+\.py)`", shown)
    pages = re.findall(r"\]\(([\w-]+\.md)", shown)
    assert tests or pages
    assert [name for name in tests if not (ROOT / name).is_file()] == []
    assert [name for name in pages if not (ROOT / "docs" / name).is_file()] == []


def test_rows_are_those_of_the_table_of_faults() -> None:
    told = set()
    for words in re.findall(r"rows? ([\d, to]+)", PAGE):
        for first, last in re.findall(r"(\d+)(?: to (\d+))?", words):
            told |= set(range(int(first), int(last or first) + 1))
    assert len(CLAIMS) > 15
    assert {1, 7, 12, 35, 36, 37, 38} <= told <= set(ROWS)


def test_what_is_not_defended_is_said() -> None:
    rest = PAGE.partition("## What is not defended")[2]
    for words in ("The bus knows no sender", "no safety function", "holder of the lease"):
        assert words in rest

"""docs/departures.md: every departure has its section, and the code it points at exists."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "departures.md").read_text(encoding="utf-8")
COLUMNS = ["the thesis", "section", "here", "why", "where"]


def rows() -> list[list[str]]:
    lines = [line for line in PAGE.splitlines() if line.startswith("|")]
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return [row for row in cells if len(row) == len(COLUMNS) and set(row) != {"---"}]


ROWS = [row for row in rows() if row != COLUMNS]


def test_every_table_has_the_same_columns() -> None:
    assert rows().count(COLUMNS) == 6
    assert len(ROWS) >= 35


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0][:40])
def test_a_departure_says_all_and_its_code_exists(row: list[str]) -> None:
    assert all(row)
    paths = re.findall(r"`([a-z_/]+(?:\.py|/))`", row[4])
    assert paths
    directory = ROOT / "rfms_can"
    for path in paths:
        beside = directory if "/" in path else (directory / paths[0]).parent
        assert (beside / path).exists(), path


def test_links_and_pictures_exist() -> None:
    for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", PAGE):
        assert (ROOT / "docs" / target).exists(), target


def test_both_blends_are_shown_side_by_side() -> None:
    for number in (3, 4, 5):
        assert f"(images/fig_3_{number}.png)" in PAGE
        assert f"(images/fig_3_{number}_thesis_blend.png)" in PAGE

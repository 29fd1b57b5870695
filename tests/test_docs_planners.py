"""docs/planners.md: its command prints what it says, but for what the machine decides."""

import re
from pathlib import Path

import pytest
from planners.bench import PLANNERS, compare
from planners.table import COLUMNS, cells, reasons
from planners.task import TASKS

from rfms_can.arm import PUMA_260

PAGE = (Path(__file__).parents[1] / "docs" / "planners.md").read_text(encoding="utf-8")
(PRINTED,) = re.findall(r"```console\n(.*?)```", PAGE, re.DOTALL)
MEASURED = [not name.endswith(("us", "ours", "ms")) for name in COLUMNS]
"""Columns that are the same on every machine."""


@pytest.mark.parametrize("task", TASKS)
def test_the_table_is_what_the_planners_do(task: str) -> None:
    (block,) = re.findall(rf"^{task}: .*?\n\n", PRINTED, re.DOTALL | re.MULTILINE)
    told = {}
    for line in block.splitlines():
        if line.startswith("│"):
            name, *printed = (cell.strip() for cell in line.strip("│").split("│"))
            told[name] = [cell for cell, same in zip(printed, MEASURED, strict=True) if same]
    assert list(told) == list(PLANNERS)
    rows = compare(TASKS[task](PUMA_260), list(PLANNERS), 0.004, 1)
    for row in rows:
        if row.figures is None:
            assert set(told[row.planner]) == {"-"}
        else:
            pairs = zip(cells(row.figures), MEASURED, strict=True)
            assert told[row.planner] == [cell for cell, same in pairs if same]
    for reason in reasons(rows):
        assert reason in block.splitlines()

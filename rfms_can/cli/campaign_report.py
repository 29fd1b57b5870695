"""Output of ``rfms campaign``: conditions and a table, for a terminal, in Markdown, or as JSON."""

import json
import sys
from collections.abc import Sequence
from typing import Any

from rich.console import Console

from rfms_can.analysis.campaign.conditions import Conditions, as_plain
from rfms_can.analysis.campaign.summary import Row, markdown, table


def print_campaign(conditions: Conditions, rows: Sequence[Row], *, as_json: bool) -> None:
    """To the standard output."""
    if as_json:
        report = {"conditions": as_plain(conditions), "rows": [_plain(row) for row in rows]}
        json.dump(report, sys.stdout)
        sys.stdout.write("\n")
    elif sys.stdout.isatty():
        console = Console()
        for line in conditions.lines:
            console.print(line, highlight=False)
        console.print(table(rows))
    else:
        sys.stdout.write("\n".join(f"- {line}" for line in conditions.lines) + "\n\n")
        sys.stdout.write(markdown(rows))


def _plain(row: Row) -> dict[str, Any]:
    numbers = row._asdict()
    return {**numbers.pop("group")._asdict(), **numbers}

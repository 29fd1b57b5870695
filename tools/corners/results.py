"""The file of a campaign of corners: its conditions, then a line of JSON for each corner."""

import json
from pathlib import Path
from typing import Final, NamedTuple

from corners.run import Result
from rfms_can.errors import RfmsError

KEPT: Final = "docs/data/corner_campaign.jsonl"
"""The campaign that docs/corners.md tells of."""

DIGITS: Final = 7
"""Significant digits that are kept."""


class Conditions(NamedTuple):
    """What all corners of a file have in common: largest deviation, m, and set-points a second."""

    deviation: float
    rate: float


def read(file: Path, conditions: Conditions | None = None) -> tuple[Conditions, list[Result]]:
    """Conditions and corners of a file, both empty-handed if there is none.

    A last line that was cut off is dropped from the file as well.

    Raises:
        RfmsError: it is of other ``conditions``, or is no such file.
    """
    if not file.exists():
        if conditions is None:
            raise RfmsError(f"{file} does not exist: run tools/corner_campaign.py --keep {file}")
        return conditions, []
    text = file.read_text(encoding="utf-8")
    whole = text[: text.rfind("\n") + 1]
    if whole != text:
        file.write_text(whole, encoding="utf-8")
    try:
        first, *lines = [json.loads(line) for line in whole.splitlines()]
        theirs, results = Conditions(**first), [Result(**line) for line in lines]
    except (ValueError, TypeError) as error:
        raise RfmsError(
            f"{file} is not a file of corners ({error}): give another --keep"
        ) from error
    if conditions is not None and theirs != conditions:
        raise RfmsError(f"{file} holds corners of {theirs}, not {conditions}: give another --keep")
    return theirs, results


def append(file: Path, conditions: Conditions, result: Result) -> None:
    """Add a corner; a new file begins with the conditions."""
    lines = [] if file.exists() else [conditions._asdict()]
    lines.append({name: _short(value) for name, value in result._asdict().items()})
    with file.open("a", encoding="utf-8") as out:
        out.writelines(json.dumps(line) + "\n" for line in lines)


def _short(value: object) -> object:
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value

"""The file of a campaign: what all its runs have in common, then a line of JSON for each run.

Runs that a file has are not made again, so that a campaign that was interrupted goes on.
"""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, Generic, NamedTuple, TypeVar

from rfms_can.errors import RfmsError

Conditions = TypeVar("Conditions", bound=NamedTuple)
Result = TypeVar("Result", bound=NamedTuple)

DIGITS: Final = 7
"""Significant digits that are kept."""


class KeptResults(Generic[Conditions, Result]):
    """Reads and writes the files of one campaign.

    Args:
        what: its runs, in one word, for messages.
        tool: that makes them.
        conditions, result: classes of the first line and of the others.
    """

    def __init__(
        self,
        what: str,
        tool: str,
        conditions: Callable[..., Conditions],
        result: Callable[..., Result],
    ) -> None:
        self._what: Final = what
        self._tool: Final = tool
        self._conditions: Final = conditions
        self._result: Final = result

    def read(
        self, file: Path, conditions: Conditions | None = None
    ) -> tuple[Conditions, list[Result]]:
        """Conditions and results of a file; none yet where there is no file.

        A last line that was cut off is dropped from the file as well.

        Raises:
            RfmsError: it is of other ``conditions``, or is no such file.
        """
        if not file.exists():
            if conditions is None:
                raise RfmsError(f"{file} does not exist: run {self._tool} --keep {file}")
            return conditions, []
        text = file.read_text(encoding="utf-8")
        whole = text[: text.rfind("\n") + 1]
        if whole != text:
            file.write_text(whole, encoding="utf-8")
        try:
            first, *lines = [json.loads(line) for line in whole.splitlines()]
            theirs = self._conditions(**first)
            results = [self._result(**line) for line in lines]
        except (ValueError, TypeError) as error:
            raise RfmsError(
                f"{file} is not a file of {self._what} ({error}): give another --keep"
            ) from error
        if conditions is not None and theirs != conditions:
            raise RfmsError(
                f"{file} holds {self._what} of {theirs}, not {conditions}: give another --keep"
            )
        return theirs, results

    def append(self, file: Path, conditions: Conditions, result: Result) -> None:
        """Add a result; a new file begins with the conditions."""
        lines: list[dict[str, Any]] = [] if file.exists() else [dict(conditions._asdict())]
        lines.append({name: _short(value) for name, value in result._asdict().items()})
        with file.open("a", encoding="utf-8") as out:
            out.writelines(json.dumps(line) + "\n" for line in lines)


def _short(value: object) -> object:
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value

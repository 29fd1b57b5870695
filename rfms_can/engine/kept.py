"""The file of a campaign: what all its runs have in common, then a line of JSON for each run.

Runs that a file has are not made again, so that a campaign that was interrupted goes on. Records
are named tuples or structs of msgspec. Of a named tuple floats are kept to a few digits.
"""

import json
import os
from collections.abc import Callable, Hashable, Sequence
from functools import cache
from pathlib import Path
from typing import Any, Final, Generic, TypeVar, cast, get_type_hints

import msgspec

from rfms_can.errors import EngineError

C = TypeVar("C")
R = TypeVar("R")

DIGITS: Final = 7
"""Significant digits that are kept of a named tuple's floats."""


class ResultFile(Generic[C, R]):
    """Reads and writes the files of one campaign.

    Args:
        what: its runs, in one word, for messages.
        tool: that makes them.
        conditions: class of the first line; None for files that have runs only, whose conditions
            are None too.
        result: class of the others.
        digits: significant digits of a named tuple's floats.
    """

    def __init__(
        self,
        what: str,
        tool: str,
        conditions: type[C] | None,
        result: type[R],
        digits: int = DIGITS,
    ) -> None:
        self._what: Final = what
        self._tool: Final = tool
        self._conditions: Final = conditions
        self._result: Final = result
        self._digits: Final = digits

    def read(self, file: Path, conditions: C | None = None) -> tuple[C, list[R]]:
        """Conditions and results of a file; none yet where there is no file.

        A last line that was cut off is dropped from the file as well: that run is made again.

        Args:
            file: to read.
            conditions: that it must have.

        Raises:
            EngineError: it is of other ``conditions``, is no such file, or cannot be read.
        """
        try:
            text = file.read_bytes()
        except FileNotFoundError as error:
            if conditions is None and self._conditions is not None:
                raise EngineError(
                    f"{file} does not exist: run {self._tool} --keep {file}"
                ) from error
            return cast("C", conditions), []
        except OSError as error:
            raise EngineError(f"results {file}: {error.strerror}") from error
        whole = text[: text.rfind(b"\n") + 1]
        lines = whole.splitlines()
        theirs = self._head(lines, file)
        results = self._runs(lines, file)
        if conditions is not None:
            self._compare(theirs, conditions, file)
        if whole != text:
            os.truncate(file, len(whole))
        return theirs, results

    def append(self, file: Path, conditions: C, result: R) -> None:
        """Add a result; a new file begins with the conditions.

        Raises:
            EngineError: it cannot be written.
        """
        lines = [] if conditions is None or file.exists() else [self._line(conditions)]
        lines.append(self._line(result))
        try:
            with file.open("ab") as out:
                out.write(b"".join(lines))
        except OSError as error:
            raise EngineError(f"results {file}: {error.strerror}") from error

    def open(self, file: Path | None, conditions: C) -> "Kept[C, R]":
        """The results of a campaign, in a file or, without one, in memory only.

        Raises:
            EngineError: the file's runs were made under other conditions, or it cannot be read or
                written; nothing in it is lost.
        """
        results: list[R] = []
        if file is not None:
            results = self.read(file, conditions)[1]
            if not file.exists():
                self.write(file, conditions, [])
        return Kept(self, file, conditions, results)

    def write(self, file: Path, conditions: C, results: Sequence[R]) -> None:
        """Write a whole file, or leave it as it was.

        Raises:
            EngineError: it cannot be written.
        """
        head = [] if conditions is None else [self._line(conditions)]
        new = file.with_name(file.name + ".new")
        try:
            new.write_bytes(b"".join([*head, *map(self._line, results)]))
            new.replace(file)
        except OSError as error:
            raise EngineError(f"results {file}: {error.strerror}") from error

    def _head(self, lines: list[bytes], file: Path) -> C:
        if self._conditions is None:
            return cast("C", None)
        try:
            return _record(self._conditions, lines.pop(0))
        except (ValueError, TypeError, IndexError) as error:
            raise EngineError(
                f"{file} is not a file of {self._what}: its first line has no conditions "
                f"({error}); give another --keep"
            ) from error

    def _runs(self, lines: list[bytes], file: Path) -> list[R]:
        runs, first = [], 1 if self._conditions is None else 2
        for number, line in enumerate(lines, start=first):
            try:
                runs.append(_record(self._result, line))
            except (ValueError, TypeError) as error:
                raise EngineError(
                    f"{file}, line {number} is not one of the {self._what} ({error}): give another "
                    f"--keep"
                ) from error
        return runs

    def _compare(self, theirs: C, ours: C, file: Path) -> None:
        for name, value in _plain(ours, self._digits).items():
            there = _plain(theirs, self._digits)[name]
            if there != value:
                raise EngineError(
                    f"{file} holds {self._what} with {name} {there}, not {value}: give another "
                    f"--keep"
                )

    def _line(self, record: object) -> bytes:
        if isinstance(record, msgspec.Struct):
            return msgspec.json.encode(record) + b"\n"
        return json.dumps(_plain(record, self._digits)).encode() + b"\n"


class Kept(Generic[C, R]):
    """Results of a campaign, earlier ones and new ones.

    Attributes:
        file: that has them, or None.
        results: all of them, in the order they came.
    """

    def __init__(
        self, kind: ResultFile[C, R], file: Path | None, conditions: C, results: list[R]
    ) -> None:
        self._kind = kind
        self._conditions = conditions
        self.file: Final = file
        self.results: Final = results

    def add(self, result: R) -> None:
        """Add a result; it is in the file when this returns."""
        self.results.append(result)
        if self.file is not None:
            self._kind.append(self.file, self._conditions, result)

    def arrange(self, order: Sequence[Hashable], key: Callable[[R], Hashable]) -> None:
        """Put results in the order of their jobs, among the places that they have.

        So the file of a campaign that is complete is the same, whatever computed it, and however
        often it was interrupted. A file that is in order is not touched.

        Args:
            order: keys of results, in the order they are to have; others keep their places.
            key: of a result.
        """
        rank = {key: number for number, key in enumerate(order)}
        places = [n for n, result in enumerate(self.results) if key(result) in rank]
        sorted_results = sorted(
            (self.results[n] for n in places), key=lambda result: rank[key(result)]
        )
        before = list(self.results)
        for place, result in zip(places, sorted_results, strict=True):
            self.results[place] = result
        if self.file is not None and any(
            a is not b for a, b in zip(before, self.results, strict=True)
        ):
            self._kind.write(self.file, self._conditions, self.results)


def _plain(record: object, digits: int) -> dict[str, Any]:
    """A record as a dictionary."""
    if isinstance(record, msgspec.Struct):
        return msgspec.structs.asdict(record)
    fields: dict[str, Any] = record._asdict()  # type: ignore[attr-defined]
    return {name: _short(value, digits) for name, value in fields.items()}


def _short(value: object, digits: int) -> object:
    if hasattr(value, "_asdict"):
        return _plain(value, digits)
    return float(f"{value:.{digits}g}") if isinstance(value, float) else value


def _record(kind: type[R], line: bytes) -> R:
    """A record from its line.

    Raises:
        ValueError, TypeError: it is none.
    """
    if issubclass(kind, msgspec.Struct):
        try:
            return msgspec.json.decode(line, type=kind)
        except msgspec.DecodeError as error:
            raise ValueError(str(error)) from error
    return _named_tuple(kind, json.loads(line))


def _named_tuple(kind: type[R], fields: Any) -> R:
    if not isinstance(fields, dict):
        raise ValueError("no JSON object")
    nested = _nested(cast("Hashable", kind))
    made = {
        name: _named_tuple(nested[name], value) if name in nested else value
        for name, value in fields.items()
    }
    return kind(**made)


@cache
def _nested(kind: Any) -> dict[str, type]:
    """Fields of a named tuple that are named tuples themselves."""
    return {name: of for name, of in get_type_hints(kind).items() if hasattr(of, "_fields")}

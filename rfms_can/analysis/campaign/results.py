"""The file of a campaign's results: conditions, then a line of JSON for each run."""

import os
from collections.abc import Iterator
from pathlib import Path

import msgspec

from rfms_can.analysis.campaign.conditions import Conditions, conditions_of
from rfms_can.analysis.campaign.job import Insertion
from rfms_can.errors import RfmsError

_DECODER = msgspec.json.Decoder(Insertion)


class Results:
    """Results of the runs, in a file or, without one, in memory only.

    Raises:
        RfmsError: the file's runs were made under other conditions, or it cannot be read or
            written; nothing in it is lost.
    """

    def __init__(self, conditions: Conditions, file: Path | None = None) -> None:
        self._file = file
        self.runs: list[Insertion] = []
        if file is None:
            return
        try:
            if file.exists():
                theirs, self.runs = read(file)
                conditions.check(theirs, file)
                _end_with_a_line(file)
            else:
                file.write_bytes(msgspec.json.encode(conditions) + b"\n")
        except OSError as error:
            raise RfmsError(f"results {file}: {error.strerror}") from error

    def add(self, run: Insertion) -> None:
        """Add a run; it is on the disk when this returns."""
        self.runs.append(run)
        if self._file is not None:
            with self._file.open("ab") as file:
                file.write(msgspec.json.encode(run) + b"\n")


def read(file: Path) -> tuple[Conditions, list[Insertion]]:
    """Conditions and runs of a file; a last line that was cut off is left out.

    Raises:
        OSError: it cannot be read.
        RfmsError: it is not a campaign file.
    """
    first, *lines = file.read_bytes().split(b"\n")
    return conditions_of(first, file), list(_runs(lines, file))


def _end_with_a_line(file: Path) -> None:
    """Drop a truncated last line after an interruption: that run is repeated."""
    whole = file.read_bytes().rfind(b"\n") + 1
    os.truncate(file, whole)


def _runs(lines: list[bytes], file: Path) -> Iterator[Insertion]:
    for number, line in enumerate(lines[:-1], start=2):
        try:
            yield _DECODER.decode(line)
        except msgspec.DecodeError as error:
            raise RfmsError(f"{file}, line {number} is not a campaign run: {error}") from error

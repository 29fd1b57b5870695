"""The file of a campaign's results: of which code, then a line of JSON for each trial."""

import hashlib
import os
from pathlib import Path
from typing import Final

import msgspec

from rfms_can.errors import RfmsError
from rfms_can.faults.trial import Result, Trial
from rfms_can.wire.codec import database_path

PACKAGE: Final = Path(__file__).parents[1]
_DECODER: Final = msgspec.json.Decoder(Result)
_HEX_DIGITS: Final = 12


class Conditions(msgspec.Struct, frozen=True):
    """What all trials of a file have in common.

    Attributes:
        code: digest of the code and of the DBC that they were made with.
    """

    code: str


def digest() -> str:
    """Of the code: trials of other code are other ones. The command line and plots are no part."""
    hashed = hashlib.sha256(database_path().read_bytes())
    for path in sorted(PACKAGE.rglob("*.py")):
        name = path.relative_to(PACKAGE)
        if name.parts[0] not in _NOT_RUN:
            hashed.update(str(name).encode() + b"\0" + path.read_bytes())
    return hashed.hexdigest()[:_HEX_DIGITS]


_NOT_RUN: Final = ("cli", "analysis", "identification", "conform", "task", "link")
"""Rooms whose code no trial runs."""


class Results:
    """Results of trials, in a file or, without one, in memory only.

    Raises:
        RfmsError: the file's trials were made with other code, or it cannot be read or written;
            nothing in it is lost.
    """

    def __init__(self, file: Path | None = None) -> None:
        self._file = file
        self.results: dict[Trial, Result] = {}
        if file is None:
            return
        ours = Conditions(digest())
        try:
            if file.exists():
                theirs, results = read(file)
                if theirs != ours:
                    raise RfmsError(
                        f"{file} holds trials of other code (digest {theirs.code}, now "
                        f"{ours.code}): give another --keep"
                    )
                self.results = {trial_of(result): result for result in results}
                os.truncate(file, file.read_bytes().rfind(b"\n") + 1)
            else:
                file.write_bytes(msgspec.json.encode(ours) + b"\n")
        except OSError as error:
            raise RfmsError(f"--keep {file}: {error.strerror}") from error

    def add(self, result: Result) -> None:
        """Add a result; it is on the disk when this returns."""
        self.results[trial_of(result)] = result
        if self._file is not None:
            with self._file.open("ab") as file:
                file.write(msgspec.json.encode(result) + b"\n")


def trial_of(result: Result) -> Trial:
    """The trial that a result is of."""
    return Trial(result.row, result.variant, result.arm, result.seed)


def read(file: Path) -> tuple[Conditions, list[Result]]:
    """Conditions and results of a file; a last line that was cut off is left out.

    Raises:
        OSError: it cannot be read.
        RfmsError: it is no file of faults.
    """
    first, *lines = file.read_bytes().split(b"\n")
    try:
        conditions = msgspec.json.decode(first, type=Conditions)
        return conditions, [_DECODER.decode(line) for line in lines[:-1]]
    except msgspec.DecodeError as error:
        raise RfmsError(f"{file} is not a file of faults: {error}") from error

"""The file of a campaign's results: of which code, then a line of JSON for each trial."""

import hashlib
from pathlib import Path
from typing import Final

import msgspec

from rfms_can.bus.url import SIM
from rfms_can.engine import Kept, ResultFile
from rfms_can.faults.trial import Result, Trial
from rfms_can.wire.codec import database_path

PACKAGE: Final = Path(__file__).parents[1]
_HEX_DIGITS: Final = 12


class Conditions(msgspec.Struct, frozen=True):
    """What all trials of a file have in common.

    Attributes:
        code: digest of the code and of the DBC that they were made with.
        bus: that they were made on: sim, hub or vcan0.
    """

    code: str
    bus: str = SIM


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


RESULTS: Final = ResultFile("faults", "rfms faults", Conditions, Result)
read: Final = RESULTS.read


def kept_in(file: Path | None, bus: str = SIM) -> Kept[Conditions, Result]:
    """Results of today's code, in a file or, without one, in memory only.

    Raises:
        EngineError: the file's trials were made with other code or on another bus, or it cannot
            be read or written; nothing in it is lost.
    """
    return RESULTS.open(file, Conditions(digest(), bus))


def trial_of(result: Result) -> Trial:
    """The trial that a result is of."""
    return Trial(result.row, result.variant, result.arm, result.seed)

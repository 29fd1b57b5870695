"""The file of a soak: its conditions, then a line of JSON for each program."""

from typing import Final

import msgspec

from rfms_can.engine import ResultFile
from soak.trial import Result

KEPT: Final = "docs/data/soak.jsonl"
"""The soak that docs/soak.md tells of."""
WAY: Final = 1
"""Changes with the way programs are drawn or quantities are measured."""


class Conditions(msgspec.Struct, frozen=True):
    """What all programs of a file have in common: control rate, Hz, and the way they are drawn."""

    rate: float
    way: int = WAY


FILE: Final = ResultFile("programs", "tools/soak_campaign.py", Conditions, Result)
read = FILE.read

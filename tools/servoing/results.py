"""The file of a servoing campaign: its conditions, then a line of JSON for each run."""

from typing import Final, NamedTuple

from rfms_can.engine import ResultFile
from servoing.trial import Result

KEPT: Final = "docs/data/servoing_campaign.jsonl"
"""The campaign that docs/servoing.md tells of."""


class Conditions(NamedTuple):
    """What all runs of a file have in common: set-points a second."""

    rate: float


FILE: Final = ResultFile("runs", "tools/servoing_campaign.py", Conditions, Result)
read = FILE.read

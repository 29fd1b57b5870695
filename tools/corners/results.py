"""The file of a campaign of corners: its conditions, then a line of JSON for each corner."""

from typing import Final, NamedTuple

from corners.run import Result
from rfms_can.engine import ResultFile

KEPT: Final = "docs/data/corner_campaign.jsonl"
"""The campaign that docs/corners.md tells of."""


class Conditions(NamedTuple):
    """What all corners of a file have in common: largest deviation, m, and set-points a second."""

    deviation: float
    rate: float


FILE: Final = ResultFile("corners", "tools/corner_campaign.py", Conditions, Result)
read = FILE.read

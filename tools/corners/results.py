"""The file of a campaign of corners: its conditions, then a line of JSON for each corner."""

from typing import Final, NamedTuple

from kept_results import KeptResults

from corners.run import Result

KEPT: Final = "docs/data/corner_campaign.jsonl"
"""The campaign that docs/corners.md tells of."""


class Conditions(NamedTuple):
    """What all corners of a file have in common: largest deviation, m, and set-points a second."""

    deviation: float
    rate: float


_FILE: Final = KeptResults("corners", "tools/corner_campaign.py", Conditions, Result)
read, append = _FILE.read, _FILE.append

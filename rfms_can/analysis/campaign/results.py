"""The file of a campaign's results: conditions, then a line of JSON for each run."""

from typing import Final

from rfms_can.analysis.campaign.conditions import Conditions
from rfms_can.analysis.campaign.job import Insertion
from rfms_can.engine import ResultFile

RESULTS: Final = ResultFile("runs", "rfms campaign", Conditions, Insertion)
read: Final = RESULTS.read

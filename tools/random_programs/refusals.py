"""The file of refusals that were looked at, and what came out."""

from collections import Counter
from collections.abc import Sequence
from typing import Final, NamedTuple

from generated import table

from random_programs.results import Conditions
from rfms_can.engine import ResultFile

KEPT: Final = "docs/data/refusal_campaign.jsonl"
"""The campaign that docs/random-programs.md tells of."""


class Refusal(NamedTuple):
    """The first refusal of a program.

    Attributes:
        a, s: arm and seed.
        why: words of the refusal; "" where nothing was refused.
        due: what was found; "" if it was not due.
    """

    a: str
    s: int
    why: str
    due: str


FILE: Final = ResultFile("refusals", "tools/refusal_campaign.py", Conditions, Refusal)

FOUND: Final = {
    "no path": "a pose of its path has no solution, or a joint leaps",
    "a rule": "a rule, shown by the numbers of the message",
    "acceleration": "a joint passes its acceleration limit",
    "speed": "a joint passes its speed limit",
    "range": "a joint leaves its range, or a pose on the way has no solution",
    "": "not due",
}
"""What may be found, in the order of the table."""


def kind(due: str) -> str:
    """Which of ``FOUND`` words of evidence are."""
    if not due:
        return ""
    for head in ("no path", "a rule"):
        if due.startswith(head):
            return head
    if " rad/s2 at h" in due:
        return "acceleration"
    return "speed" if " rad/s at h" in due else "range"


def summary(results: Sequence[Refusal]) -> str:
    """How many were due, and by what, in Markdown."""
    refused = [each for each in results if each.why]
    counts = Counter(kind(each.due) for each in refused)
    rows = [(words, str(counts[found])) for found, words in FOUND.items()]
    arms = Counter(each.a for each in refused)
    of_arms = ", ".join(f"{arm} {count}" for arm, count in sorted(arms.items()))
    return f"{len(refused)} refusals ({of_arms})\n\n{table(('what was found', 'refusals'), rows)}"

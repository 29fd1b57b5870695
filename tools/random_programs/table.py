"""What came out of a campaign of random programs."""

from collections import Counter
from collections.abc import Sequence
from typing import Final

from generated import table

from random_programs.results import Brief, Conditions

BOUND: Final = 1.02
"""Largest acceleration of a commanded joint angle over its limit that is within the promise."""

COLUMNS: Final = (
    "arm",
    "programs",
    "accepted whole",
    "moves accepted",
    "broken promises",
    "peak acceleration",
    "peak speed",
    "programs with a lag",
    "cycles",
)


def summary(results: Sequence[Brief], conditions: Conditions) -> str:
    """Conditions, the table, and what was refused and mended, in Markdown."""
    arms = sorted({each.a for each in results})
    rows = [_row(arm, [each for each in results if each.a == arm]) for arm in arms]
    kinds = Counter(each.why for each in results if each.why)
    fixes = Counter(fix for each in results for fix in each.fix.split())
    refused = ", ".join(f"{kind} {count}" for kind, count in kinds.most_common())
    mended = ", ".join(f"{fix} {count}" for fix, count in fixes.most_common())
    return (
        f"{conditions.rate:g} Hz, mix {conditions.mix}, seeds {min(each.s for each in results)} "
        f"to {max(each.s for each in results)} of each arm\n\n"
        f"{table(COLUMNS, rows)}\n\n"
        f"First refusal of a program, by where the move goes: {refused}."
        + (f"\n\nRemedies that refusals offered and that were taken: {mended}." if mended else "")
    )


def broken(result: Brief) -> bool:
    """Whether the promise was broken: a fault, a stop, a remedy refused, or a limit passed."""
    return bool(result.bad) or result.acc > BOUND


def _row(arm: str, results: Sequence[Brief]) -> tuple[str, ...]:
    whole = sum(each.ok == each.n for each in results)
    moves, accepted = sum(each.n for each in results), sum(each.ok for each in results)
    return (
        arm,
        f"{len(results)}",
        f"{whole} ({whole / len(results):.1%})",
        f"{accepted} of {moves}",
        f"{sum(map(broken, results))}",
        f"{max(each.acc for each in results):.4f}",
        f"{max(each.v for each in results):.4f}",
        f"{sum(each.lag > 0 for each in results)}",
        f"{sum(each.c for each in results)}",
    )

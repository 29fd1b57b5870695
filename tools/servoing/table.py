"""What came out of a servoing campaign: one row for each arm and way of the part."""

from collections.abc import Sequence
from typing import Final

from generated import table

from servoing.results import Conditions
from servoing.trial import Result

BOUND: Final = 1.02
"""Largest acceleration of a commanded joint angle over its limit that is within the promise."""
OFF_M: Final = 0.005
"""How far the hand may be from a part that stands still, after silence, m..."""
OFF_NOISE_M: Final = 0.0005
"""... at this noise or less, m."""

COLUMNS: Final = (
    "arm",
    "the part",
    "runs",
    "faults",
    "runs stopped short",
    "peak acceleration",
    "peak speed",
    "runs with a lag",
    "off after silence, mm",
)


def broken(result: Result) -> bool:
    """Whether a run broke the promise."""
    off = 0.0 if result.off is None or result.noise > OFF_NOISE_M else result.off
    return bool(result.fault) or result.acceleration > BOUND or off > OFF_M


def summary(results: Sequence[Result], conditions: Conditions) -> str:
    """Conditions and table, in Markdown."""
    groups = sorted({(each.arm, each.kind) for each in results})
    rows = [
        _row(arm, kind, [each for each in results if (each.arm, each.kind) == (arm, kind)])
        for arm, kind in groups
    ]
    rows.append(_row("all", "", results))
    return (
        f"{conditions.rate:g} Hz, seeds {min(each.seed for each in results)} to "
        f"{max(each.seed for each in results)} of each arm\n\n{table(COLUMNS, rows)}"
    )


def _row(arm: str, kind: str, results: Sequence[Result]) -> tuple[str, ...]:
    offs = [each.off for each in results if each.off is not None and each.noise <= OFF_NOISE_M]
    return (
        arm,
        kind,
        f"{len(results)}",
        f"{sum(bool(each.fault) for each in results)}",
        f"{sum(each.short > 0 for each in results)}",
        f"{max(each.acceleration for each in results):.4f}",
        f"{max(each.speed for each in results):.4f}",
        f"{sum(each.lagged > 0 for each in results)}",
        f"{1e3 * max(offs):.2f}" if offs else "-",
    )

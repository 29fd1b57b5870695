"""What came out of a campaign of corners: one row for each arm and transition."""

from collections.abc import Sequence
from typing import Final

from generated import table

from corners.results import Conditions
from corners.run import Result

NEAR: Final = 0.8
"""Part of the bound that most corners should come to."""

ROUNDING: Final = 1e-6
"""Seconds by which one segment time is not longer than another."""

COLUMNS: Final = (
    "arm",
    "from, transition, to",
    "corners",
    "accepted",
    "largest mm",
    "median mm",
    "smallest mm",
    "80 % or more",
    "no room for more",
    "promise off by",
    "lengthened",
    "slower than before",
    "than a joint one",
    "peak of a limit",
)


def summary(results: Sequence[Result], conditions: Conditions) -> str:
    """Conditions and table, in Markdown."""
    told = (
        f"{1e3 * conditions.deviation:g} mm at {conditions.rate:g} Hz; seeds "
        f"{min(each.seed for each in results)} to {max(each.seed for each in results)} of each arm"
    )
    groups = sorted({(each.arm, each.modes) for each in results})
    rows = [_row(arm, modes, _of(results, arm, modes), conditions) for arm, modes in groups]
    rows.append(_row("all", "", results, conditions))
    return f"{told}\n\n{table(COLUMNS, rows)}"


def _of(results: Sequence[Result], arm: str, modes: str) -> list[Result]:
    return [each for each in results if (each.arm, each.modes) == (arm, modes)]


def near(results: Sequence[Result], bound: float) -> int:
    """How many come to ``NEAR`` of the bound."""
    return sum(each.measured is not None and each.measured >= NEAR * bound for each in results)


def longer(result: Result) -> float:
    """Seconds by which its segment takes longer than what it is compared with; 0 without that."""
    if result.segment_time is None or result.today is None:
        return 0.0
    return result.segment_time - result.today


def slower(results: Sequence[Result]) -> list[Result]:
    """Those whose segment takes longer than what it is compared with."""
    return [each for each in results if longer(each) > ROUNDING]


def existed(result: Result) -> bool:
    """Whether there was such a transition before: not a Cartesian one from or into joint mode."""
    first, transition, second = result.modes.split()
    return transition == "joint" or first == second == "cartesian"


def broken_promise(result: Result) -> float:
    """Part of the deviation promised by which the one measured differs."""
    if not result.promised or result.measured is None:
        return 0.0
    return abs(result.measured / result.promised - 1.0)


def _row(arm: str, modes: str, results: Sequence[Result], conditions: Conditions) -> list[str]:
    runs = [each for each in results if each.measured is not None]
    measured = sorted(1e3 * each.measured for each in runs if each.measured is not None)
    lengthened = sum(
        each.segment_time is not None
        and each.asked is not None
        and each.segment_time > each.asked + 1.0 / conditions.rate
        for each in runs
    )
    before = [each for each in runs if existed(each) and each.today is not None]
    new = [each for each in runs if not existed(each) and each.today is not None]
    return [
        arm,
        modes,
        str(len(results)),
        str(len(runs)),
        f"{measured[-1]:.3f}",
        f"{measured[len(measured) // 2]:.3f}",
        f"{measured[0]:.3f}",
        str(near(runs, conditions.deviation)),
        str(sum(each.limited for each in runs)),
        f"{100.0 * max(map(broken_promise, runs)):.2f} %",
        str(lengthened),
        f"{len(slower(before))} of {len(before)}" if before else "",
        f"{len(slower(new))} of {len(new)}" if new else "",
        f"{100.0 * max(each.peak or 0.0 for each in runs):.1f} %",
    ]

"""Tables of a soak: programs by kind, and the largest value of each quantity."""

from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np

from soak.bounds import QUANTITIES, bound_of
from soak.kinds import KINDS
from soak.trial import Result
from soak.watch import BLOCK

UNMODELLED: Final = "excitation"
"""The kind whose master compensates no dynamics."""
LONG: Final = "endurance"
"""The kind that runs long enough to show what memory does."""
WARM: Final = 8192
"""Cycles after which nothing may be allocated that stays."""
MEMORY_MB: Final = 2.0
"""Growth of resident memory that is allowed from then on, MB: blocks of Python's allocator."""
CYCLES, PROGRAMS, PASSED = 1_000_000, 200, 40
"""What a soak has to be: cycles with the arm enabled, programs, those of them past cycle 2^32."""
Table = list[list[str]]


def by_kind(results: Sequence[Result]) -> Table:
    """A row for each kind: programs, cycles, trips, ended by themselves, passed 2^32."""
    rows = [["kind", "programs", "cycles", "trips", "ended early", "past 2^32"]]
    for kind in KINDS:
        some = [result for result in results if result.kind == kind]
        if some:
            rows.append([kind, *_sums(some)])
    rows.append(["all", *_sums(results)])
    return rows


def _sums(some: Iterable[Result]) -> list[str]:
    some = list(some)
    return [
        str(len(some)),
        f"{sum(result.cycles for result in some):,}",
        str(sum(bool(result.trips) for result in some)),
        str(sum(bool(result.ended) for result in some)),
        str(sum(result.passed for result in some)),
    ]


def against_bounds(results: Sequence[Result]) -> Table:
    """A row for each quantity of ``QUANTITIES``: its largest value, where, and its bound.

    Excitations are apart: the master compensates nothing in them, and bounds are wider.
    """
    rows = [["quantity", "largest", "without a model", "bound", "joint", "largest in"]]
    modelled = [result for result in results if result.kind != UNMODELLED]
    others = [result for result in results if result.kind == UNMODELLED]
    for name, quantity in QUANTITIES.items():
        worst = max(modelled or others, key=lambda result: max(result.margins[name]))
        values, bound = worst.margins[name], bound_of(name)
        loose = max((max(result.margins[name]) for result in others), default=None)
        rows.append(
            [
                f"{quantity.meaning}",
                f"{max(values):.3g}",
                "" if loose is None else f"{loose:.3g}",
                "none" if bound is None else f"{bound:.3g}",
                str(1 + values.index(max(values))),
                f"{worst.kind} {worst.arm} {worst.seed}",
            ]
        )
    return rows


def beyond_bounds(results: Iterable[Result]) -> list[str]:
    """Quantities that reached their bound in a run whose master had a model: none may."""
    modelled = [result for result in results if result.kind != UNMODELLED]
    found = []
    for name in QUANTITIES:
        bound = bound_of(name)
        most = max((max(result.margins[name]) for result in modelled), default=0.0)
        if bound is not None and most >= bound:
            found.append(f"{name}: {most:.3g}, bound {bound:.3g}")
    return found


def shortfall(results: Sequence[Result]) -> str:
    """What a file lacks of a soak; "" if it is one."""
    counted = (
        ("cycles with the arm enabled", sum(result.enabled for result in results), CYCLES),
        ("programs", len(results), PROGRAMS),
        ("programs past cycle 2^32", sum(result.passed for result in results), PASSED),
    )
    lacking = [f"{have:,} of {due:,} {what}" for what, have, due in counted if have < due]
    return "; ".join(lacking)


def margins(results: Sequence[Result]) -> Table:
    """A row for each quantity: its largest value at each joint, and the program of the largest."""
    rows = [["quantity", *(f"J{n}" for n in range(1, 7)), "largest in"]]
    names = dict.fromkeys(name for result in results for name in result.margins)
    for name in names:
        values = np.array([result.margins.get(name, [0.0] * 6) for result in results])
        worst = results[int(values.max(axis=1).argmax())]
        largest = (f"{value:.3g}" for value in values.max(axis=0))
        rows.append([name, *largest, f"{worst.kind} {worst.arm} {worst.seed}"])
    return rows


def memory_growth(results: Iterable[Result]) -> float:
    """Largest growth of the resident memory of long programs, MB; see ``grown``."""
    return max((grown(result) for result in results if result.kind == LONG), default=0.0)


def grown(result: Result) -> float:
    """Resident memory at the end of a program, less the most in its first ``WARM`` cycles, MB."""
    warm = 1 + WARM // BLOCK
    return result.memory[-1] - max(result.memory[: warm + 1])


def aligned(table: Table) -> str:
    """As text, in columns."""
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    return "\n".join(
        "  ".join(
            cell.ljust(width) if not at else cell.rjust(width)
            for at, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in table
    )


def summary(results: Sequence[Result]) -> str:
    """What the tool prints."""
    tripped = [f"{result.job.name}: {result.trips[0]}" for result in results if result.trips]
    grows = f"long programs grow by {memory_growth(results):.1f} MB; bound {MEMORY_MB:g} MB"
    tables = (by_kind(results), margins(results), against_bounds(results))
    lacking = shortfall(results)
    short = [f"no whole soak: {lacking}"] if lacking else []
    parts = [*map(aligned, tables), grows, *short, *tripped]
    return "\n\n".join(parts)

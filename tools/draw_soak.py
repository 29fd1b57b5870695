"""Write the tables of docs/soak.md from the programs in docs/data/soak.jsonl."""

from functools import cache
from typing import Final

from generated import DOCS, Sections, main_of_pages, table
from soak.results import FILE, Conditions
from soak.table import (
    LONG,
    MEMORY_MB,
    UNMODELLED,
    WARM,
    Table,
    against_bounds,
    by_kind,
    margins,
    memory_growth,
    shortfall,
)
from soak.trial import Result


@cache
def _soak() -> tuple[Conditions, list[Result]]:
    return FILE.read(DOCS / "data" / "soak.jsonl")


def _markdown(rows: Table) -> str:
    return table(rows[0], rows[1:])


def programs() -> str:
    """What was run, by kind."""
    conditions, results = _soak()
    seeds = sorted({result.seed for result in results})
    enabled = sum(result.enabled for result in results)
    lacking = shortfall(results)
    short = f"No whole soak yet: {lacking}; the first command goes on. " if lacking else ""
    return (
        f"{short}{conditions.rate:g} Hz, seeds {seeds[0]} to {seeds[-1]}; the arm was enabled in "
        f"{enabled:,} of the cycles\n\n{_markdown(by_kind(results))}"
    )


def bounds() -> str:
    """The largest value of each quantity that detectors watch, against its bound."""
    return _markdown(against_bounds(_soak()[1]))


def joints() -> str:
    """All quantities by joint, of programs whose master has a model."""
    return _markdown(margins([result for result in _soak()[1] if result.kind != UNMODELLED]))


def memory() -> str:
    """What memory did in long programs."""
    long = [result for result in _soak()[1] if result.kind == LONG]
    least, most = (f(result.cycles for result in long) for f in (min, max))
    return (
        f"{len(long)} programs of {least:,} to {most:,} cycles; from cycle {WARM:,} to the end the "
        f"resident memory grew by {memory_growth(long):.1f} MB at most (bound {MEMORY_MB:g} MB)."
    )


PAGES: Final[dict[str, Sections]] = {
    "soak.md": {
        "draw_soak.py programs": programs,
        "draw_soak.py bounds": bounds,
        "draw_soak.py memory": memory,
        "draw_soak.py joints": joints,
    }
}

if __name__ == "__main__":
    main_of_pages("draw_soak.py", PAGES)

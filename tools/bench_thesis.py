#!/usr/bin/env python3
"""The thesis' performance figures (section 4.7 of Chapter VI and around it), measured again.

Each operation the thesis times, in 1986 and here, with the ratio and what is counted. Quote ratios
with the machine; absolute times are this machine's.
"""

import argparse
import gc
import json
import platform
from dataclasses import asdict
from typing import Any, Final

from generated import DOCS, table, with_section
from rich.console import Console
from rich.table import Table
from thesis_operations import MOVING_CYCLES, Settings, measure
from thesis_times import FIGURES, Row

from rfms_can.arm import ARMS

PAGE: Final = "thesis-times.md"
TOOL: Final = "bench_thesis.py"
COLUMNS: Final = ("operation", "section", "1986", "here", "ratio", "what is counted here")
WIDTH: Final = 160
"""Default width of the table where there is no terminal, columns."""


def arguments() -> tuple[Settings, argparse.Namespace]:
    """Settings, and the options of the output."""
    usual = Settings()
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--arm", choices=ARMS, default=usual.arm)
    parser.add_argument("--rate", type=float, default=usual.rate_hz, help="control rate, Hz")
    parser.add_argument("--repeats", type=int, default=usual.repeats, help="calls in a batch")
    parser.add_argument(
        "--batches", type=int, default=usual.batches, help="of each operation in a round"
    )
    parser.add_argument(
        "--rounds",
        type=int,
        default=usual.rounds,
        help="over all operations; the best batch counts",
    )
    parser.add_argument(
        "--cycles", type=int, default=usual.cycles, help="of the whole loop in a batch"
    )
    output = parser.add_mutually_exclusive_group()
    output.add_argument("--json", action="store_true", help="one JSON object")
    output.add_argument("--write", action="store_true", help=f"write the table of docs/{PAGE}")
    options = parser.parse_args()
    if not 20.0 <= options.rate <= 300.0:
        parser.error(f"--rate {options.rate:g} is not in 20 to 300 Hz")
    for name in ("repeats", "batches", "rounds", "cycles"):
        if getattr(options, name) < 1:
            parser.error(f"--{name} {getattr(options, name)}: give at least 1")
    if options.cycles > MOVING_CYCLES:
        parser.error(f"--cycles {options.cycles}: at most {MOVING_CYCLES}, then the arm rests")
    return (
        Settings(
            arm=options.arm,
            rate_hz=options.rate,
            repeats=options.repeats,
            batches=options.batches,
            rounds=options.rounds,
            cycles=options.cycles,
        ),
        options,
    )


def figures(settings: Settings, rows: list[Row]) -> dict[str, Any]:
    """All of it, for JSON: seconds and Hz."""
    return {
        **asdict(settings),
        "python": platform.python_version(),
        "machine": platform.machine(),
        "rows": [
            {
                "key": row.figure.key,
                "operation": row.figure.operation,
                "section": row.figure.section,
                "unit": row.figure.unit,
                "value_1986": row.figure.value,
                "printed_1986": row.figure.printed,
                "at_most_1986": row.figure.at_most,
                "value_here": row.here,
                "ratio": row.ratio,
                "counted": row.figure.counted,
            }
            for row in rows
        ],
    }


def cells(row: Row) -> tuple[str, ...]:
    """One row in the order of ``COLUMNS``."""
    figure = row.figure
    bound = "≤ " if figure.at_most else ""
    return (
        figure.operation,
        figure.section,
        bound + amount(figure.value, figure.unit),
        amount(row.here, figure.unit),
        bound + f"{row.ratio:.2g}" if row.ratio < 100.0 else bound + f"{row.ratio:,.0f}",
        figure.counted,
    )


def amount(value: float, unit: str) -> str:
    """Three digits with a unit a reader can grasp."""
    if unit == "Hz":
        return f"{value:,.0f} Hz"
    return f"{value * 1e3:.3g} ms" if value >= 1e-4 else f"{value * 1e6:.3g} µs"


def show(settings: Settings, rows: list[Row]) -> None:
    """A table, and how it came about."""
    console = Console(highlight=False)
    if not console.is_terminal:
        console.width = max(console.width, WIDTH)
    shown = Table(title="The thesis' times and ours", title_justify="left")
    for column in COLUMNS:
        number = column in ("1986", "here", "ratio")
        shown.add_column(column, justify="right" if number else "left", no_wrap=number)
    for row in rows:
        shown.add_row(*cells(row))
    console.print(shown)
    console.print(how(settings))


def how(settings: Settings) -> str:
    """The settings, as a sentence."""
    return (
        f"{settings.arm}, {settings.rate_hz:g} Hz; the best of {settings.rounds} rounds of "
        f"{settings.batches} batches of {settings.repeats} calls (fewer where a call takes long), "
        f"{settings.cycles} cycles of the loop in a batch; CPython {platform.python_version()}, "
        f"one core, {platform.machine()}"
    )


def section(settings: Settings, rows: list[Row]) -> str:
    """The generated part of the page."""
    return f"{table(COLUMNS, [cells(row) for row in rows])}\n\n{how(settings)}."


def main() -> None:
    """Measure and print."""
    settings, options = arguments()
    gc.collect()
    gc.freeze()
    rows = measure(settings, FIGURES)
    if options.json:
        print(json.dumps(figures(settings, rows)))
    elif options.write:
        path = DOCS / PAGE
        text = path.read_text(encoding="utf-8")
        path.write_text(with_section(text, TOOL, section(settings, rows)), encoding="utf-8")
    else:
        show(settings, rows)


if __name__ == "__main__":
    main()

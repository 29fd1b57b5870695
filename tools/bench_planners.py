#!/usr/bin/env python3
"""Trajectory generators side by side: the thesis', what came before it, and Ruckig.

The same three tasks for all: two straight lines with a corner, a pick in joint, straight and joint
motion, and a place on a running belt. How far off the line, how hard on the joints, how smooth, and
what a set-point costs, as a ratio to this package's own, run in turn in the same process. Quote
ratios; absolute times are this machine's.
"""

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from planners import jerk_limited
from planners.bench import PLANNERS, Row, compare
from planners.planner import NotPossibleError
from planners.table import NOTES, reasons, table
from planners.task import TASKS
from rich.console import Console

from rfms_can.arm import ARMS, arm_by_name

WIDTH = 132
"""Default width of a table, columns."""


def arguments() -> argparse.Namespace:
    """Command-line arguments."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--planner", action="append", choices=PLANNERS, help="repeatable; all")
    parser.add_argument("--task", action="append", choices=TASKS, help="repeatable; all three")
    parser.add_argument("--arm", choices=ARMS, default="puma260")
    parser.add_argument("--rate", type=float, default=250.0, help="set-points a second")
    parser.add_argument(
        "--repeats", type=int, default=20, help="timed runs of each; the least counts"
    )
    parser.add_argument("--json", action="store_true", help="one JSON object")
    parser.add_argument("--picture", type=Path, help="draw joint accelerations of the first task")
    options = parser.parse_args()
    if not 20.0 <= options.rate <= 2000.0:
        parser.error(f"--rate {options.rate:g} is not in 20 to 2000 Hz")
    if options.repeats < 1:
        parser.error(f"--repeats {options.repeats}: give at least 1")
    return options


def figures(options: argparse.Namespace, rows: list[Row]) -> dict[str, Any]:
    """All of it, for JSON."""
    return {
        "arm": options.arm,
        "rate_hz": options.rate,
        "repeats": options.repeats,
        "rows": [row.as_json() for row in rows],
    }


def show(options: argparse.Namespace, rows: list[Row]) -> None:
    """A table for each task."""
    console = Console(highlight=False)
    if not console.is_terminal:
        console.width = max(console.width, WIDTH)
    for task in dict.fromkeys(row.task for row in rows):
        mine = [row for row in rows if row.task == task]
        title = f"{task}: {TASKS[task].__doc__}"
        console.print(table(title.rstrip("."), mine))
        for reason in reasons(mine):
            console.print(reason)
        console.print()
    console.print(f"{options.arm}, {options.rate:g} Hz, {options.repeats} repeats")
    for note in NOTES:
        console.print(note, style="dim")


def main() -> None:
    """Measure and print."""
    options = arguments()
    if options.planner and "ruckig" in options.planner:
        try:
            jerk_limited.library()
        except NotPossibleError as error:
            sys.exit(f"bench_planners: ruckig {error}")
    arm, period_s = arm_by_name(options.arm), 1.0 / options.rate
    names = list(dict.fromkeys(options.planner or PLANNERS))
    tasks = [TASKS[name](arm) for name in dict.fromkeys(options.task or TASKS)]
    rows = [row for task in tasks for row in compare(task, names, period_s, options.repeats)]
    if options.json:
        print(json.dumps(figures(options, rows)))
    else:
        show(options, rows)
    if options.picture is not None:
        from planners.picture import draw  # noqa: PLC0415

        draw(tasks[0], names, period_s, options.picture)


if __name__ == "__main__":
    main()

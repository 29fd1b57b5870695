#!/usr/bin/env python3
"""From a sensor's observation to the DAC: how many cycles, how many milliseconds.

Runs of the simulated bus with an observation and without (``latency_twins.py``) are compared frame
by frame: the first SETPOINT that differs carries the observation to the joints, the first DAC its
torque.

Cycles are counted in two ways: from the one whose SYNC was the last, and from the one in progress,
which after the close of a cycle (all have answered, its successor's set-point is made) is the next.
The bus is the timing-true one, so milliseconds are those of a real bus of the same bit rates.

A correction begins with zero velocity, acceleration and jerk and builds up as fast as the mode
allows: gentle or small ones take a cycle or two more until they are worth a code of a DAC. What is
measured here is the way of the observation: two centimetres, under a brisk mode.

The joints do not use the poses of one set-point in a segment: START, at which one segment hands
over to the next, goes on from the set-points before. An observation that comes just then tells one
cycle later.
"""

import argparse
import json
from collections import Counter
from pathlib import Path
from statistics import mean
from typing import Any, Final

from latency_twins import Latency, measure
from rich.console import Console
from rich.table import Table

BAR: Final = 50
"""Longest bar of the histogram, characters."""


def figures(latencies: list[Latency]) -> dict[str, Any]:
    """Histograms and extremes, for JSON."""

    def one(cycles: list[int], ms: list[float]) -> dict[str, Any]:
        after = [count - latency.closed for count, latency in zip(cycles, latencies, strict=True)]
        return {
            "from_sync": {str(c): n for c, n in sorted(Counter(cycles).items())},
            "from_cycle_in_progress": {str(c): n for c, n in sorted(Counter(after).items())},
            "ms_min": min(ms),
            "ms_mean": mean(ms),
            "ms_max": max(ms),
        }

    return {
        "samples": len(latencies),
        "moving": sum(latency.moving for latency in latencies),
        "setpoint": one([x.setpoint_cycles for x in latencies], [x.setpoint_ms for x in latencies]),
        "dac": one([x.dac_cycles for x in latencies], [x.dac_ms for x in latencies]),
    }


def show(latencies: list[Latency]) -> None:
    """A table, and a histogram of the milliseconds to the DAC."""
    console = Console()
    numbers = figures(latencies)
    table = Table(
        title=f"{numbers['samples']} observations, {numbers['moving']} of them in motion, 250 Hz",
        title_justify="left",
    )
    table.add_column("from an observation to")
    for column in ("cycles from last SYNC", "from cycle in progress", "min ms", "mean", "max"):
        table.add_column(column, justify="right")
    for what, key in (("T6 on the bus", "setpoint"), ("changed DAC output", "dac")):
        row = numbers[key]
        table.add_row(
            what,
            *(_counts(row[name]) for name in ("from_sync", "from_cycle_in_progress")),
            *(f"{row[name]:.2f}" for name in ("ms_min", "ms_mean", "ms_max")),
        )
    console.print(table)
    console.print("ms to changed DAC output")
    bins = Counter(int(latency.dac_ms * 2.0) for latency in latencies)
    most = max(bins.values())
    for number in range(min(bins), max(bins) + 1):
        bar = "█" * round(BAR * bins[number] / most)
        console.print(f"{number / 2.0:4.1f} to {number / 2.0 + 0.5:4.1f} {bar} {bins[number]}")


def _counts(histogram: dict[str, int]) -> str:
    return ", ".join(f"{cycles}: {count} times" for cycles, count in histogram.items())


def draw(latencies: list[Latency], path: Path) -> None:
    """The histogram as a picture; needs matplotlib."""
    from rfms_can.analysis.canvas import COMMANDED, LIMIT, MEASURED, Sheet  # noqa: PLC0415

    sheet = Sheet(
        "From a sensor's observation to the DACs",
        f"{len(latencies)} observations at random moments of a cycle of 4 ms",
        (1, 1),
        (7.5, 3.4),
    )
    axes = sheet.title_panel(0, "Latency on a bus of 1/5 Mbit/s", "observations")
    edges = [i * 0.25 for i in range(int(max(x.dac_ms for x in latencies) * 4) + 2)]
    for name, color, values in (
        ("T6 on the bus", COMMANDED, [x.setpoint_ms for x in latencies]),
        ("changed DAC output", MEASURED, [x.dac_ms for x in latencies]),
    ):
        axes.hist(values, edges, alpha=0.75, color=color, label=name)
    axes.axvline(8.0, color=LIMIT, linestyle="--", linewidth=0.9)
    axes.set_xlim(left=0.0)
    sheet.legend(*axes.get_legend_handles_labels())
    sheet.save(path, "ms from the observation")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--samples", type=int, default=400, help="observations")
    parser.add_argument("--seed", type=int, default=1, help="of the moments")
    parser.add_argument("--json", action="store_true", help="one JSON object")
    parser.add_argument("--picture", type=Path, help="write the histogram as a PNG")
    options = parser.parse_args()
    latencies = measure(options.samples, options.seed)
    if options.json:
        print(json.dumps(figures(latencies)))
    else:
        show(latencies)
    if options.picture is not None:
        draw(latencies, options.picture)


if __name__ == "__main__":
    main()

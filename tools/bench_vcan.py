#!/usr/bin/env python3
"""Cycle rate of nine processes on vcan0, as a ratio to a bare C exchange of the same frames.

Run it through ``tools/with-vcan``. Both are run in turn, several times, in one boot: no timing
inside a user-mode kernel says anything about a real one, ratios do. The C program
(``vcan_exchange.c``) sends the same frames with the same filters and computes nothing.
"""

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median
from typing import Any

from rich.console import Console
from rich.table import Table

from rfms_can.errors import RfmsError
from rfms_can.rig.processes import ProcessRig
from rfms_can.rig.session import Session
from rfms_can.rig.settings import RunSettings

SOURCE = Path(__file__).with_name("vcan_exchange.c")
WARM_UP = 50


def build(directory: Path) -> Path:
    """Compile the bare exchange."""
    compiler = shutil.which("cc")
    if compiler is None:
        raise RfmsError("no C compiler: apt-get install gcc")
    program = directory / "vcan_exchange"
    subprocess.run([compiler, "-O2", "-o", program, SOURCE], check=True)
    return program


def exchange(program: Path, cycles: int) -> float:
    """Cycles/s of the bare exchange."""
    answer = subprocess.run(
        [program, "--json", str(cycles)], check=True, capture_output=True, text=True
    )
    return float(json.loads(answer.stdout)["cycles_per_s"])


class Loop:
    """The nine processes of the real thing, enabled and holding the arm."""

    def __init__(self, bus: str) -> None:
        self.rig = ProcessRig(RunSettings(bus=bus))
        self.session = Session(self.rig)
        self.session.bring_up()
        self.rate(WARM_UP)

    def rate(self, cycles: int) -> float:
        """Cycles/s over so many more cycles."""
        master = self.rig.master
        until = master.closed + cycles
        began = time.perf_counter()
        self.session.link.pass_time(lambda: master.closed >= until)
        return cycles / (time.perf_counter() - began)


def measure(bus: str, cycles: int, runs: int) -> dict[str, Any]:
    """Both rates, in turn; the loop rests while the exchange has the kernel to itself."""
    with tempfile.TemporaryDirectory() as directory:
        program = build(Path(directory))
        exchange(program, WARM_UP)
        ours, bare = [], []
        for _ in range(runs):
            bare.append(exchange(program, cycles))
            loop = Loop(bus)
            try:
                ours.append(loop.rate(cycles))
            finally:
                loop.rig.close()
    ratios = [one / other for one, other in zip(ours, bare, strict=True)]
    return {
        "bus": bus,
        "cycles": cycles,
        "cycles_per_s": median(ours),
        "bare_c_cycles_per_s": median(bare),
        "ratio": median(ratios),
        "ratios": ratios,
    }


def show(figures: dict[str, Any]) -> None:
    """The figures as a table."""
    table = Table(title=f"nine processes in lockstep on {figures['bus']}", title_justify="left")
    for heading in ("what", "cycles/s", "ratio"):
        table.add_column(heading, justify="left" if heading == "what" else "right")
    table.add_row(
        "bare C exchange of the same frames", f"{figures['bare_c_cycles_per_s']:.0f}", "1"
    )
    table.add_row(
        "rfms_can: control loop and plant",
        f"{figures['cycles_per_s']:.0f}",
        f"{figures['ratio']:.2f}",
    )
    Console().print(table)
    runs = ", ".join(f"{ratio:.2f}" for ratio in figures["ratios"])
    Console().print(f"ratios of the runs, interleaved: {runs}")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bus", default="socketcan:vcan0", help="bus URL")
    parser.add_argument("--cycles", type=int, default=500, help="cycles in a run")
    parser.add_argument("--runs", type=int, default=3, help="runs; medians are printed")
    parser.add_argument("--json", action="store_true", help="one JSON object")
    options = parser.parse_args()
    try:
        figures = measure(options.bus, options.cycles, options.runs)
    except (RfmsError, subprocess.CalledProcessError) as error:
        sys.exit(f"bench_vcan: {error}; run it as tools/with-vcan python tools/bench_vcan.py")
    if options.json:
        print(json.dumps(figures))
    else:
        show(figures)


if __name__ == "__main__":
    main()

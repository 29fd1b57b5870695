"""Output of ``rfms faults``: a line a variant, the trials that fail, or JSON."""

import json
import sys
from collections.abc import Sequence
from pathlib import Path

import msgspec

from rfms_can.bus.url import SIM
from rfms_can.faults.campaign import Line, met_rows
from rfms_can.faults.table import ROWS
from rfms_can.faults.trial import Result


def print_faults(lines: Sequence[Line], bus: str, *, as_json: bool) -> None:
    """To the standard output; ``bus`` is that of the trials."""
    if as_json:
        json.dump({"rows": [msgspec.to_builtins(line) for line in lines]}, sys.stdout)
        sys.stdout.write("\n")
        return
    before = 0
    for line in lines:
        if line.row != before:
            row = ROWS[line.row]
            print(f"\n{line.row} {row.fault}: {row.detected_by}; bound {row.bound}, {row.reaction}")
            before = line.row
        print(f"  {_line(line, bus)}")
    met = met_rows(lines)
    missed = [str(row) for row, good in met.items() if not good]
    print(f"\n{sum(met.values())} of {len(met)} rows met", end="")
    print(f"; not met: {', '.join(missed)}" if missed else "")


def _line(line: Line, bus: str) -> str:
    worst = "-" if line.worst is None else f"{line.worst:.1f}"
    verdict = "met    " if line.met else "NOT MET"
    text = (
        f"{verdict} {line.variant:26} {line.arm:8} {line.seeds:4} seeds  found {worst:>5}, bound "
        f"{line.bound:g}  {line.reaction}"
    )
    if line.met:
        return text
    why = f"\n          {'; '.join(line.why)}"
    if line.replay is None:
        return text + why
    on = "" if bus == SIM else f"--bus {bus} "
    return f"{text}{why}\n          rfms faults {on}--arm {line.arm} --replay '{line.replay}'"


def print_trial(result: Result, files: Sequence[Path], *, as_json: bool) -> None:
    """One trial, to the standard output."""
    if as_json:
        plain = {**msgspec.to_builtins(result), "files": [str(file) for file in files]}
        json.dump(plain, sys.stdout)
        sys.stdout.write("\n")
        return
    print("met" if result.met else f"NOT MET: {'; '.join(result.problems)}")
    if result.facts is not None:
        for name, value in msgspec.to_builtins(result.facts).items():
            print(f"  {name:13} {value}")
    for file in files:
        print(file)

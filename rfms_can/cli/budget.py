"""``rfms budget``: bus load and response times of the wire contract, frame by frame."""

import json
import sys
from itertools import product
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from rfms_can.bus.budget import TARGET_LOAD, Budget, Cycle, Rows, Traffic, contract_streams
from rfms_can.bus.budget import budget as budget_of
from rfms_can.bus.schedule import load
from rfms_can.bus.timing import BusTiming

US_PER_NS = 1e-3
ALTERNATIVES = (
    ("CAN FD 1/5 Mbit/s", 1_000_000, 5_000_000),
    ("CAN FD 1/8 Mbit/s", 1_000_000, 8_000_000),
    ("classic 1 Mbit/s", 1_000_000, None),
)


def budget(
    *,
    rate: Annotated[float, typer.Option(help="control rate, Hz")] = 250.0,
    nominal: Annotated[int, typer.Option(help="nominal bit rate, bit/s")] = 1_000_000,
    data: Annotated[int, typer.Option(help="data bit rate, bit/s; 0: classic CAN")] = 5_000_000,
    rows: Annotated[Rows, typer.Option(help="six ROWS every cycle, or one")] = Rows.ALL,
    traffic: Annotated[Traffic, typer.Option(help="which frames share the bus")] = Traffic.BOTH,
    cycle: Annotated[
        Cycle, typer.Option(help="full: with second pose, bias and force")
    ] = Cycle.FULL,
    as_json: Annotated[bool, typer.Option("--json", help="one JSON object")] = False,
) -> None:
    """Bus load and response times of every frame. Exit code 1 if a frame can miss its deadline."""
    result = budget_of(
        rate, BusTiming(nominal, data or None), rows=rows, traffic=traffic, cycle=cycle
    )
    if as_json:
        report = {**as_plain(result), "rate_hz": rate, "alternatives": alternatives(rate)}
        json.dump(report, sys.stdout)
        sys.stdout.write("\n")
    else:
        _print(result, rate)
    if not result.in_time:
        raise typer.Exit(1)


def as_plain(result: Budget) -> dict[str, Any]:
    """The budget as plain data for JSON: times in µs, rates in Hz and bit/s."""
    return {
        "nominal_bit_rate": result.timing.nominal_bit_rate,
        "data_bit_rate": result.timing.data_bit_rate,
        "traffic": result.traffic.value,
        "load": result.load,
        "cycle_us": result.cycle_ns * US_PER_NS,
        "max_rate_hz": result.max_rate_hz,
        "in_time": result.in_time,
        "frames": [
            {
                "frame": response.stream.name,
                "id": response.stream.id,
                "bytes": response.stream.length,
                "wire_us": response.wire_ns * US_PER_NS,
                "period_us": _microseconds(response.stream.period_ns),
                "response_us": _microseconds(response.response_ns),
                "in_time": response.in_time,
            }
            for response in result.responses
        ],
    }


def alternatives(rate_hz: float) -> list[dict[str, Any]]:
    """Load and highest rate for other bit rates, schedules of ROWS and splits of the traffic."""
    lines = []
    for (name, nominal, data), rows, separate in product(ALTERNATIVES, Rows, (False, True)):
        timing = BusTiming(nominal, data)
        line: dict[str, Any] = {"bus": name, "rows": rows.value, "separate": separate}
        for cycle in Cycle:
            busiest = max(
                load(contract_streams(rate_hz, timing, rows=rows, traffic=t, cycle=cycle), timing)
                for t in ((Traffic.CONTROL, Traffic.PLANT) if separate else (Traffic.BOTH,))
            )
            line[f"{cycle}_load"] = busiest
            line[f"{cycle}_max_rate_hz"] = rate_hz * TARGET_LOAD / busiest
        lines.append(line)
    return lines


def _microseconds(nanoseconds: int | None) -> float | None:
    return None if nanoseconds is None else nanoseconds * US_PER_NS


def _print(result: Budget, rate_hz: float) -> None:
    console = Console()
    table = Table(title=f"{result.traffic.value} at {rate_hz:g} Hz, {result.timing}")
    for heading in ("frame", "id", "bytes", "wire µs", "period µs", "response µs", "in time"):
        table.add_column(heading, justify="left" if heading == "frame" else "right")
    for frame in as_plain(result)["frames"]:
        table.add_row(
            frame["frame"],
            f"{frame['id']:#05x}",
            str(frame["bytes"]),
            f"{frame['wire_us']:.1f}",
            "event" if frame["period_us"] is None else f"{frame['period_us']:.0f}",
            "-" if frame["response_us"] is None else f"{frame['response_us']:.1f}",
            "yes" if frame["in_time"] else "[bold red]NO",
        )
    console.print(table)
    console.print(
        f"load {result.load:.1%}; a cycle's frames take {result.cycle_ns * 1e-6:.2f} ms; "
        f"{TARGET_LOAD:.0%} load at {result.max_rate_hz:.0f} Hz"
    )
    console.print(_alternatives_table(rate_hz))


def _alternatives_table(rate_hz: float) -> Table:
    table = Table(title=f"load at {rate_hz:g} Hz, and the rate at {TARGET_LOAD:.0%} load")
    for heading in ("bus", "rows", "plant", "usual cycle", "full cycle"):
        table.add_column(heading)
    for line in alternatives(rate_hz):
        cells = (f"{line[f'{c}_load']:.1%} {line[f'{c}_max_rate_hz']:.0f} Hz" for c in Cycle)
        table.add_row(
            line["bus"], line["rows"], "own bus" if line["separate"] else "same bus", *cells
        )
    return table

"""``rfms hub NAME``: one CAN bus for the processes of this machine, where the kernel has none."""

import json
import sys
from typing import Annotated, Any

import typer

from rfms_can.bus.hub.server import Hub, serve
from rfms_can.bus.statistics import BusStatistics
from rfms_can.bus.timing import BusTiming


def hub(
    name: Annotated[str, typer.Argument(help="name of the hub, for --bus hub:NAME")],
    nominal: Annotated[int, typer.Option(help="nominal bit rate, bit/s")] = 1_000_000,
    data: Annotated[int, typer.Option(help="data bit rate, bit/s; 0: classic CAN")] = 5_000_000,
    as_json: Annotated[bool, typer.Option("--json", help="JSON lines: ready, result")] = False,
) -> None:
    """Run a hub until Ctrl-C, then print its statistics."""

    def ready(running: Hub) -> None:
        if as_json:
            _line({"ready": running.name})
        else:
            typer.echo(f"hub {running.name!r} is up: --bus hub:{running.name}; Ctrl-C ends it")

    def notice(line: str) -> None:
        typer.echo(f"hub {name!r}: {line}", err=True)

    statistics = serve(name, BusTiming(nominal, data or None), ready, notice=notice)
    if as_json:
        _line({"frames": _frames(statistics), "bus_time_s": statistics.busy_ns * 1e-9})
    else:
        typer.echo(
            f"hub {name!r}: {_frames(statistics)} frames of {len(statistics.frames)} identifiers, "
            f"{statistics.busy_ns * 1e-9:.3f} s of bus time"
        )


def _frames(statistics: BusStatistics) -> int:
    return sum(of_id.count for of_id in statistics.frames.values())


def _line(report: dict[str, Any]) -> None:
    sys.stdout.write(json.dumps(report) + "\n")
    sys.stdout.flush()

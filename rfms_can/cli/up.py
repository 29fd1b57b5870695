"""``rfms up``: starts all processes, shows their health, and leaves no orphan."""

import json
import time
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import msgspec
import typer
from rich.live import Live
from rich.table import Table

from rfms_can.cli.nodes import stop_on_signals
from rfms_can.cli.options import DEFAULT_BUS, JsonOption, RecordOption, takes_settings
from rfms_can.cli.report import console, print_result
from rfms_can.errors import BusError, RfmsError
from rfms_can.rig.settings import RunSettings
from rfms_can.wire.nodes import MASTER, NODE_NAMES, SIMULATED

if TYPE_CHECKING:
    from rfms_can.rig.fleet import Fleet, Health
    from rfms_can.rig.result import RunResult

LOOK_S = 0.25


@takes_settings(defaults=DEFAULT_BUS)
def up(
    program: Annotated[
        Path | None, typer.Argument(help="program to run; without one the master waits, braked")
    ] = None,
    *,
    settings: RunSettings,
    without: Annotated[
        str, typer.Option("--without", help="nodes that are started elsewhere, e.g. 3 or 3,8")
    ] = "",
    keep_going: Annotated[
        bool, typer.Option("--keep-going", help="when one dies, keep the others running")
    ] = False,
    record: RecordOption = None,
    as_json: JsonOption = False,
) -> None:
    """Start master, six joints, gripper and plant; stop all on Ctrl-C or when one dies."""
    from rfms_can.rig.fleet import Fleet

    fleet = Fleet(settings, program, record, _numbers(without))
    try:
        _watch(fleet, settings, keep_going, as_json)
    finally:
        if not (console.is_terminal or as_json):
            console.line()  # a table that goes to a pipe ends without one
        fleet.close()
        title = "" if program is None else f"{program.stem} on {settings.arm}, {settings.bus}"
        _show(title, fleet.result, as_json)


def _watch(fleet: "Fleet", settings: RunSettings, keep_going: bool, as_json: bool) -> None:
    """Show the nodes' health until the program is over, one of them ends, or a signal comes.

    Raises:
        RfmsError: one has ended: says which, and by which error of its own.
    """
    from rfms_can.rig.child import describe

    stop = stop_on_signals()
    known: set[int] = set()
    with Live(console=console, auto_refresh=False, transient=False) as live:
        while not stop():
            try:
                fleet.watch(LOOK_S)
            except BusError:
                if stop():
                    return  # the hub was stopped as well
                raise
            if as_json:
                typer.echo(msgspec.json.encode(list(fleet.health.values())).decode())
            else:
                live.update(_table(fleet.health, settings), refresh=True)
            for child in fleet.dead():
                if child.pid in known or stop():
                    continue
                known.add(child.pid)
                if child.name == NODE_NAMES[MASTER] and child.exit_code == 0:
                    return  # its program is over
                if not keep_going:
                    raise RfmsError(f"{describe(child)}; the others are stopped")
                console.print(f"{describe(child)}; the others go on", markup=False)
    master = fleet.children.get(MASTER)
    if master is not None and master.pid in known:
        raise RfmsError(f"{describe(master)}: its run failed")


def _show(title: str, result: "RunResult | None", as_json: bool) -> None:
    """What ``rfms run`` tells of a run; nothing where no program has run to an end or a fault."""
    if result is None:
        return
    if as_json:
        typer.echo(json.dumps(result.as_dict()))
    else:
        print_result(title, result)


def _state(health: "Health") -> str:
    """State of a node by its last heartbeat, or how its process has ended."""
    if health.alive:
        return health.state
    return "finished" if health.exit_code == 0 else "[red]dead[/]"


def _table(health: Mapping[int, "Health"], settings: RunSettings) -> Table:
    table = Table(title=f"{settings.arm} on {settings.bus}  {time.strftime('%H:%M:%S')}")
    for heading in (
        "node",
        "pid",
        "state",
        "error register",
        "discarded",
        "silent [s]",
        "emergency",
    ):
        table.add_column(heading)
    for node in health.values():
        silent = "" if node.silent_s is None else f"{node.silent_s:.1f}"
        table.add_row(
            node.node,
            str(node.pid or "-"),
            _state(node),
            f"{node.error_register:#x}",
            str(node.discarded),
            silent,
            node.emergency,
        )
    return table


def _numbers(text: str) -> frozenset[int]:
    """Node numbers of ``3,8``."""
    try:
        numbers = frozenset(int(part) for part in text.split(",") if part.strip())
    except ValueError:
        numbers = frozenset({0})
    if not numbers <= set(SIMULATED):
        known = ", ".join(f"{n} {NODE_NAMES[n]}" for n in SIMULATED)
        raise RfmsError(f"--without {text!r}: node numbers are {known}")
    return numbers

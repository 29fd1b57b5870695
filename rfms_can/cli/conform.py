"""``rfms conform N``: the conformance suite of a joint node, on any bus."""

import json
import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated, Final

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from rfms_can.bus.url import GRAMMAR, SIM, is_simulated, parse_bus_url
from rfms_can.conform.lines import SETTLE_NS, Line, PortLine, SimulatedLine
from rfms_can.conform.outcome import Outcome, Verdict
from rfms_can.conform.report import as_json as json_of
from rfms_can.conform.report import failed, write_junit
from rfms_can.conform.runner import run_checks
from rfms_can.conform.table import CHECKS, Check, Kind
from rfms_can.conform.tester import Tester
from rfms_can.conform.vectors import Vectors
from rfms_can.errors import RfmsError
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import JOINTS

STYLES: Final = {
    Verdict.PASSED: "green",
    Verdict.FAILED: "bold red",
    Verdict.PENDING: "dim",
    Verdict.SKIPPED: "yellow",
}
UNDER: Final = {
    Kind.BUS: (Kind.BUS,),
    Kind.SENSOR: (Kind.BUS, Kind.SENSOR),
    Kind.AXIS: (Kind.BUS, Kind.SENSOR, Kind.AXIS),
}
"""Classes that a class includes."""
POWER_ON_S: Final = 60.0
"""How long the suite waits for the node to be switched on."""
SWITCH_ON: Final = "switch the node on now"
"""What a hand, or a script, waits for with ``--power-on``."""


def conform(
    number: Annotated[int, typer.Argument(help="1 to 6", min=JOINTS[0], max=JOINTS[-1])],
    bus: Annotated[str, typer.Option(help=f"{GRAMMAR}; sim: our own node")] = "hub:rfms",
    kind: Annotated[
        Kind,
        typer.Option("--class", help="bus; sensor: takes MEASURE from the bus; axis: free to move"),
    ] = Kind.BUS,
    check: Annotated[
        list[str] | None, typer.Option(help="number of a check; repeatable; else all")
    ] = None,
    allow_motion: Annotated[
        bool, typer.Option("--allow-motion", help="sensor and axis where a motor may be connected")
    ] = False,
    power_on: Annotated[
        bool, typer.Option("--power-on", help="say when to switch the node on, and wait for it")
    ] = False,
    fail_fast: Annotated[
        bool, typer.Option("--fail-fast", help="end at the first required check that fails")
    ] = False,
    junit: Annotated[Path | None, typer.Option(help="file of JUnit results to write")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="one JSON object")] = False,
) -> None:
    """Ask joint node N all that the contract requires; the tester is all other nodes."""
    checks = chosen(kind, check or ())
    if kind is not Kind.BUS and not (allow_motion or is_simulated(bus)):
        raise RfmsError(
            f"class {kind.value} on {bus!r} sends DAC codes to what may be a motor: "
            "give --allow-motion if it may move, or --class bus"
        )
    wire = Wire()
    line = open_line(bus, number, wire)
    try:
        tester = Tester(line, number, wire, Vectors(), boot_id=time.time_ns() & 0xFFFFFFFF)
        if power_on and not line.virtual:  # there the tester switches it on itself
            typer.echo(SWITCH_ON, err=True)  # the port is open: what the node says is kept
            tester.wait_for_power(POWER_ON_S)
        try:
            outcomes = _run(tester, checks, fail_fast)
        finally:
            tester.leave()
    finally:
        line.close()
    if junit is not None:
        write_junit(junit, number, outcomes)
    if as_json:
        typer.echo(json.dumps(json_of(outcomes)))
    else:
        _print(number, outcomes)
    if failed(outcomes):
        raise typer.Exit(1)


def chosen(kind: Kind, names: Sequence[str]) -> list[Check]:
    """The checks of a class, or those named.

    Raises:
        RfmsError: a check does not exist, or needs another class.
    """
    within = [check for check in CHECKS if check.kind in UNDER[kind]]
    if not names:
        return within
    known = {check.id: check for check in CHECKS}
    for name in names:
        if name not in known:
            raise RfmsError(f"no check {name!r}; there are: {', '.join(known)}")
        if known[name] not in within:
            raise RfmsError(f"check {name} needs --class {known[name].kind.value}")
    return [check for check in within if check.id in names]


def open_line(bus: str, joint: int, wire: Wire) -> Line:
    """The way to the node; on ``sim`` it is ours, made here."""
    if parse_bus_url(bus).interface == SIM:
        from rfms_can.rig.nodes import make_joint
        from rfms_can.rig.settings import RunSettings

        settings = RunSettings()
        return SimulatedLine(lambda: make_joint(joint, settings, wire))
    from rfms_can.bus.driver import open_port

    port = open_port(bus, None, client="conform")
    return PortLine(port, 0 if is_simulated(bus) else SETTLE_NS)


def _run(tester: Tester, checks: Sequence[Check], fail_fast: bool) -> list[Outcome]:
    """Run the checks behind a progress bar."""
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, TimeElapsedColumn(), console=Console(stderr=True)) as progress:
        bar = progress.add_task("conform", total=len(checks))

        def begins(check: Check) -> None:
            progress.update(bar, description=f"{check.id} {check.title[:48]}")

        outcomes = []
        for outcome in run_checks(tester, checks, fail_fast=fail_fast, begins=begins):
            outcomes.append(outcome)
            progress.advance(bar)
        progress.update(bar, description="conform")
    return outcomes


def _print(number: int, outcomes: Iterable[Outcome]) -> None:
    """A line for each check, and what was sent, got and wanted where one failed."""
    console = Console(soft_wrap=True, highlight=False, markup=False)
    counts = dict.fromkeys(Verdict, 0)
    for o in outcomes:
        counts[o.verdict] += 1
        console.print(f"{o.verdict.value:8}", style=STYLES[o.verdict], end="")
        console.print(f"{o.id:4} {o.title}{'' if o.required else ' (recommended)'}")
        if o.verdict is Verdict.FAILED:
            for word, text in (("sent", o.sent), ("got", o.got), ("want", o.want)):
                console.print(f"{'':13}{word:5}{text}")
        elif o.verdict is not Verdict.PASSED:
            console.print(f"{'':13}{o.got}", style="dim")
    told = ", ".join(f"{count} {verdict.value}" for verdict, count in counts.items() if count)
    console.print(f"joint {number}: {told}")

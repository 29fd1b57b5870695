"""``rfms campaign``: the peg in the hole, many times, under every law; one table."""

import json
import os
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from rfms_can.cli.options import JsonOption
from rfms_can.compliance import ControlLaw
from rfms_can.errors import RfmsError


def campaign(
    *,
    seeds: Annotated[int, typer.Option(help="misalignments of each group")] = 100,
    law: Annotated[
        list[ControlLaw] | None, typer.Option(help="repeatable; all of them if absent")
    ] = None,
    friction: Annotated[
        list[str] | None, typer.Option(help="repeatable; thesis and none if absent")
    ] = None,
    loop: Annotated[str, typer.Option(help="force loop: open | closed")] = "open",
    offset: Annotated[float, typer.Option(help="how far off the hole may be, mm")] = 1.0,
    tilt: Annotated[float, typer.Option(help="and how much tilted, degrees")] = 0.5,
    dither: Annotated[float, typer.Option(help="part of the friction, 0 to 1")] = 0.9,
    workers: Annotated[int, typer.Option(help="processes")] = os.cpu_count() or 1,
    keep: Annotated[
        Path | None, typer.Option(help="file of results: read, added to, and not made twice")
    ] = None,
    program: Annotated[
        Path | None, typer.Option(help="program of the insertion; the demo's if absent")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Insert the peg with drawn misalignments, and compare the laws on the same ones."""
    from rfms_can.analysis.campaign.job import Group, Insertion
    from rfms_can.analysis.campaign.runs import jobs_of, run_all
    from rfms_can.analysis.campaign.summary import markdown, rows_of, table
    from rfms_can.cli.demo import demo_program

    _check(seeds, loop, offset, tilt, dither)
    laws = law or list(ControlLaw)
    groups = [
        Group(each.value, "open" if each is ControlLaw.POSITION else loop, name, offset, tilt)
        for name in friction or ["thesis", "none"]
        for each in laws
    ]
    jobs = jobs_of(groups, range(seeds), dither)
    for job in jobs[: len(groups)]:
        _ = job.settings  # wrong words are told before anything runs
    with _progress() as progress:
        task = progress.add_task("peg in hole", total=len(jobs))

        def done(_: Insertion) -> None:
            progress.advance(task)

        results = run_all(jobs, program or demo_program(), workers=workers, keep=keep, done=done)
    rows = rows_of(results)
    if as_json:
        report: dict[str, Any] = {
            "rows": [{**row.group._asdict(), **_numbers(row)} for row in rows],
            "dither": dither,
        }
        json.dump(report, sys.stdout)
        sys.stdout.write("\n")
        return
    if sys.stdout.isatty():
        Console().print(table(rows, f"peg in hole, {seeds} misalignments each, dither {dither:g}"))
    else:
        sys.stdout.write(markdown(rows))


def _numbers(row: Any) -> dict[str, Any]:
    return {key: value for key, value in row._asdict().items() if key != "group"}


def _check(seeds: int, loop: str, offset: float, tilt: float, dither: float) -> None:
    if seeds < 1:
        raise RfmsError(f"seeds {seeds}: give one or more")
    if loop not in ("open", "closed"):
        raise RfmsError(f"loop {loop!r}: it is open or closed")
    for name, value, most in (
        ("offset", offset, 3.0),
        ("tilt", tilt, 5.0),
        ("dither", dither, 1.0),
    ):
        if not 0.0 <= value <= most:
            raise RfmsError(f"{name} {value:g} is not in 0..{most:g}")


def _progress() -> Progress:
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        console=Console(stderr=True),
    )

"""``rfms campaign``: many peg-in-hole insertions under every control law; one table."""

import os
from pathlib import Path
from typing import Annotated

import typer

from rfms_can.cli.options import ClusterOption, JsonOption, KeepOption, WorkersOption
from rfms_can.compliance import ControlLaw
from rfms_can.errors import RfmsError

LOOPS = ("open", "closed")


def campaign(
    *,
    seeds: Annotated[int, typer.Option(help="misalignments of each group")] = 100,
    law: Annotated[
        list[ControlLaw] | None, typer.Option(help="repeatable; all of them if absent")
    ] = None,
    friction: Annotated[
        list[str] | None, typer.Option(help="repeatable; thesis and none if absent")
    ] = None,
    loop: Annotated[
        list[str] | None,
        typer.Option(help="force loop, open | closed; repeatable; both if absent"),
    ] = None,
    offset: Annotated[
        float | None,
        typer.Option(
            help="largest offset of the hole, mm; 1 with an open loop, 2 with a closed one"
        ),
    ] = None,
    tilt: Annotated[
        float | None,
        typer.Option(help="largest tilt, degrees; 0.5 with an open loop, 1 with a closed one"),
    ] = None,
    dither: Annotated[float, typer.Option(help="fraction of the friction, 0 to 1")] = 0.9,
    workers: WorkersOption = None,
    cluster: ClusterOption = None,
    keep: KeepOption = None,
    program: Annotated[
        Path | None, typer.Option(help="program of the insertion; the demo's if absent")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Insert the peg with drawn misalignments, and compare the laws on the same ones."""
    from rfms_can.analysis.campaign.conditions import Conditions
    from rfms_can.analysis.campaign.job import FRICTIONS, TASKS, groups_of
    from rfms_can.analysis.campaign.results import RESULTS
    from rfms_can.analysis.campaign.runs import jobs_of, run_all
    from rfms_can.analysis.campaign.summary import rows_of
    from rfms_can.cli.campaign_report import print_campaign
    from rfms_can.cli.demo import demo_program
    from rfms_can.engine import backend_of
    from rfms_can.rig.program import load_program

    _check(seeds, loop or [], offset, tilt, dither)
    tasks = [
        task._replace(
            offset_mm=task.offset_mm if offset is None else offset,
            tilt_deg=task.tilt_deg if tilt is None else tilt,
        )
        for task in TASKS
        if task.loop in (loop or LOOPS)
    ]
    groups = groups_of(tasks, friction or FRICTIONS, law or tuple(ControlLaw))
    jobs = jobs_of(groups, range(seeds), dither)
    for job in jobs[: len(groups)]:
        _ = job.settings  # invalid words are refused before the first run
    path = program or demo_program()
    load_program(path)
    conditions = Conditions.of(path, dither)
    backend = backend_of(workers, cluster, default=os.cpu_count() or 1)
    runs = run_all(jobs, path, RESULTS.open(keep, conditions), backend)
    print_campaign(conditions, rows_of(runs), as_json=as_json)


def _check(
    seeds: int,
    loops: list[str],
    offset: float | None,
    tilt: float | None,
    dither: float,
) -> None:
    if seeds < 1:
        raise RfmsError(f"seeds {seeds}: give one or more")
    for loop in loops:
        if loop not in LOOPS:
            raise RfmsError(f"loop {loop!r}: it is open or closed")
    for name, value, bound in (
        ("offset", offset, 3.0),
        ("tilt", tilt, 5.0),
        ("dither", dither, 1.0),
    ):
        if value is not None and not 0.0 <= value <= bound:
            raise RfmsError(f"{name} {value:g} is not in 0..{bound:g}")

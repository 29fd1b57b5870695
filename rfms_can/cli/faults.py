"""``rfms faults``: puts each fault of the table into a system that moves; one table."""

import os
from pathlib import Path
from typing import Annotated

import typer

from rfms_can.arm import ARMS
from rfms_can.cli.options import ARM_WORDS, ClusterOption, JsonOption
from rfms_can.errors import RfmsError


def faults(
    *,
    rows: Annotated[
        str, typer.Option(help="numbers of rows, as 1,4-7; all of them if absent")
    ] = "",
    seeds: Annotated[int, typer.Option(help="trials of each variant on each arm")] = 100,
    arm: Annotated[
        list[str] | None, typer.Option(help=f"{ARM_WORDS}; repeatable; all of them if absent")
    ] = None,
    jobs: Annotated[
        int | None, typer.Option(help="processes; one for each processor if absent")
    ] = None,
    cluster: ClusterOption = None,
    bus: Annotated[str, typer.Option(help="bus of the trials: sim")] = "sim",
    keep: Annotated[
        Path | None, typer.Option(help="file of results; trials already in it are not repeated")
    ] = None,
    replay: Annotated[
        str | None, typer.Option(help="ROW:VARIANT:SEED: make this trial, with record and plot")
    ] = None,
    record: Annotated[
        Path | None, typer.Option(help="directory of --replay; fault-ROW-VARIANT-SEED if absent")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Put faults into a system that moves; tell how each was found, named and survived.

    Exit code 1 if a row is not met.
    """
    from rfms_can.faults.campaign import lines_of, met_rows, rows_from, run_all, trials_of

    arms = _checked(seeds, jobs, bus, arm)
    if replay is not None:
        _replay(replay, arms[0], record, as_json)
        return
    from rfms_can.cli.faults_report import print_faults
    from rfms_can.engine import backend_of
    from rfms_can.faults.results import kept_in

    numbers = rows_from(rows)
    trials = trials_of(numbers, arms, seeds)
    backend = backend_of(jobs, cluster, default=os.cpu_count() or 1)
    results = run_all(trials, kept_in(keep), backend)
    lines = lines_of(numbers, arms, results)
    print_faults(lines, as_json=as_json)
    if not all(met_rows(lines).values()):
        raise typer.Exit(1)


def _checked(seeds: int, jobs: int | None, bus: str, arm: list[str] | None) -> list[str]:
    """The arms; refuse what cannot be."""
    for name, number in (("seeds", seeds), ("jobs", jobs)):
        if number is not None and number < 1:
            raise RfmsError(f"{name} {number}: give one or more")
    if bus != "sim":
        raise RfmsError(f"bus {bus!r}: faults of processes have no injector yet; give sim")
    for name in arm or ():
        if name not in ARMS:
            raise RfmsError(f"arm {name!r} does not exist; there are: {', '.join(ARMS)}")
    return arm or list(ARMS)


def _replay(text: str, arm: str, record: Path | None, as_json: bool) -> None:
    """One trial, in this process."""
    from rfms_can.cli.faults_report import print_trial
    from rfms_can.faults.campaign import trial_from
    from rfms_can.faults.replay import replay as make_again

    trial = trial_from(text, arm)
    place = record or Path("fault-" + trial.words.replace(": ", "-").replace(":", "-"))
    result, files = make_again(trial, place)
    print_trial(result, files, as_json=as_json)
    if not result.met:
        raise typer.Exit(1)

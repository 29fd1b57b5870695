"""``rfms faults``: puts each fault of the table into a system that moves; one table."""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from rfms_can.arm import ARMS
from rfms_can.bus.url import HUB, SIM, SOCKETCAN
from rfms_can.cli.options import ARM_WORDS, ClusterOption, JsonOption
from rfms_can.errors import RfmsError

if TYPE_CHECKING:
    from rfms_can.faults.campaign import Processes
    from rfms_can.faults.table import Where

VCAN0: Final = "vcan0"
BUSES: Final = {SIM: SIM, HUB: "", VCAN0: f"{SOCKETCAN}:{VCAN0}"}
"""Buses of trials, and their URLs; each trial on a hub has one of its own."""


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
        int | None,
        typer.Option(
            help="trials at a time; one for each processor if absent, on hub and vcan0 one"
        ),
    ] = None,
    cluster: ClusterOption = None,
    bus: Annotated[
        str, typer.Option(help="of the trials: sim, or hub or vcan0 for faults of processes")
    ] = SIM,
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

    arms = _checked(seeds, jobs, bus, cluster, arm)
    where, processes = _system(bus)
    if replay is not None:
        _replay(replay, arms[0], record, where, processes, as_json=as_json)
        return
    from rfms_can.cli.faults_report import print_faults
    from rfms_can.engine import backend_of
    from rfms_can.faults.results import kept_in

    numbers = rows_from(rows)
    trials = trials_of(numbers, arms, seeds, where)
    if not trials:
        raise RfmsError(f"rows {rows}: none is tried with {where.value}; give another --bus")
    default = 1 if processes else os.cpu_count() or 1
    backend = backend_of(jobs, cluster, default=default)
    results = run_all(trials, kept_in(keep, bus), backend, processes)
    lines = lines_of(numbers, arms, results, where)
    print_faults(lines, bus, as_json=as_json)
    if not all(met_rows(lines).values()):
        raise typer.Exit(1)


def _checked(
    seeds: int, jobs: int | None, bus: str, cluster: str | None, arm: list[str] | None
) -> list[str]:
    """The arms; refuse what cannot be."""
    for name, number in (("seeds", seeds), ("jobs", jobs)):
        if number is not None and number < 1:
            raise RfmsError(f"{name} {number}: give one or more")
    if bus not in BUSES:
        raise RfmsError(f"bus {bus!r}: faults are tried on {', '.join(BUSES)}")
    if bus == VCAN0 and jobs not in (None, 1):
        raise RfmsError(f"jobs {jobs}: there is one vcan0, and one system on it; leave --jobs out")
    if bus != SIM and cluster is not None:
        raise RfmsError(f"bus {bus!r}: processes are started on this machine; leave --cluster out")
    for name in arm or ():
        if name not in ARMS:
            raise RfmsError(f"arm {name!r} does not exist; there are: {', '.join(ARMS)}")
    return arm or list(ARMS)


def _system(bus: str) -> "tuple[Where, Processes | None]":
    """On what system trials are made on a bus, and what starts its processes."""
    from rfms_can.faults.table import Where

    if bus == SIM:
        return Where.SIM, None
    import rfms_can.rig.fleet  # noqa: F401  # what is loaded here, no process of a trial loads
    from rfms_can.cli.app import main
    from rfms_can.faults.campaign import Processes

    return Where.PROCESSES, Processes(BUSES[bus], main)


def _replay(
    text: str,
    arm: str,
    record: Path | None,
    where: "Where",
    processes: "Processes | None",
    *,
    as_json: bool,
) -> None:
    """One trial, with a record."""
    from rfms_can.cli.faults_report import print_trial
    from rfms_can.faults.campaign import trial_from
    from rfms_can.faults.replay import replay as make_again

    trial = trial_from(text, arm, where)
    place = record or Path("fault-" + trial.words.replace(": ", "-").replace(":", "-"))
    if processes is None:
        result, files = make_again(trial, place)
    else:
        result = processes.make(trial, place)
        files = sorted(place.iterdir())
    print_trial(result, files, as_json=as_json)
    if not result.met:
        raise typer.Exit(1)

"""``rfms identify``: find out about the arm on the bus what a master needs to know of it."""

import json
import os
import tempfile
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rfms_can.cli.options import JsonOption, takes_settings
from rfms_can.rig.interrupt import signals_noted
from rfms_can.rig.settings import RunSettings

if TYPE_CHECKING:
    from rfms_can.analysis.identification.result import Identification
    from rfms_can.arm.calibration import Calibration

SETTINGS = (
    *("arm", "bus", "clock", "rate", "friction", "plant", "servo_friction"),
    *("barrier", "patience", "seed"),
)


@takes_settings(*SETTINGS)
def identify(
    *,
    settings: RunSettings,
    out: Annotated[Path, typer.Option("--out", help="calibration file to write")] = Path(
        "arm.toml"
    ),
    data: Annotated[
        Path | None,
        typer.Option("--data", help="directory of the experiments' data; goes on where they end"),
    ] = None,
    report: Annotated[
        Path | None, typer.Option("--report", help="directory for plots; needs matplotlib")
    ] = None,
    compare: Annotated[
        bool, typer.Option("--compare", help="one fast program with each compensation")
    ] = False,
    jobs: Annotated[
        int, typer.Option("--jobs", min=0, help="experiments side by side; 0: all processors")
    ] = 0,
    attach: Annotated[
        bool, typer.Option("--attach", help="boards and joint nodes are on the bus already")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Identify an arm: probe its wires, run the experiments, write a calibration file.

    With --data an interrupted procedure goes on with what it has.
    """
    from rfms_can.analysis.identification.identify import identify as analyse
    from rfms_can.analysis.identification.result import calibration_of
    from rfms_can.arm.calibration import save_calibration
    from rfms_can.cli.identify_progress import ExperimentProgress
    from rfms_can.rig.identification.experiments import experiments
    from rfms_can.rig.identification.probing import probe, require_sound
    from rfms_can.rig.identification.procedure import run_all, tasks_of

    require_sound(probe(settings, attach))
    with signals_noted() as interrupt:
        place = nullcontext(str(data)) if data is not None else tempfile.TemporaryDirectory()
        with place as directory:
            tasks = tasks_of(experiments(settings.the_arm), settings, Path(directory), attach)
            try:
                with ExperimentProgress(tasks, quiet=as_json) as watcher:
                    found_data = run_all(
                        tasks,
                        watcher,
                        jobs=jobs or os.cpu_count() or 1,
                        ask=watcher.ask,
                        interrupted=interrupt,
                    )
            except KeyboardInterrupt:
                kept = "; --data DIR keeps what is there" if data is None else f"; {data} is kept"
                typer.echo(f"rfms: interrupted{kept}", err=True)
                raise typer.Exit(interrupt.exit_code) from None
    found = analyse(settings.the_arm, found_data)
    calibration = calibration_of(found)
    save_calibration(out, calibration)
    _tell(settings, found, calibration, out, report, compare, jobs, as_json)


def _tell(
    settings: RunSettings,
    found: "Identification",
    calibration: "Calibration",
    out: Path,
    report: Path | None,
    compare: bool,
    jobs: int,
    as_json: bool,
) -> None:
    """Print what was found, beside the truth where there is one to know; draw it."""
    from rfms_can.analysis.identification.summary import summary
    from rfms_can.analysis.identification.truth import truth_of
    from rfms_can.cli.identify_report import (
        print_report,
        print_significance,
        print_tracking,
    )
    from rfms_can.plant.variant import make_variant

    truth = truth_of(make_variant(settings.plant, settings.the_arm, settings.friction))
    tracking = None
    if compare:
        from rfms_can.rig.identification.control import compare as run_each
        from rfms_can.rig.identification.control import compensations

        with tempfile.TemporaryDirectory() as directory:
            runs = compensations(settings, Path(directory), calibration, truth)
            tracking = run_each(runs, jobs or os.cpu_count() or 1)
    if as_json:
        typer.echo(json.dumps(summary(found, calibration, truth, tracking)))
    else:
        print_report(found, calibration, truth)
        print_significance(found)
        if tracking is not None:
            print_tracking(settings, tracking)
    if report is not None:
        from rfms_can.analysis.identification.figures import draw

        for path in draw(found, truth, tracking, report):
            typer.echo(path, err=as_json)
    if not as_json:
        typer.echo(f"{out}: use it with --calibration {out}")

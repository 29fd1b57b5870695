"""``rfms identify``: identify the parameters of the arm on the bus, for the master."""

import json
import os
import tempfile
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from rfms_can.cli.options import JsonOption, takes_settings
from rfms_can.rig.interrupt import signals_noted
from rfms_can.rig.settings import RunSettings

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rfms_can.arm.calibration import Calibration
    from rfms_can.identification.compensation_comparison import Tracking
    from rfms_can.identification.experiments.data import Data
    from rfms_can.identification.fit.result import Identification

SETTINGS = (
    *("arm", "bus", "clock", "rate", "friction", "plant", "servo_friction"),
    *("barrier", "patience", "seed"),
)


class Options(NamedTuple):
    """Options besides the settings; see the flags."""

    out: Path
    data: Path | None
    report: Path | None
    compare: bool
    jobs: int
    attach: bool
    as_json: bool


@takes_settings(*SETTINGS)
def identify(
    *,
    settings: RunSettings,
    out: Annotated[Path, typer.Option("--out", help="calibration file to write")] = Path(
        "arm.toml"
    ),
    data: Annotated[
        Path | None,
        typer.Option("--data", help="directory of the experiments' data, to resume from"),
    ] = None,
    report: Annotated[
        Path | None, typer.Option("--report", help="directory for plots; needs matplotlib")
    ] = None,
    compare: Annotated[
        bool, typer.Option("--compare", help="one fast program with each compensation")
    ] = False,
    jobs: Annotated[
        int, typer.Option("--jobs", min=0, help="experiments in parallel; 0: all processors")
    ] = 0,
    attach: Annotated[
        bool, typer.Option("--attach", help="boards and joint nodes are on the bus already")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Identify an arm: check its wiring, run the experiments, write a calibration file.

    With --data an interrupted procedure is resumed.
    """
    from rfms_can.arm.calibration import save_calibration
    from rfms_can.identification.experiments.probing import probe, require_sound
    from rfms_can.identification.fit.identify import identify as analyse
    from rfms_can.identification.fit.result import calibration_of

    jobs = jobs or os.cpu_count() or 1
    options = Options(out, data, report, compare, jobs, attach, as_json)
    require_sound(probe(settings, attach))
    found = analyse(settings.the_arm, _measure(settings, options))
    calibration = calibration_of(found)
    save_calibration(out, calibration)
    _print_result(settings, found, calibration, options)


def _measure(settings: RunSettings, options: Options) -> "Mapping[str, Data]":
    """The data of all experiments, of this run and of earlier ones."""
    from rfms_can.cli.identify_progress import ExperimentProgress
    from rfms_can.identification.experiments.plan import experiments
    from rfms_can.identification.experiments.procedure import run_all, tasks_of

    data = options.data
    place = nullcontext(str(data)) if data is not None else tempfile.TemporaryDirectory()
    with signals_noted() as interrupt, place as directory:
        plan = experiments(settings.the_arm)
        tasks = tasks_of(plan, settings, Path(directory), options.attach)
        try:
            with ExperimentProgress(tasks, quiet=options.as_json) as watcher:
                return run_all(
                    tasks, watcher, jobs=options.jobs, ask=watcher.ask, interrupted=interrupt
                )
        except KeyboardInterrupt:
            kept = "; --data DIR keeps what is there" if data is None else f"; {data} is kept"
            typer.echo(f"rfms: interrupted{kept}", err=True)
            raise typer.Exit(interrupt.exit_code) from None


def _print_result(
    settings: RunSettings, found: "Identification", calibration: "Calibration", options: Options
) -> None:
    """Print the result beside the plant's true values, or beside the data sheet of a real arm."""
    from rfms_can.cli.identify_report import print_report, print_significance, print_tracking
    from rfms_can.identification.fit.summary import summary
    from rfms_can.identification.fit.truth import truth_of
    from rfms_can.plant.variant import as_built, make_variant

    arm, friction = settings.the_arm, settings.friction
    plant = (
        as_built(arm, friction) if options.attach else make_variant(settings.plant, arm, friction)
    )
    truth = truth_of(plant)
    tracking = _compare(settings, calibration, truth, options) if options.compare else None
    if options.as_json:
        typer.echo(json.dumps(summary(found, calibration, truth, tracking)))
    else:
        print_report(found, calibration, truth, "data sheet" if options.attach else "plant")
        print_significance(found)
        if tracking is not None:
            print_tracking(settings, tracking)
    if options.report is not None:
        from rfms_can.identification.fit.figures import draw

        for path in draw(found, truth, tracking, options.report):
            typer.echo(path, err=options.as_json)
    if not options.as_json:
        typer.echo(f"{options.out}: use it with --calibration {options.out}")


def _compare(
    settings: RunSettings, calibration: "Calibration", truth: "Calibration", options: Options
) -> "Sequence[Tracking]":
    """One fast program with each compensation; the true one only where it is known."""
    from rfms_can.identification.compensation_comparison import compare, compensations

    with tempfile.TemporaryDirectory() as directory:
        known = None if options.attach else truth
        runs = compensations(settings, Path(directory), calibration, known)
        return compare(runs, options.jobs, options.attach)

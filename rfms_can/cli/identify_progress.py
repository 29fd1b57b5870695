"""Progress display while experiments run."""

from collections.abc import Sequence
from types import TracebackType
from typing import Self

import typer
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from rfms_can.cli.report import console
from rfms_can.identification.experiments.plan import Experiment
from rfms_can.identification.experiments.procedure import Task
from rfms_can.rig.session import Session


class ExperimentProgress:
    """A progress bar of experiments; without a terminal only its last state is printed."""

    def __init__(self, tasks: Sequence[Task], *, quiet: bool) -> None:
        self._progress = Progress(
            TextColumn("[bold]identify"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[what]}"),
            TimeElapsedColumn(),
            console=console,
            disable=quiet,
        )
        self._task = self._progress.add_task("identify", total=len(tasks), what="")
        self._name = ""
        self._loaded = False

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._progress.stop()

    def ask(self, load: bool) -> None:
        """Prompt the user to attach the known load or to remove it, if it has to change.

        The arm is braked between experiments.
        """
        if load is not self._loaded:
            what = "Attach the known load to the hand" if load else "Remove the load from the hand"
            self._progress.stop()
            typer.prompt(f"{what} (arm/load.py), and press Enter", default="", show_default=False)
            self._progress.start()
            self._loaded = load

    def begin(self, experiment: Experiment) -> None:
        """An experiment begins."""
        self._name = experiment.name
        self._progress.update(self._task, what=experiment.name)

    def cycles(self, session: Session) -> None:
        """Called periodically while it runs."""
        master = session.master
        seconds = master.statistics.cycles / master.settings.rate_hz
        self._progress.update(self._task, what=f"{self._name} {seconds:.1f} s")

    def end(self, experiment: Experiment, kept: bool) -> None:
        """Its data are complete."""
        what = f"{experiment.name} {'kept' if kept else 'done'}"
        self._progress.update(self._task, advance=1, what=what)

"""Runs the experiments, saves their data, and resumes after an interruption."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple, Protocol

from rfms_can.engine import Processes, run
from rfms_can.errors import FaultError, JobError
from rfms_can.identification.compensation_comparison import uncompensated
from rfms_can.identification.experiments.actions import Mark, program_of
from rfms_can.identification.experiments.data import (
    SUFFIX,
    Data,
    DataError,
    fingerprint,
    load,
    save,
)
from rfms_can.identification.experiments.plan import Experiment
from rfms_can.identification.experiments.tap import Tap
from rfms_can.plant.variant import WITH_LOAD
from rfms_can.rig.candump import read_candump
from rfms_can.rig.record import LOG
from rfms_can.rig.runner import execute
from rfms_can.rig.session import Rig, Session
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame

Ask = Callable[[bool], None]
"""Prompts the user to attach the known load (True) or to remove it; returns when it is done."""


class Watcher(Protocol):
    """Observer of the progress."""

    def begin(self, experiment: Experiment) -> None:
        """An experiment begins; only if they run sequentially."""

    def cycles(self, session: Session) -> None:
        """Called periodically while it runs, likewise."""

    def end(self, experiment: Experiment, kept: bool) -> None:
        """Its data are complete; ``kept``: they are from an earlier run."""


class Task(NamedTuple):
    """An experiment with its settings and the file of its data."""

    experiment: Experiment
    settings: RunSettings
    path: Path
    digest: str
    attach: bool = False


def tasks_of(
    plan: Sequence[Experiment], settings: RunSettings, directory: Path, attach: bool = False
) -> tuple[Task, ...]:
    """The experiments as tasks. The master compensates no dynamics, whatever the settings say.

    With a real arm (``attach``) the user has to attach the load to its hand.
    """
    tasks = []
    for experiment in plan:
        own = uncompensated(settings)
        if experiment.load and not attach:
            own = replace(own, plant=own.plant + WITH_LOAD)
        path = directory / (experiment.name + SUFFIX)
        tasks.append(Task(experiment, own, path, fingerprint(experiment, own), attach))
    return tuple(tasks)


def run_all(
    tasks: Sequence[Task],
    watcher: Watcher,
    *,
    jobs: int = 1,
    ask: Ask | None = None,
    interrupted: Callable[[], bool] = lambda: False,
) -> Mapping[str, Data]:
    """The data of all experiments, by name: read if they exist, otherwise the experiment is run.

    Args:
        tasks: the experiments.
        watcher: observer of the progress.
        jobs: number of processes for simulated experiments.
        ask: prompts for the load, with a real arm.
        interrupted: whether to end; data of finished experiments are kept.

    Raises:
        DataError: existing data do not match.
        FaultError: a fault halted an experiment.
        JobError: an experiment failed otherwise, in a process of its own.
        KeyboardInterrupt: ``interrupted`` returned True.
    """
    found: dict[str, Data] = {}
    for task in tasks:
        data = load(task.path, task.digest)
        if data is not None:
            found[task.experiment.name] = data
            watcher.end(task.experiment, True)
    missing = [task for task in tasks if task.experiment.name not in found]
    if min(jobs, len(missing)) > 1 and all(task.settings.simulated for task in missing):
        found.update(_side_by_side(missing, watcher, jobs, interrupted))
        return found
    for task in missing:
        found[task.experiment.name] = _by_itself(task, watcher, ask, interrupted)
    return found


def _by_itself(
    task: Task, watcher: Watcher, ask: Ask | None, interrupted: Callable[[], bool]
) -> Data:
    """Run an experiment in this process and save its data."""
    watcher.begin(task.experiment)
    if ask is not None and task.attach:
        ask(task.experiment.load)
    data = run_one(task, watcher.cycles, interrupted)
    save(task.path, data, task.digest)
    watcher.end(task.experiment, False)
    return data


def _side_by_side(
    tasks: Sequence[Task], watcher: Watcher, jobs: int, interrupted: Callable[[], bool]
) -> dict[str, Data]:
    found: dict[str, Data] = {}

    def tick() -> None:
        if interrupted():
            raise KeyboardInterrupt

    try:
        for task in run(_work, tasks, Processes(min(jobs, len(tasks))), name=_name, tick=tick):
            data = load(task.path, task.digest)
            if data is None:
                raise DataError(
                    f"data {task.path}: removed while the experiments ran; run them again"
                )
            found[task.experiment.name] = data
            watcher.end(task.experiment, False)
    except JobError as error:
        cause = error.__cause__
        if isinstance(cause, DataError | FaultError):  # it names the experiment itself
            raise cause from None
        raise
    return found


def _name(task: Task) -> str:
    return task.experiment.name


def _work(task: Task) -> Task:
    data = run_one(task)
    save(task.path, data, task.digest)
    return task


def run_one(
    task: Task,
    progress: Callable[[Session], None] | None = None,
    interrupted: Callable[[], bool] = lambda: False,
) -> Data:
    """Run an experiment.

    On the simulated bus its frames are captured directly; elsewhere they are recorded beside the
    data and read back.
    """
    experiment, settings = task.experiment, task.settings
    marks: list[Mark] = []
    tap, rigs = Tap(Wire()), list[Rig]()

    def watch(rig: Rig) -> None:
        rigs.append(rig)
        if isinstance(rig, SimulatedRig):
            rig.observe(tap.take)

    record = None if settings.simulated else task.path.with_suffix("")
    outcome = execute(
        program_of(experiment.actions, settings.the_arm, marks),
        settings,
        record=record,
        progress=progress,
        attach=task.attach,
        watch=watch,
        interrupted=interrupted,
    )
    if outcome.fault is not None:
        raise FaultError(f"experiment {experiment.name}: {outcome.fault}") from outcome.fault
    if record is not None:
        frames: list[tuple[float, Frame]] = read_candump(record / LOG)
        for _, frame in frames:
            tap.take(0, frame)
    zero_counts = tuple(rigs[0].master.arm_state.zero_counts)
    period_s = 1.0 / settings.rate
    return Data(tap.table, zero_counts, tuple(marks), period_s, experiment.load)

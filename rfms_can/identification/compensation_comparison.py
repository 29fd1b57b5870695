"""Comparison of the dynamics compensations: tracking errors of one fast program, same gains."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final, NamedTuple

from rfms_can.arm.calibration import Calibration, save_calibration
from rfms_can.compliance import ControlLaw
from rfms_can.dynamics.model import FULL, NONE, SIMPLIFIED
from rfms_can.engine import Processes, run
from rfms_can.errors import FaultError, JobError
from rfms_can.identification.experiments.actions import Tour, program_of
from rfms_can.identification.experiments.plan import fast_tour
from rfms_can.rig.result import JointResult
from rfms_can.rig.runner import execute
from rfms_can.rig.settings import RunSettings


class Tracking(NamedTuple):
    """Tracking errors with one compensation.

    Attributes:
        name: of the compensation.
        joints: largest and rms error of each while it moves.
        rms: of all six joints' rms errors, rad.
        largest: error of any joint, rad.
    """

    name: str
    joints: tuple[JointResult, ...]
    rms: float
    largest: float


LAW: Final = ControlLaw.HYBRID.value
"""A law whose joint gains do not depend on the model, unlike those of the weighted law."""
FOLLOWING_ERROR_RAD: Final = 0.08
"""Following error that is allowed where the master compensates nothing: the bound of a modelled arm
is half of this. Bursts of the PUMA 260 leave 0.038 rad at joint 1, with the known load 0.045, and
with half as much friction again besides, where the torque is at its limit, 0.057."""
UNCOMPENSATED: Final = "none"
NOMINAL: Final = "nominal"
IDENTIFIED: Final = "identified"
IDENTIFIED_SIMPLE: Final = "identified, simplified"
TRUTH: Final = "the plant's truth"


def uncompensated(settings: RunSettings) -> RunSettings:
    """The settings without any compensation of dynamics; a bound of the following error of the
    user's own is kept."""
    allowed = settings.following_error or FOLLOWING_ERROR_RAD
    return replace(settings, dynamics=NONE, calibration="", law=LAW, following_error=allowed)


def compensations(
    settings: RunSettings, directory: Path, found: Calibration, truth: Calibration | None
) -> dict[str, RunSettings]:
    """Settings of each run, by name; calibrations are written into ``directory``."""
    save_calibration(directory / "identified.toml", found)
    identified = str(directory / "identified.toml")
    settings = replace(settings, law=LAW)
    runs = {
        UNCOMPENSATED: uncompensated(settings),
        NOMINAL: replace(settings, dynamics=FULL, calibration=""),
        IDENTIFIED_SIMPLE: replace(settings, dynamics=SIMPLIFIED, calibration=identified),
        IDENTIFIED: replace(settings, dynamics=FULL, calibration=identified),
    }
    if truth is not None:
        save_calibration(directory / "truth.toml", truth)
        true = str(directory / "truth.toml")
        runs[TRUTH] = replace(settings, dynamics=FULL, calibration=true)
    return runs


def compare(runs: Mapping[str, RunSettings], jobs: int = 1, attach: bool = False) -> list[Tracking]:
    """The fast program with each compensation; ``attach``: nodes and boards are on the bus.

    Raises:
        FaultError: a fault halted one of the runs.
        JobError: one of them failed otherwise.
    """
    tasks = list(runs.items())
    if jobs > 1 and all(settings.simulated for settings in runs.values()):
        try:
            return list(run(_run, tasks, Processes(jobs), in_order=True, name=_name))
        except JobError as error:
            cause = error.__cause__
            if isinstance(cause, FaultError):  # it names the compensation itself
                raise cause from None
            raise
    return [_run(task, attach) for task in tasks]


def _name(task: tuple[str, RunSettings]) -> str:
    return task[0]


def _run(task: tuple[str, RunSettings], attach: bool = False) -> Tracking:
    name, settings = task
    tour: Tour = fast_tour(settings.the_arm)
    outcome = execute(program_of((tour,), settings.the_arm, []), settings, attach=attach)
    if outcome.fault is not None:
        raise FaultError(f"compensation {name!r}: {outcome.fault}") from outcome.fault
    joints = tuple(outcome.result.joints)
    squares = sum(joint.moving_rms**2 for joint in joints) / len(joints)
    return Tracking(name, joints, squares**0.5, max(joint.moving_max for joint in joints))

"""Programs on the simulated bus: a run's result and rests, or each cycle of a run in a scene."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from rfms_can.bus.statistics import BusStatistics
from rfms_can.master.report import status_of
from rfms_can.master.statistics import SETTLING_S
from rfms_can.messages import Status
from rfms_can.rig.program import load_program
from rfms_can.rig.result import RunResult
from rfms_can.rig.runner import execute
from rfms_can.rig.session import Program, Rig
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.rig.truth import Truth
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import JointError
from support.programs.there_and_back import program as there_and_back

ROOT = Path(__file__).parents[2]
TRANSFER = ROOT / "examples" / "transfer.py"
SHORT = Path(__file__).with_name("programs") / "short_program.py"

LONG_REST_S = 0.8
"""A rest as long as this, after settling, must be one without hunting."""


@dataclass(frozen=True)
class Rest:
    """One joint's errors, encoder counts, in one rest, from the end of settling on."""

    joint: int
    seconds: float
    lowest: float
    highest: float

    @property
    def peak_to_peak(self) -> float:
        return self.highest - self.lowest


@dataclass(frozen=True)
class SimulatedRun:
    """A run on the simulated bus: its result, its rests, its bus."""

    settings: RunSettings
    result: RunResult
    rests: tuple[Rest, ...]
    bus: BusStatistics

    @property
    def long_rests(self) -> list[Rest]:
        return [rest for rest in self.rests if rest.seconds >= LONG_REST_S]

    def moving_max_deg(self) -> list[float]:
        return [math.degrees(joint.moving_max) for joint in self.result.joints]

    def settled_max_counts(self) -> list[float]:
        return [joint.settled_max_counts or 0.0 for joint in self.result.joints]


class RestWatch:
    """Cuts the ERROR frames of a simulated run into rests, by what the master commands."""

    def __init__(self, rig: SimulatedRig, settings: RunSettings, wire: Wire) -> None:
        self.rests: list[Rest] = []
        self._master = rig.master
        self._settling = round(SETTLING_S * settings.rate)
        self._period_s = 1.0 / settings.rate
        self._errors: dict[int, list[float]] = {joint: [] for joint in JOINTS}
        self._receivers = {
            wire.id(JointError, joint): (joint, wire.receiver(JointError, joint))
            for joint in JOINTS
        }
        self._counts = [abs(drive.counts_per_radian) for drive in settings.the_arm.drives]
        rig.observe(self._take)

    def _take(self, _: int, frame: Frame) -> None:
        if frame.id not in self._receivers:
            return
        joint, receiver = self._receivers[frame.id]
        if self._master.motion.following.moves:
            self._end_rest(joint)
            return
        error = receiver.decoder.decode(frame)
        assert isinstance(error, JointError)
        self._errors[joint].append(error.error * self._counts[joint - 1])

    def _end_rest(self, joint: int) -> None:
        settled = self._errors[joint][self._settling :]
        if settled:
            seconds = len(settled) * self._period_s
            self.rests.append(Rest(joint, seconds, min(settled), max(settled)))
        self._errors[joint].clear()

    def close(self) -> tuple[Rest, ...]:
        """All rests, the one at the end of the program included."""
        for joint in JOINTS:
            self._end_rest(joint)
        return tuple(self.rests)


def recorded_run(directory: Path, *, terms: bool = False) -> Path:
    """Record ``there_and_back`` on the simulated bus; where it was recorded."""
    assert execute(there_and_back, RunSettings(), record=directory, terms=terms).fault is None
    return directory


@cache
def simulated_run(
    arm: str, friction: str, servo_friction: str = "", program: Path = TRANSFER
) -> SimulatedRun:
    """A program on the simulated bus; one run for all tests that look at it."""
    settings = RunSettings(arm=arm, friction=friction, servo_friction=servo_friction)
    watches: list[tuple[SimulatedRig, RestWatch]] = []

    def watch(rig: Rig) -> None:
        assert isinstance(rig, SimulatedRig)
        watches.append((rig, RestWatch(rig, settings, Wire())))

    outcome = execute(load_program(program), settings, watch=watch)
    rig, rests = watches[0]
    return SimulatedRun(settings, outcome.result, rests.close(), rig.bus.statistics)


Array = npt.NDArray[np.float64]

PERIOD_S = 0.004
_SYNC = Wire().codecs["SYNC"].id


class Moment(NamedTuple):
    """One cycle.

    Attributes:
        truth: what the plant knows; forces are means of the period before.
        status: what the server told.
        torques: what the joints had asked of their motors, Nm (6).
    """

    truth: Truth
    status: Status
    torques: list[float]

    @property
    def words(self) -> str:
        """Directions it complied in."""
        return self.status.complying


Run = Sequence[Moment]


def run(program: Program, scene: str, friction: str = "thesis", **settings: Any) -> list[Moment]:
    """A program in a scene on the simulated bus; the arm has the thesis' friction."""
    told: list[tuple[Status, list[float]]] = []
    rigs: list[SimulatedRig] = []

    def watch(rig: Rig) -> None:
        assert isinstance(rig, SimulatedRig) and rig.watch is not None
        rig.watch.keep_every_cycle()
        rigs.append(rig)

        def look(_: int, frame: Frame) -> None:
            if frame.id == _SYNC:
                told.append((status_of(rig.master), [joint.torque for joint in rig.joints]))

        rig.observe(look)

    made = RunSettings(arm="puma560", scene=scene, friction=friction, **settings)
    outcome = execute(program, made, watch=watch)
    assert outcome.fault is None, outcome.fault
    assert outcome.result.incomplete == 0
    (rig,) = rigs
    assert rig.watch is not None
    truths = {truth.cycle: truth for truth in rig.watch.rows}
    return [
        Moment(truths[status.cycle], status, torques)
        for status, torques in told
        if status.cycle in truths
    ]


def pushed(moments: Run, axis: int) -> Array:
    """What the tool exerts on the fixture, along (0 to 2) or about (3 to 5) an axis of its tip."""
    return np.array([-(*m.truth.contact.force, *m.truth.contact.torque)[axis] for m in moments])


def across(moments: Run) -> Array:
    """Size of the contact force across the tip's z, N."""
    return np.array([np.hypot(*m.truth.contact.force[:2]) for m in moments])


def rms(errors: Array) -> float:
    return float(np.sqrt(np.mean(errors**2)))


def touches(moments: Run) -> bool:
    """Whether the tool touched something in every cycle."""
    return all(m.truth.contact.points for m in moments)


def after(moments: Run, seconds: float) -> Run:
    """Without the first seconds."""
    return moments[round(seconds / PERIOD_S) :]


def runs(moments: Run, condition: Callable[[Moment], bool]) -> list[Run]:
    """Stretches of cycles of which a condition holds."""
    found: list[list[Moment]] = [[]]
    for moment in moments:
        if condition(moment):
            found[-1].append(moment)
        elif found[-1]:
            found.append([])
    return [stretch for stretch in found if stretch]

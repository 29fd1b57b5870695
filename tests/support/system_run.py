"""Runs of whole systems for tests: a program on the simulated bus, and what every rest was like."""

import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from rfms_can.bus.statistics import BusStatistics
from rfms_can.master.statistics import SETTLING_S
from rfms_can.rig.program import load_program
from rfms_can.rig.result import RunResult
from rfms_can.rig.runner import execute
from rfms_can.rig.session import Rig
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import JointError

ROOT = Path(__file__).parents[2]
TRANSFER = ROOT / "examples" / "transfer.py"
SHORT = Path(__file__).with_name("short_program.py")

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
        if self._master.motion.moves:
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

"""One program of the soak: its run from power-up to the end, its trips, its margins, its memory."""

import contextlib
import io
from typing import Any, Final

import msgspec

from rfms_can.arm import arm_by_name
from rfms_can.errors import RfmsError
from rfms_can.rig.runner import execute
from rfms_can.rig.session import Rig
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.wire.contract import LAST_CYCLE
from rfms_can.wire.emergency import in_words
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import GRIPPER, JOINTS, NODE_NAMES
from rfms_can.wire.records import Emcy
from soak.kinds import Job
from soak.motions import Drawn
from soak.watch import Watch, resident_mb, settled

LATE_EVERY: Final = 4
"""Every so many seeds the cycles of a run begin shortly before the largest number."""
BEFORE: Final = (300, 1500)
"""Fewest and most cycles before it."""


class Result(msgspec.Struct, frozen=True):
    """What became of a program.

    Attributes:
        kind, arm, seed, worn: the job.
        cycles, enabled: run, and those of them with the arm enabled.
        trips: EMCYs, faults that nodes counted, incomplete cycles; none is allowed.
        ended: error by which the program ended itself, or "".
        passed: whether the number of the cycle went on from 0.
        memory: resident memory of the process, MB: at first, after each
            ``BLOCK`` of cycles, at the end.
        margins: largest value of each quantity of ``margins.py``, six joints each.
    """

    kind: str
    arm: str
    seed: int
    worn: bool
    cycles: int
    enabled: int
    trips: list[str]
    ended: str
    passed: bool
    memory: list[float]
    margins: dict[str, list[float]]

    @property
    def job(self) -> Job:
        """The job."""
        return Job(self.kind, self.arm, self.seed, self.worn)


class Trial:
    """Runs a program of the soak.

    Args:
        job: the program.
    """

    def __init__(self, job: Job) -> None:
        self._job = job
        self._draw = job.draw
        self._rig: SimulatedRig | None = None
        self._trips: list[str] = []
        self._watch: Watch | None = None

    def run(self) -> Result:
        """From power-up to the end, as often as it says."""
        job, ended = self._job, ""
        drawn = job.drawn(self._draw)
        for start in range(drawn.starts):
            settings = job.settings(drawn, start)
            if self._watch is None:
                self._watch = Watch(arm_by_name(job.arm), 1.0 / settings.rate)
            ended = self._run(drawn, settings) or ended
        watch = self._watch
        assert watch is not None
        watch.close()
        return Result(
            *(
                *job,
                watch.cycles,
                watch.enabled,
                list(dict.fromkeys(self._trips)),
                ended,
                watch.passed,
            ),
            memory=[*watch.memory, resident_mb()],
            margins={name: settled(values) for name, values in watch.largest.items()},
        )

    def _run(self, drawn: Drawn, settings: RunSettings) -> str:
        """One run; why the program ended itself, or ""."""
        ended = ""
        try:
            with contextlib.redirect_stdout(io.StringIO()):
                outcome = execute(drawn.program, settings, watch=self._begin)
            if outcome.fault is not None:
                self._trips.append(str(outcome.fault))
        except RfmsError as error:
            ended = " ".join(str(error).split())
        self._count()
        return ended

    def _begin(self, rig: Rig) -> None:
        assert isinstance(rig, SimulatedRig) and self._watch is not None
        self._rig = rig
        if self._job.seed % LATE_EVERY == LATE_EVERY - 1:
            cycle = rig.master.cycle
            cycle.first = LAST_CYCLE - self._draw.randint(*BEFORE)
            cycle.number = cycle.first - 1
        self._watch.attach(rig)
        wire = rig.master.wire
        emergencies = {wire.id(Emcy, n): n for n in (*JOINTS, GRIPPER)}

        def look(_time_ns: int, frame: Frame) -> None:
            node = emergencies.get(frame.id)
            if node is not None:
                told: Any = wire.codec(Emcy, node).unpack(frame.data)
                words = "" if told is None else in_words(wire, node, told)
                self._trips.append(f"{NODE_NAMES[node]}: {words}")

        rig.observe(look)

    def _count(self) -> None:
        """What nodes have counted in this run."""
        rig = self._rig
        if rig is None:
            return
        for node in (*rig.joints, rig.gripper):
            for fault, times in node.faults.items():
                if times:
                    self._trips.append(f"{node.name}: {fault.name} counted {times} times")
        if rig.master.statistics.incomplete:
            self._trips.append(f"{rig.master.statistics.incomplete} incomplete cycles")
        if rig.master.fault is not None:
            self._trips.append(rig.master.fault)
        self._rig = None


def run(job: Job) -> Result:
    """The result of a job."""
    return Trial(job).run()

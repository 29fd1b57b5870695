"""Twins of one simulated run: one gets an observation, the other does not, and what then differs.

The arm follows a reference transform, partly at rest, partly along straight lines. At random
moments within a cycle (seeded) the process forks: the child redefines the transform, the parent
does not. What both then send is compared frame by frame.
"""

import math
import os
import pickle
import random
import sys
from typing import Final, NamedTuple

from rfms_can.coordinator import Arm, Transform
from rfms_can.messages import TransformMessage
from rfms_can.rig.session import Session
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import JOINTS

CYCLES: Final = 5
"""Cycles compared after an observation: more than any may take."""
APART: Final = (5, 40)
"""Fewest and most cycles from one observation to the next."""
CORRECTION_M: Final = 0.02
"""What an observation moves the goal by."""
ACCELERATION: Final = 20.0
"""What a correction may add to the motion, m/s2; a mode that says nothing allows 1."""


class Seen(NamedTuple):
    """A frame: in which cycle after the observation, which, what, and when it ended, ns."""

    cycle: int
    id: int
    data: bytes
    time_ns: int


class Latency(NamedTuple):
    """What became of one observation.

    Attributes:
        phase: part of the cycle in progress that was over.
        closed: 1 if the set-point of the next cycle had been made already, else 0.
        moving: whether a move was under way.
        setpoint_cycles, dac_cycles: cycles from the last SYNC to that of the first SETPOINT and
            DAC that differ; less ``closed`` from the cycle in progress.
        setpoint_ms, dac_ms: time to the end of those frames.
    """

    phase: float
    closed: int
    moving: bool
    setpoint_cycles: int
    setpoint_ms: float
    dac_cycles: int
    dac_ms: float


class Bench:
    """An arm that follows a reference, and the frames it exchanges."""

    def __init__(self, seed: int, settings: RunSettings | None = None) -> None:
        wire = Wire()
        self.settings = settings or RunSettings()
        self.rig = SimulatedRig(self.settings, wire)
        self.session = Session(self.rig)
        self.session.bring_up()
        self._random = random.Random(seed)
        self._setpoint = {wire.codecs[f"SETPOINT_{pose}"].id for pose in (1, 2)}
        self._dacs = {wire.codecs[f"DAC_{joint}"].id for joint in JOINTS}
        self._frames: list[Seen] = []
        self._begun_ns = 0
        self.rig.observe(self._take)
        self._arm = Arm(self.session.link)
        self._follow()

    def _follow(self) -> None:
        """Positions that hang on a reference, and a mode to go to and fro between them."""
        arm = self._arm
        self._goal = arm.pose
        goal = arm.reference("goal", self._goal)
        aside = arm.transform("aside", Transform.translation(0.0, 0.04, -0.04))
        self._places = (
            arm.position("at", arm.t6 == goal),
            arm.position("aside", arm.t6 == goal @ aside),
        )
        self._mode = arm.mode(
            "straight",
            segment_time=0.4,
            acceleration_time=0.1,
            interpolation="cartesian",
            acceleration=ACCELERATION,
        )
        self._moves = 0
        arm.wait(arm.move(self._places[0], self._mode))

    def _take(self, time_ns: int, frame: Frame) -> None:
        cycle = (time_ns - self._begun_ns) // self.rig.master.settings.period_ns
        self._frames.append(Seen(cycle, frame.id, bytes(frame.data), time_ns))

    def sample(self) -> Latency:
        """Let the arm go on for a while, observe at a random moment, and compare the twins."""
        rig, master, chance = self.rig, self.rig.master, self._random
        if master.motion.at_rest and chance.random() < 0.5:
            self._moves += 1
            self._arm.move(self._places[self._moves % 2], self._mode)
        until = master.closed + chance.randint(*APART)
        self.session.link.pass_time(lambda: master.closed >= until)
        period_ns = master.settings.period_ns
        deadline_ns, closed = master.next_deadline_ns(), master.closed
        assert deadline_ns is not None
        self._begun_ns = deadline_ns
        phase = chance.random()
        observed_ns = deadline_ns + round(phase * period_ns)
        rig.bus.run_until(observed_ns)
        made = master.closed - closed
        moving = master.motion.following.moves
        child = self._twin(self._observation(), observed_ns + CYCLES * period_ns)
        own = self._go_on(observed_ns + CYCLES * period_ns)
        other = _read(child)
        setpoint, dac = (_first(own, other, ids) for ids in (self._setpoint, self._dacs))
        return Latency(
            phase,
            made,
            moving,
            setpoint.cycle,
            (setpoint.time_ns - observed_ns) * 1e-6,
            dac.cycle,
            (dac.time_ns - observed_ns) * 1e-6,
        )

    def _go_on(self, until_ns: int) -> list[Seen]:
        """The frames up to a time; the cycle the last SYNC began is 0."""
        self._frames.clear()
        self.rig.bus.run_until(until_ns)
        return list(self._frames)

    def _twin(self, observation: TransformMessage, until_ns: int) -> tuple[int, int]:
        """A child that observes and goes on: its process and the pipe its frames come from."""
        read, write = os.pipe()
        process = os.fork()
        if process:
            os.close(write)
            return process, read
        code = 1
        try:
            os.close(read)
            self.session.link.request(observation)
            with os.fdopen(write, "wb") as pipe:
                pickle.dump([tuple(seen) for seen in self._go_on(until_ns)], pipe)
            code = 0
        except BaseException as error:
            print(f"twin: {error!r}", file=sys.stderr, flush=True)
        finally:
            os._exit(code)

    def _observation(self) -> TransformMessage:
        turn = self._random.uniform(0.0, math.tau)
        x, y = CORRECTION_M * math.cos(turn), CORRECTION_M * math.sin(turn)
        moved = Transform.translation(x, y, 0.0) @ self._goal
        return TransformMessage("goal", moved, kind="reference")


def _read(child: tuple[int, int]) -> list[Seen]:
    """What a twin sent."""
    process, read = child
    with os.fdopen(read, "rb") as pipe:
        data = pipe.read()
    _, status = os.waitpid(process, 0)
    if status:
        raise RuntimeError(f"twin ended with {os.waitstatus_to_exitcode(status)}")
    return [Seen(*fields) for fields in pickle.loads(data)]  # our own child's


def _first(own: list[Seen], other: list[Seen], ids: set[int]) -> Seen:
    """The first frame of the twin, of some identifiers, that is not as the parent's."""
    same = {(seen.cycle, seen.id): seen.data for seen in own if seen.id in ids}
    for seen in other:
        if seen.id in ids and same.get((seen.cycle, seen.id)) != seen.data:
            return seen
    raise RuntimeError(f"no frame differs within {CYCLES} cycles of an observation")


def measure(samples: int, seed: int) -> list[Latency]:
    """So many observations."""
    bench = Bench(seed)
    return [bench.sample() for _ in range(samples)]

"""How the master runs the bus."""

import math
from dataclasses import dataclass, field
from typing import Final

from rfms_can.arm.calibration import Calibration
from rfms_can.compliance import ControlLaw
from rfms_can.dynamics.model import FULL
from rfms_can.master.traffic import BusTime
from rfms_can.master.trajectory.queue import MAX_QUEUE
from rfms_can.tables import complete
from rfms_can.wire.configuration import Clock
from rfms_can.wire.vocabulary import Blend


@dataclass(frozen=True, slots=True, kw_only=True)
class ClockDefinition:
    """What distinguishes a clock.

    Attributes:
        in_one_process: whether it is that of the simulated bus, with all nodes in one process.
        waits_for_nodes: whether a cycle lasts until all nodes have answered, up to the barrier.
        scheduled: whether cycles begin on an absolute schedule of the monotonic clock.
        waits_for_programs: whether time stands still while the program runs between two waits.
    """

    in_one_process: bool
    waits_for_nodes: bool
    scheduled: bool
    waits_for_programs: bool


CLOCKS: Final = complete(
    {
        Clock.VIRTUAL: ClockDefinition(
            in_one_process=True, waits_for_nodes=False, scheduled=False, waits_for_programs=True
        ),
        Clock.LOCKSTEP: ClockDefinition(
            in_one_process=False, waits_for_nodes=True, scheduled=False, waits_for_programs=True
        ),
        Clock.REALTIME: ClockDefinition(
            in_one_process=False, waits_for_nodes=False, scheduled=True, waits_for_programs=False
        ),
    },
    Clock,
)


PLAN_S: Final = 2.2e-3
"""A move planned again, with others before and behind it: 0.6 to 2.2 ms on one core of 2026."""

POSE_S: Final = 1e-5
"""A pose of a path, solved: 8 us on one core of 2026."""

REPLAN_PERIODS: Final = 2.5
"""Of real time, that a request may take: nodes bring the arm to rest when three SYNCs fail."""


@dataclass(frozen=True, slots=True)
class MasterSettings:
    """Settings of the master.

    Attributes:
        rate_hz: control cycles per second.
        clock: who says when a cycle begins.
        friction: friction set the servos compensate.
        dynamics: model the rows are made of; with ``none`` friction is not compensated either.
        calibration: what an experiment found, instead of the arm's published numbers.
        blend: matching polynomial of transitions.
        barrier_s: longest lockstep cycle, s.
        patience_s: how long nodes may take to appear and to answer a configuration, s.
        paced: lockstep cycles are not shorter than the period; for a bus that idles.
        law: how the arm complies.
        sensor: whether the plant has a wrist sensor.
        closed: whether the force loop is closed over it.
        dither: fraction of the friction, 0 to 1, that complying joints dither with at rest.
        following_error: largest error of a joint against what was commanded, rad; 0: by each
            joint's stiffness (``master/verification.py``).
        bus_time: how long a frame takes on the bus, ns; None where that is not known.
        listening_s: how long a master listens for another one before it sends anything, s.
    """

    rate_hz: float = 250.0
    clock: Clock = Clock.VIRTUAL
    friction: str = "corke"
    dynamics: str = FULL
    calibration: Calibration | None = None
    blend: Blend = Blend.CONTINUOUS
    barrier_s: float = 2.0
    patience_s: float = 30.0
    paced: bool = False
    law: ControlLaw = ControlLaw.WEIGHTED
    sensor: bool = False
    closed: bool = False
    dither: float = 0.0
    following_error: float = 0.0
    bus_time: BusTime | None = field(default=None, compare=False)
    listening_s: float = 0.0

    @property
    def clock_definition(self) -> ClockDefinition:
        """What distinguishes its clock."""
        return CLOCKS[self.clock]

    @property
    def replans(self) -> int:
        """Moves that a redefinition may plan again in one cycle, at most: ``Motion``."""
        if not self.clock_definition.scheduled:
            return MAX_QUEUE
        return max(1, int(REPLAN_PERIODS * self.period_ns * 1e-9 / PLAN_S))

    @property
    def effort(self) -> float:
        """Poses that may be solved for one request: ``Motion``."""
        if not self.clock_definition.scheduled:
            return math.inf
        return REPLAN_PERIODS * self.period_ns * 1e-9 / POSE_S

    @property
    def force_loop(self) -> str:
        """``none`` without a wrist sensor, ``open`` or ``closed`` over it."""
        return "closed" if self.closed else "open" if self.sensor else "none"

    @property
    def period_ns(self) -> int:
        """Control period, ns."""
        return round(1e9 / self.rate_hz)

    @property
    def cycle_limit_ns(self) -> int:
        """Longest time between two SYNCs, ns: the period, or the barrier in lockstep."""
        waits = self.clock_definition.waits_for_nodes
        return round(self.barrier_s * 1e9) if waits else self.period_ns

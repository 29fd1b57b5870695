"""All planners on a task: one row of figures each."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from statistics import median
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from planners import jerk_limited, paul, taylor, thesis, whitney
from planners.deviation import Off, deviation
from planners.planner import Method, NotPossibleError
from planners.run import Run
from planners.smoothness import continuity, peak
from planners.task import Task

BASELINE: Final = "thesis"

FINE_PERIODS: Final = (2e-3, 1e-3)
"""Periods the continuity is told from, s: small steps drown in the motion at longer ones, the
differences in rounding at shorter ones."""

PLANNERS: Final[Mapping[str, Method]] = MappingProxyType(
    {
        BASELINE: thesis.ThesisPlanner,
        "thesis-printed": thesis.as_printed,
        "whitney-open": whitney.open_loop,
        "whitney": whitney.closed_loop,
        "paul": paul.PaulPlanner,
        "taylor": taylor.TaylorPlanner,
        "ruckig": jerk_limited.RuckigPlanner,
    }
)
"""By name; ``BASELINE`` is what the costs of the others are compared with."""


@dataclass(frozen=True, slots=True)
class Figures:
    """What a planner made of a task.

    Attributes:
        duration_s: until the last goal is reached.
        line_mm, line_deg: from the straight lines of Cartesian legs, outside transitions.
        corner_mm: from them in transitions between them, and from and to rest.
        goal_mm: from the last goal, once reached.
        acceleration, jerk: largest difference quotients of a joint at the sample rate, rad/s2 and
            rad/s3. A derivative that steps grows with the rate: ``order`` tells.
        order: of continuity of the joints, a property of the method: from runs at ``FINE_PERIODS``,
            whatever the rate; 4 is that or more.
        prepared_ms: before the first cycle.
        cost_us, worst_us: median over the set-points, and the dearest one; each set-point's cost is
            the least of all repetitions, which leaves the machine's interruptions out.
        cost_ratio, worst_ratio: to those of ``BASELINE``, run in turn with it.
    """

    duration_s: float
    line_mm: float | None
    line_deg: float | None
    corner_mm: float | None
    goal_mm: float
    acceleration: float
    jerk: float
    order: int
    prepared_ms: float
    cost_us: float
    cost_ratio: float
    worst_us: float
    worst_ratio: float


@dataclass(frozen=True, slots=True)
class Row:
    """A planner on a task: its figures, or the reason why it cannot do it."""

    task: str
    planner: str
    figures: Figures | None
    not_possible: str | None = None

    def as_json(self) -> dict[str, Any]:
        """Plain values."""
        return asdict(self)


@dataclass(frozen=True, slots=True, eq=False)
class Costs:
    """Of each set-point, the least of all repetitions, us; and of what came before, ms."""

    each_us: list[float]
    prepared_ms: float

    @property
    def median_us(self) -> float:
        """Of the set-points."""
        return median(self.each_us)

    @property
    def worst_us(self) -> float:
        """Of the dearest set-point."""
        return max(self.each_us)


def compare(task: Task, names: Sequence[str], period_s: float, repeats: int) -> list[Row]:
    """A row for each planner of ``names``. The baseline is run in any case."""
    reasons: dict[str, str] = {}
    runs: dict[str, list[Run]] = {}
    for name in dict.fromkeys((BASELINE, *names)):
        try:
            runs[name] = [Run(PLANNERS[name], task, each) for each in (period_s, *FINE_PERIODS)]
        except NotPossibleError as error:
            reasons[name] = str(error)
    costs = _costs(task, list(runs), period_s, repeats)
    baseline = costs.get(BASELINE)
    return [
        Row(task.name, name, None, reasons[name])
        if name in reasons
        else Row(task.name, name, _figures(runs[name], costs[name], baseline))
        for name in names
    ]


def _costs(task: Task, names: Sequence[str], period_s: float, repeats: int) -> dict[str, Costs]:
    """Of planners that can do the task, run in turn."""
    timed: dict[str, list[Run]] = {name: [] for name in names}
    for _ in range(repeats):
        for name in names:
            timed[name].append(Run(PLANNERS[name], task, period_s))
    return {
        name: Costs(
            np.min([run.costs_us for run in runs], axis=0).tolist(),
            min(run.prepared_ms for run in runs),
        )
        for name, runs in timed.items()
    }


def _figures(runs: Sequence[Run], costs: Costs, baseline: Costs | None) -> Figures:
    whole, coarse, fine = runs
    off = deviation(whole)
    base = costs if baseline is None else baseline
    return Figures(
        duration_s=whole.arrival,
        line_mm=_mm(off.line),
        line_deg=None if off.line is None else float(np.degrees(off.line.angle)),
        corner_mm=_mm(off.corner),
        goal_mm=1e3 * off.goal.distance,
        acceleration=peak(whole, 2),
        jerk=peak(whole, 3),
        order=continuity(coarse, fine),
        prepared_ms=costs.prepared_ms,
        cost_us=costs.median_us,
        cost_ratio=costs.median_us / base.median_us,
        worst_us=costs.worst_us,
        worst_ratio=costs.worst_us / base.worst_us,
    )


def _mm(off: Off | None) -> float | None:
    return None if off is None else 1e3 * off.distance

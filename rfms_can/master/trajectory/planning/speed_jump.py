"""Why a goal that moves by itself cannot be followed: its speed jumps, as at the end of a table.

A spline through such a goal swings far beyond the joints' ranges, and the angle it reaches tells a
user nothing. Looked for only where a path bends sharply.
"""

from collections.abc import Callable
from typing import Final

import numpy as np

from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.trajectory.planning.base_path import Base, Frame
from rfms_can.master.trajectory.planning.curve import Floats
from rfms_can.transform import Transform

EDGE: Final = 10.0
"""A change of speed in one period that is this many times the usual one is a jump."""
FINER: Final = 16
"""Parts of a period in which it is looked at once more: a jump is one there too."""
LEAST_JUMP: Final = 1e-6
"""Of an element of the goal, in one period: what is less is rounding."""

Goals = Callable[[Floats], list[Transform]]
"""Where a goal is at local times, s."""


def speed_jump(base: Base, frame: Frame) -> str | None:
    """The jump of the goal of a segment on the way to it, or to rest there, in words.

    Args:
        base: of the segment.
        frame: of the plan.

    Returns:
        Place and size of the largest one; None if the goal's speed is continuous.
    """
    move, tau = base.segment.move, frame.period_s
    target, tick, end, rest = move.target, frame.tick, move.segment_ticks, move.rest_ticks
    if target.constant:
        return None

    def on_the_way(times: Floats) -> list[Transform]:
        moments = zip(base.parameter(times)[0].tolist(), times.tolist(), strict=True)
        return [target.pose(Moment(tick, h, t)) for h, t in moments]

    def at_rest(times: Floats) -> list[Transform]:
        return [target.pose(Moment(tick, 1.0, t)) for t in times.tolist()]

    way = tau * np.arange(-move.acceleration_ticks - 2.0, end + 1.0)
    stay = tau * np.arange(end - rest - 2.0, end + rest + 3.0)
    found = _largest(on_the_way, way) or _largest(at_rest, stay)
    if found is None:
        return None
    at, jump = found
    by = f" by {jump:.3g} m/s" if jump > LEAST_JUMP / tau else ""
    h = min(float(base.parameter(np.array([at]))[0, 0]), 1.0)
    return (
        f"the goal's speed jumps{by} near t = {at:.3f} s, h = {h:.3f}, and no "
        f"joint can follow: a table must be at rest where it begins and ends within a move; give "
        f"it interpolation 'cubic' and rows that lie further apart in u, or a function without "
        f"corners"
    )


def _largest(goals: Goals, times: Floats) -> tuple[float, float] | None:
    """When the largest jump of ``goals`` is at even ``times``, s, and its speed, m/s; or None."""
    poses = goals(times)
    changes = _changes(poses)
    k = int(changes.argmax())
    if changes[k] <= max(EDGE * float(np.median(changes)), LEAST_JUMP):
        return None
    finer = _changes(goals(np.linspace(times[k], times[k + 2], 2 * FINER + 1)))
    if FINER * finer.max() < 0.5 * changes[k]:
        return None  # it only bends sharply
    before, at, after = (np.array(poses[k + i])[3::4] for i in range(3))
    jump = float(np.linalg.norm(after - 2.0 * at + before)) / float(times[1] - times[0])
    return float(times[k + 1]), jump


def _changes(poses: list[Transform]) -> Floats:
    """Second differences: of each three poses the largest of an element."""
    return np.asarray(np.abs(np.diff(np.array(poses), n=2, axis=0)).max(axis=1))

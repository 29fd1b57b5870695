"""Why a goal that moves by itself cannot be followed: its speed jumps, as at the end of a table.

A spline through such a goal swings far beyond the joints' ranges, and the angle it reaches tells a
user nothing. Looked for only where a move is refused.
"""

from typing import Final

import numpy as np

from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.trajectory.planning.base_path import Base, Frame
from rfms_can.master.trajectory.planning.curve import Floats
from rfms_can.transform import Transform

EDGE: Final = 10.0
"""A change of speed in one period that is this many times the usual one is a jump."""
LEAST_JUMP: Final = 1e-6
"""Of an element of the goal, in one period: what is less is rounding."""


def speed_jump(base: Base, frame: Frame) -> str | None:
    """The jump of the goal of a segment on the way to it and to rest there, in words.

    Args:
        base: of the segment.
        frame: of the plan.

    Returns:
        Place and size of the largest one; None if the goal's speed is continuous.
    """
    target, tau = base.segment.move.target, frame.period_s
    if target.constant:
        return None
    first = -base.segment.move.acceleration_ticks - 2
    last = base.segment.move.segment_ticks + base.segment.move.rest_ticks + 2
    times: Floats = np.arange(first, last + 1, dtype=np.float64) * tau
    h = np.clip(base.parameter(times)[0], 0.0, 1.0)
    poses: list[Transform] = [
        target.pose(Moment(frame.tick, float(h_), float(t))) for h_, t in zip(h, times, strict=True)
    ]
    changes = np.abs(np.diff(np.array(poses), n=2, axis=0)).max(axis=1)
    k = int(changes.argmax())
    if changes[k] <= max(EDGE * float(np.median(changes)), LEAST_JUMP):
        return None
    before, at, after = (np.array(poses[k + i])[3::4] for i in range(3))
    jump = float(np.linalg.norm(after - 2.0 * at + before)) / tau
    by = f" by {jump:.3g} m/s" if jump > LEAST_JUMP / tau else ""
    return (
        f"the goal's speed jumps{by} near t = {times[k + 1]:.3f} s, h = {h[k + 1]:.3f}, and no "
        f"joint can follow: a table must be at rest where it begins and ends within a move; give "
        f"it interpolation 'cubic' and rows that lie further apart in u, or a function without "
        f"corners"
    )

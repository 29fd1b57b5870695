"""Constant speed: the middle of each sweep, divided into short windows and averaged."""

from collections.abc import Iterable
from typing import Final, NamedTuple

import numpy as np

from rfms_can.analysis.cycles import Floats
from rfms_can.identification.experiments.actions import SWEEP
from rfms_can.identification.fit.trace import Trace

LENGTH: Final = 10
"""Samples in a window."""
SETTLING_S: Final = 0.35
"""Excluded at either end of a sweep, s: acceleration and settling of the servo."""
STEADY: Final = 0.1
"""Largest relative deviation of a window's speed from the sweep's."""


class Window(NamedTuple):
    """The mean of a few samples at constant speed.

    Attributes:
        joint: that moves, index 0 to 5.
        pose: number of the experiment's action: windows of one share the other joints' angles.
        q: rad (6).
        speed: of the joint, rad/s.
        acceleration: remaining, rad/s2.
        current: of the joint, DAC codes.
        load: whether the known load was in the hand.
    """

    joint: int
    pose: int
    q: Floats
    speed: float
    acceleration: float
    current: float
    load: bool


def windows_of(trace: Trace) -> Iterable[Window]:
    """The windows of all sweeps."""
    settling = round(SETTLING_S / trace.period_s)
    for mark in trace.marks:
        if mark.kind != SWEEP:
            continue
        i = mark.joint - 1
        first, last = mark.start + settling, mark.stop - settling - LENGTH
        mean = (trace.q[last, i] - trace.q[first, i]) / ((last - first) * trace.period_s)
        for start in range(first, last, LENGTH):
            rows = slice(start, start + LENGTH)
            seconds = LENGTH * trace.period_s
            speed = (trace.q[start + LENGTH, i] - trace.q[start, i]) / seconds
            if abs(speed - mean) > STEADY * abs(mean):
                continue
            # The current of row k belongs to the period before it: half a sample earlier.
            q = 0.5 * (trace.q[rows].mean(axis=0) + trace.q[start + 1 : rows.stop + 1].mean(axis=0))
            current = float(trace.current[start + 1 : rows.stop + 1, i].mean())
            change = trace.qd[start + LENGTH, i] - trace.qd[start, i]
            yield Window(i, mark.action, q, speed, change / seconds, current, trace.load)


def directions(windows: Iterable[Window]) -> Floats:
    """+1 or -1 for each window."""
    return np.sign([window.speed for window in windows])

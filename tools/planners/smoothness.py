"""How smooth a sampled motion is: peaks of its derivatives, and how many are continuous."""

from typing import Final

import numpy as np

from planners.run import Floats, Run

HIGHEST: Final = 4
"""Highest order of continuity that is looked for."""

STEPS: Final = 0.7
"""A step of a derivative halves with the period if the derivative is continuous, and stays what it
is if it is not; between the two lies 1/sqrt 2."""


def differences(run: Run, order: int) -> Floats:
    """Difference quotients of the joint angles, rad/s^order, (N, 6); rest came before the first."""
    rest = np.repeat(np.array([run.task.start]), order, axis=0)
    quotients: Floats = np.diff(np.vstack([rest, run.q]), n=order, axis=0) / run.period_s**order
    return quotients


def peak(run: Run, order: int) -> float:
    """Largest difference quotient of ``order`` of any joint: 2 acceleration, 3 jerk."""
    return float(np.max(np.abs(differences(run, order))))


def step(run: Run, order: int) -> float:
    """Largest change of the derivative of ``order`` from one sample to the next, rad/s^order."""
    return peak(run, order + 1) * run.period_s


def continuity(coarse: Run, fine: Run) -> int:
    """The highest order up to which all derivatives are continuous; -1 if positions step.

    ``fine`` is the same motion at half the period of ``coarse``. ``HIGHEST`` means that or more.
    """
    for order in range(HIGHEST + 1):
        if step(fine, order) > STEPS * step(coarse, order):
            return order - 1
    return HIGHEST

"""Poles of the continuous loop: eigenvalues of A' (5.22), and when they are stable."""

from enum import StrEnum
from typing import Final

import numpy as np
import numpy.typing as npt

from rfms_can.analysis.stability.loop import Loop

Matrix = npt.NDArray[np.float64]
Poles = npt.NDArray[np.complex128]

ROUNDING: Final = 1e-6
"""Part of the largest pole's size up to which a real part counts as zero."""


class Verdict(StrEnum):
    """What becomes of a small disturbance."""

    STABLE = "stable"
    """It dies out; in compliant directions a displacement stays."""
    DRIFTS = "drifts"
    """Nothing brakes the compliant directions: two poles at 0 for each, so a push goes on."""
    UNSTABLE = "unstable"
    """It grows."""


def state_matrix(loop: Loop) -> Matrix:
    """A' of (5.22), (12, 12): [0, I; -M^-1 K, -M^-1 (B + F)]."""
    stiffness = np.linalg.solve(loop.inertia, loop.stiffness)
    damping = np.linalg.solve(loop.inertia, loop.damping + loop.friction)
    return np.block([[np.zeros((6, 6)), np.eye(6)], [-stiffness, -damping]])


def poles(loop: Loop) -> Poles:
    """The twelve eigenvalues of A', 1/s, by real part; those of motions without stiffness exact."""
    reach, positions, rates, back = loop.reduced()
    n, m = reach.shape
    stiffness = np.linalg.solve(loop.inertia, loop.stiffness @ positions)
    damping = np.linalg.solve(loop.inertia, (loop.damping + loop.friction) @ rates)
    reduced = np.block([[np.zeros((n, n)), reach], [-back @ stiffness, -back @ damping]])
    found = np.concatenate([np.linalg.eigvals(reduced), np.zeros(12 - n - m)])
    return found[np.lexsort((found.imag, found.real))].astype(np.complex128)


def growth(values: Poles) -> float:
    """Largest real part, 1/s; 0 within rounding."""
    largest = float(values.real.max())
    return 0.0 if abs(largest) <= ROUNDING * float(np.abs(values).max(initial=1.0)) else largest


def verdict(loop: Loop, values: Poles | None = None) -> Verdict:
    """What the poles say; ``values`` if they are known already."""
    if growth(poles(loop) if values is None else values) > 0.0:
        return Verdict.UNSTABLE
    return Verdict.DRIFTS if loop.drifts else Verdict.STABLE

"""The loop as the bus runs it: sampled, held, one period late.

Angles and rates of SYNC k go out as MEASURE, come back as DAC codes, and those act from SYNC k+1
to SYNC k+2 (docs/architecture.md). So

    u_{k+1} = -K theta_k - B theta_dot_k,    M theta_ddot + F theta_dot = u_k between SYNCs,

with eighteen states: angles, rates, and the torque that is being applied. The discretisation of
the plant is exact. The rows are constant here: that they are one period old matters for a moving
arm, not for small disturbances of one at rest.
"""

from math import ceil, log2
from typing import Final

import numpy as np
import numpy.typing as npt

from rfms_can.analysis.stability.continuous import Poles
from rfms_can.analysis.stability.loop import Loop

Matrix = npt.NDArray[np.float64]

ROUNDING: Final = 1e-7
"""How far outside the unit circle a pole may come out of the solver and count as on it."""

_TERMS: Final = 18
_BISECTIONS: Final = 40
_SCAN: Final = 1.05
_LARGEST: Final = 1e3


def matrix_exponential(A: Matrix) -> Matrix:
    """exp(A): Taylor's series of A / 2^s, squared s times; to rounding for norms up to hundreds."""
    norm = float(np.linalg.norm(A, 1))
    squarings = max(0, ceil(log2(norm)) + 1) if norm > 0.0 else 0
    scaled = A / 2.0**squarings
    total = term = np.eye(len(A))
    for k in range(1, _TERMS + 1):
        term = term @ scaled / k
        total = total + term
    for _ in range(squarings):
        total = total @ total
    return total


def sampled_matrix(loop: Loop, period_s: float) -> Matrix:
    """The step from SYNC to SYNC, (18, 18): angles, rates, applied torque."""
    return _step(loop, period_s, np.eye(6), np.eye(6), np.eye(6), np.eye(6))


def sampled_poles(loop: Loop, period_s: float) -> Poles:
    """Eigenvalues of the step from SYNC to SYNC, eighteen, by size; stable inside the unit circle.

    Each compliant direction has one at 1, and another where nothing brakes it.
    """
    reach, positions, rates, back = loop.reduced()
    step = _step(loop, period_s, reach, positions, rates, back)
    found = np.concatenate([np.linalg.eigvals(step), np.ones(18 - len(step))])
    return found[np.argsort(np.abs(found))].astype(np.complex128)


def is_stable(values: Poles) -> bool:
    """Whether all are in or, at 1, on the unit circle."""
    return float(np.abs(values).max()) <= 1.0 + ROUNDING


def gain_margin(loop: Loop, period_s: float) -> float:
    """How many times its natural frequency the servo may have before the sampled loop is unstable.

    The first factor at which it becomes so, K by its square and B by it; 0 if it is unstable for
    small factors already, infinite if nothing below a thousand makes it so.
    """
    low = 1.0 / _LARGEST
    if not is_stable(sampled_poles(loop.scaled(low), period_s)):
        return 0.0
    high = low
    while is_stable(sampled_poles(loop.scaled(high), period_s)):
        low, high = high, high * _SCAN
        if high > _LARGEST:
            return np.inf
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        if is_stable(sampled_poles(loop.scaled(middle), period_s)):
            low = middle
        else:
            high = middle
    return low


def largest_frequency(period_s: float, damping_ratio: float = 1.0) -> float:
    """The largest natural frequency, rad/s, of a joint alone: where z = 1 is left by its poles.

    z (z - 1)^2 + h^2 / 2 (z + 1) + 2 zeta h (z - 1), h = wn T, has its roots in the unit circle
    up to this h. With the inertia-weighted law this is the bound of the whole arm.
    """
    low, high = 0.0, 4.0
    for _ in range(_BISECTIONS):
        h = 0.5 * (low + high)
        b, a = 2.0 * damping_ratio * h, 0.5 * h * h
        roots = np.roots([1.0, -2.0, 1.0 + a + b, a - b])
        low, high = (h, high) if np.abs(roots).max() < 1.0 else (low, h)
    return low / period_s


def _step(
    loop: Loop, period_s: float, reach: Matrix, positions: Matrix, rates: Matrix, back: Matrix
) -> Matrix:
    """One period of a reduced loop: positions (n), rates (m), torque (6)."""
    n, m = reach.shape
    inverse = np.linalg.inv(loop.inertia)
    plant = np.zeros((n + m + 6, n + m + 6))
    plant[:n, n : n + m] = reach
    plant[n : n + m, n : n + m] = -back @ inverse @ loop.friction @ rates
    plant[n : n + m, n + m :] = back @ inverse
    step = matrix_exponential(plant * period_s)
    step[n + m :] = np.hstack(
        [-loop.stiffness @ positions, -loop.damping @ rates, np.zeros((6, 6))]
    )
    return step

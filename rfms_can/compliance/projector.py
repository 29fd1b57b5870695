"""A projector in joint space that stays bounded where its two subspaces coincide.

C_theta = J^-1 (I-S) J (5.10b) splits the joint error in two. Its range V are the joint motions
that do not move the compliant directions, the null space of the rows A_c = S J. Its null space W
are the errors in compliant directions only, the null space of A_p = (I-S) J. Where the arm is
singular, a compliant and a rigid direction can no longer be moved independently: a row of A_c and
one of A_p become parallel, V and W share a motion, and C grows without limit.

With the inertia matrix M as metric and principal vectors v_i of V, c_i of its orthogonal
complement,

    C = sum v_i v_i^T + sum k_i v_i c_i^T,    k_i = cot(angle between V and W).

The first sum is the orthogonal projector on V; the second couples errors in compliant directions
into V. C^2 = C for *any* k_i, since v_i^T c_j = 0: the couplings may be damped one by one, and the
result is a projector of the same rank and range. Up to ``limit`` they are unchanged. Beyond, they
fall again, y / (1 - y^2 + y^4) of the limit with y = limit / k_i (the variable damping of damped
least squares, smooth at the limit), and vanish at the singularity, where k_i changes its sign
through infinity: so C is continuous along a path through it, and its norm in the metric is at most
sqrt(1 + (1.07 limit)^2). Its rate of change depends on the path: the direction that the arm loses
may be almost compliant (within an angle of epsilon, radians), and then V turns while the sine of
the margin goes from -epsilon to epsilon.

V is kept, so compliance has priority: no correction acts in a compliant direction. The conflicting
rigid direction is given up. At the singularity the free motion is M^-1 A_c^T f, that of a force f
in the compliant directions.
"""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

Matrix = npt.NDArray[np.float64]

COUPLING_LIMIT: Final = 8.0
"""Largest undamped cotangent in the inertia metric: about three degrees of theta5 from the wrist
singularity of either PUMA. Away from singularities couplings stay below 4."""

OVERSHOOT: Final = 1.0665
"""Largest damped coupling over the limit: max of y / (1 - y^2 + y^4)."""


class Projection(NamedTuple):
    """A bounded projector and its couplings.

    Attributes:
        matrix: (6, 6).
        couplings: cotangents of the angles between range and null space, smallest first; empty
            if only known to be within the limit.
        blocked, measured: (n, 6) each, one row for each coupling beyond the limit: the coinciding
            directions of the range's complement and of the measured rows, over joint angles.
    """

    matrix: Matrix
    couplings: tuple[float, ...]
    blocked: Matrix
    measured: Matrix


def bounded_projector(
    blocked: Matrix, measured: Matrix, inertia: Matrix, limit: float = COUPLING_LIMIT
) -> Projection:
    """The projector with range null(blocked) and, within the limit, null space null(measured).

    Args:
        blocked: (k, 6) of rank k: rows of the directions that corrections must not move.
        measured: (6 - k, 6) of rank 6 - k: rows of the errors to be corrected.
        inertia: (6, 6), symmetric and positive definite: the metric.
        limit: largest undamped coupling.
    """
    k = len(blocked)
    none = np.zeros((0, 6))
    if k in (0, 6):
        return Projection(np.eye(6) if k == 0 else np.zeros((6, 6)), (), none, none)
    root = np.linalg.cholesky(inertia)  # M = L L^T; x' = L^T x has the unit metric
    complete = np.linalg.qr(np.linalg.solve(root, blocked.T), mode="complete")[0]
    complement, basis = complete[:, :k], complete[:, k:]
    rows = np.linalg.qr(np.linalg.solve(root, measured.T))[0]
    left, sines, right = np.linalg.svd(rows.T @ basis)
    moved = basis @ right.T  # (6, 6 - k), v_i
    across = complement @ (complement.T @ (rows @ left))  # (6, 6 - k), cos_i c_i
    cosines = np.linalg.norm(across, axis=0)
    couplings = cosines / np.maximum(sines, np.finfo(float).tiny)
    kept = [
        1.0 / s if c <= limit else damped(c, limit) / cosine
        for c, s, cosine in zip(couplings, sines, cosines, strict=True)
    ]
    unit = basis @ basis.T + (moved * kept) @ across.T
    matrix = np.linalg.solve(root.T, unit @ root.T)
    conflict = couplings > limit
    return Projection(
        matrix,
        tuple(float(c) for c in couplings),
        (root @ across[:, conflict]).T,
        (root @ (rows @ left)[:, conflict]).T,
    )


def tame_projector(
    J: Matrix, compliant: npt.NDArray[np.bool_], inertia: Matrix, limit: float = COUPLING_LIMIT
) -> Projection | None:
    """J^-1 (I-S) J itself if no coupling can exceed the limit: a fifth of the computation.

    The squares of its elements in the metric sum up to 6 - n + sum k_i^2.

    Args:
        J: (6, 6), Jacobian of the compliance frame.
        compliant: (6,), the diagonal of S.
        inertia, limit: as for ``bounded_projector``.

    Returns:
        None if a coupling may exceed the limit, or J cannot be inverted.
    """
    none = np.zeros((0, 6))
    if not compliant.any():
        return Projection(np.eye(6), (), none, none)  # exact, also near a singularity
    try:
        solved = np.linalg.solve(J, np.where(compliant[:, np.newaxis], 0.0, J))
    except np.linalg.LinAlgError:
        return None
    matrix: Matrix = np.asarray(solved, dtype=np.float64)
    root = np.linalg.cholesky(inertia)
    unit = np.linalg.solve(root, (root.T @ matrix).T)
    excess = float((unit * unit).sum()) - float(6 - compliant.sum())
    return Projection(matrix, (), none, none) if excess <= limit * limit else None


def damped(coupling: float, limit: float) -> float:
    """The damped coupling: unchanged up to the limit, falling to zero beyond."""
    if coupling <= limit:
        return coupling
    y2 = (limit / coupling) ** 2
    return limit * float(np.sqrt(y2)) / (1.0 - y2 + y2 * y2)


def metric_norm(matrix: Matrix, inertia: Matrix) -> float:
    """Norm of a matrix over joint angles in the metric sqrt(x^T M x)."""
    root = np.linalg.cholesky(inertia)
    return float(np.linalg.norm(root.T @ matrix @ np.linalg.inv(root.T), 2))


def largest_norm(limit: float = COUPLING_LIMIT) -> float:
    """Bound of ``metric_norm`` of every ``bounded_projector``."""
    return float(np.hypot(1.0, OVERSHOOT * limit))


def largest_element(inertia: Matrix, limit: float = COUPLING_LIMIT) -> float:
    """Bound of the elements of a ``bounded_projector``: the norm's, between scaled joints."""
    inverse = np.linalg.inv(inertia)
    scale: Sequence[float] = np.sqrt(np.outer(np.diag(inverse), np.diag(inertia))).ravel()
    return largest_norm(limit) * float(max(scale))

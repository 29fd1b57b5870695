"""Control laws as rows: what each joint node gets of them, two rows of six for each joint.

The servo multiplies its row of ``errors`` with the six joint errors and with their rates, and what
comes out with its own K_p and K_d. In the inertia-weighted law, tau = M C (wn^2 e + 2 zeta wn
e_dot), it multiplies its row of ``weighted`` with them, and needs no gains of its own. All laws
travel in the same frames and differ in these numbers alone.

===============  =====================================================  ==========================
law              errors                                                 weighted
===============  =====================================================  ==========================
position         I                                                      M
hybrid           C = J^-1 (I-S) J (5.10b), bounded                      M C
stiffness        K_p^-1 J^T K J (Salisbury, 5.6)                        M
free joint       I in the rows of joints that keep their position,      M times that
                 with the compensation of the free ones; 0 in theirs
===============  =====================================================  ==========================

Raibert and Craig's hybrid control differs from ours in where the error is computed, not in the
rows: ``cartesian.py``. What else distinguishes the laws stands in ``law_table.py``.
"""

from collections.abc import Sequence
from enum import StrEnum
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rfms_can.compliance.projector import (
    COUPLING_LIMIT,
    Projection,
    bounded_projector,
    tame_projector,
)
from rfms_can.compliance.selection import Selection

Matrix = npt.NDArray[np.float64]

_NO_ROWS = np.zeros((0, 6))


class ControlLaw(StrEnum):
    """How an arm complies: a law, with the torque the nodes make of its rows."""

    POSITION = "position"
    """PID, every joint its own error: nothing complies."""
    STIFFNESS = "stiffness"
    """Salisbury: J^T K J e (5.6), its damping in proportion."""
    FREE_JOINT = "free-joint"
    """Paul and Shimano: PID; joints matched to the compliant directions are free."""
    RAIBERT_CRAIG = "raibert-craig"
    """Hybrid control with the error computed between poses (5.7, 5.8)."""
    HYBRID = "hybrid"
    """The thesis' modified hybrid control: PID on C e (5.10)."""
    WEIGHTED = "weighted"
    """The same, weighted by the inertia matrix: M (wn^2 C e + 2 zeta wn C e_dot)."""


class LawRows(NamedTuple):
    """What the six nodes get.

    Attributes:
        errors: (6, 6); row n is multiplied with the joint errors and their rates.
        weighted: (6, 6), kg m2; row n is multiplied with the desired accelerations.
        projection: how a bounded projector came about; None where the law has none.
    """

    errors: Matrix
    weighted: Matrix
    projection: Projection | None = None


def position_rows(M: Matrix) -> LawRows:
    """Pure position control: every joint its own error.

    Args:
        M: (6, 6), joint-space inertia, kg m2.
    """
    return LawRows(np.eye(6), M)


def hybrid_rows(
    J: Matrix, selection: Selection, M: Matrix, limit: float = COUPLING_LIMIT
) -> LawRows:
    """Modified hybrid control: C_theta = J^-1 (I-S) J (5.10b), bounded near singularities.

    Where no coupling is beyond ``limit`` it is the matrix of (5.10b) to rounding.

    Args:
        J: (6, 6), Jacobian of the compliance frame, at a pose of ``regular_pose``.
        selection: what complies.
        M: (6, 6), joint-space inertia, kg m2.
        limit: see ``bounded_projector``.
    """
    mask = selection.mask
    projection = tame_projector(J, mask, M, limit)
    if projection is None:
        projection = bounded_projector(J[mask], J[~mask], M, limit)
    return LawRows(projection.matrix, M @ projection.matrix, projection)


def stiffness_rows(
    J: Matrix, stiffness: Sequence[float], M: Matrix, Kp: Sequence[float]
) -> LawRows:
    """Salisbury's stiffness control, K_theta = J^T K J (5.6), on servos with gains K_p and K_d.

    Row n is divided by the node's K_p, so that its torque is K_theta dtheta. The damping a node
    makes of the same row is K_d K_p^-1 K_theta: with K_d / K_p = 2 zeta / wn in every node it is
    2 zeta / wn times the stiffness, and a motion of natural frequency W is damped zeta W / wn:
    soft directions little, not at all where the stiffness is zero. Near a singularity K_theta
    loses rank, and the arm its hold (5.6 ff.): that is the method, and nothing is added to it.

    Args:
        J: (6, 6), Jacobian of the compliance frame.
        stiffness: along and about its axes, N/m and N m/rad.
        M: (6, 6), joint-space inertia, kg m2.
        Kp: gains of the six nodes, N m/rad.
    """
    joint_stiffness = J.T @ (np.asarray(stiffness)[:, np.newaxis] * J)
    return LawRows(joint_stiffness / np.asarray(Kp)[:, np.newaxis], M)


def matched_stiffness(
    J: Matrix, selection: Selection, M: Matrix, natural_frequency: float
) -> tuple[float, ...]:
    """Cartesian stiffnesses that make a stiffness law comparable with the others.

    Rigid directions get the stiffness at which a mass that may move along this direction alone,
    1 / (J M^-1 J^T)_ii, has the natural frequency of the other laws (rad/s); compliant ones 0.
    Choose them at one pose and keep them.

    Args:
        J: (6, 6), Jacobian of the compliance frame.
        selection: what complies.
        M: (6, 6), joint-space inertia, kg m2.
        natural_frequency: rad/s.

    Returns:
        Six of N/m, N m/rad.
    """
    mobility = np.diag(J @ np.linalg.solve(M, J.T))
    rigid = ~selection.mask
    values = np.where(rigid, natural_frequency**2 / mobility, 0.0)
    return tuple(float(value) for value in values)


def free_joint_rows(
    J: Matrix,
    selection: Selection,
    joints: Sequence[int],
    M: Matrix,
    limit: float = COUPLING_LIMIT,
) -> LawRows:
    """Paul and Shimano's method: some joints free, the others hold the rigid directions.

    An error e_f of the free joints shows in the rigid directions as A_f e_f, A = (I-S) J. The
    others take it over: their real error is e_p + A_p^-1 A_f e_f. That again is a projector. Its
    null space is that of C_theta: the same errors are ignored. Its range is what the position
    servoed joints can do: so their corrections push in compliant directions as well, unless the
    match is perfect. It is bounded in the same way.

    Args:
        J: (6, 6), Jacobian of the compliance frame, at a pose of ``regular_pose``.
        selection: what complies.
        joints: indices (0 to 5) of the free joints, as many as directions comply
            (``match_joints``).
        M: (6, 6), joint-space inertia, kg m2.
        limit: see ``bounded_projector``.
    """
    free = np.eye(6)[list(joints)] if joints else _NO_ROWS
    projection = bounded_projector(free, J[~selection.mask], M, limit)
    errors = projection.matrix.copy()
    errors[list(joints)] = 0.0  # exactly, not to rounding: a free joint hears nothing
    return LawRows(errors, M @ errors, projection)


def free_damping(rows: LawRows, M: Matrix) -> Matrix:
    """M (I - C): rows that damp the compliant directions, kg m2, to be multiplied by 1/s.

    The bare law leaves each compliant direction two poles at 0, which any push sets adrift
    without end. Torque -mu M (I-C) theta_dot moves one of the two to -mu and touches no other.

    Args:
        rows: of a law whose ``errors`` are a projector.
        M: (6, 6), joint-space inertia, kg m2.
    """
    damping: Matrix = M - M @ rows.errors
    return damping

"""The characteristic polynomial of A' in the forms of (5.22) to (5.35), as corrected.

For tests and for the special case: the closed forms show *why* a spherical wrist with similar
joints is stable, the eigenvalues only that it is. All take the thesis' model: D = diag(d_ii),
K_p and K_d diagonal.
"""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from rfms_can.compliance import Selection

Matrix = npt.NDArray[np.float64]
Gains = Sequence[float]


def joint_characteristic(s: complex, D: Gains, Kp: Gains, Kd: Gains) -> npt.NDArray[np.complex128]:
    """q_i(s) = s^2 d_ii + s k_di + k_pi (5.25), (6,)."""
    values = s * s * np.asarray(D) + s * np.asarray(Kd) + np.asarray(Kp)
    return np.asarray(values, dtype=np.complex128)


def delta_by_state(s: complex, A: Matrix) -> complex:
    """|A' - s I| (5.22), (12, 12)."""
    return complex(np.linalg.det(A - s * np.eye(len(A))))


def delta_by_joints(
    s: complex, J: Matrix, selection: Selection, D: Gains, Kp: Gains, Kd: Gains
) -> complex:
    """|s D^-1 K_d C + s^2 I + D^-1 K_p C| (5.23), C = J^-1 (I-S) J."""
    C = np.linalg.solve(J, (~selection.mask)[:, np.newaxis] * J)
    both = (s * np.asarray(Kd) + np.asarray(Kp)) / np.asarray(D)
    return complex(np.linalg.det(both[:, np.newaxis] * C + s * s * np.eye(6)))


def delta_by_columns(
    s: complex, J: Matrix, selection: Selection, D: Gains, Kp: Gains, Kd: Gains
) -> complex:
    """|Q(s) J^-1 (I-S) + s^2 D J^-1 S| (5.24): |D| |J^-1| times the others, with the same roots."""
    inverse = np.linalg.inv(J)
    q = joint_characteristic(s, D, Kp, Kd)[:, np.newaxis]
    columns = np.where(selection.mask, s * s * np.asarray(D)[:, np.newaxis] * inverse, q * inverse)
    return complex(np.linalg.det(columns))


def delta_by_blocks(
    s: complex, J: Matrix, selection: Selection, D: Gains, Kp: Gains, Kd: Gains
) -> complex:
    """The product of an arm's and a wrist's determinant (5.30): needs J_12 = 0, so no tool."""
    product = 1.0 + 0.0j
    q = joint_characteristic(s, D, Kp, Kd)
    for part in (slice(0, 3), slice(3, 6)):
        inverse = np.linalg.inv(J[part, part])
        d = np.asarray(D)[part, np.newaxis]
        columns = np.where(selection.mask[part], s * s * d * inverse, q[part, np.newaxis] * inverse)
        product *= complex(np.linalg.det(columns))
    return product


def delta_closed(
    s: complex, J: Matrix, selection: Selection, D: Gains, Kp: Gains, Kd: Gains
) -> complex:
    """|J^-1| q_1^(3-n) q_4^(3-m) s^2(m+n) d_11^n d_44^m (5.35).

    For similar joints (5.31): the gains of joints 1 and 4 stand for the arm's and the wrist's.
    """
    n, m = sum(selection[:3]), sum(selection[3:])
    q = joint_characteristic(s, D, Kp, Kd)
    free = s ** (2 * (m + n)) * D[0] ** n * D[3] ** m
    return complex(q[0] ** (3 - n) * q[3] ** (3 - m) * free / np.linalg.det(J))

"""The linear loop of an arm under a law: inertia, stiffness, damping (Eq. 5.12 to 5.22).

    M theta_ddot + (B + F) theta_dot + K theta = K theta_d + B theta_d_dot

The thesis has D = diag(d_ii) for M, K = K_p C and B = K_d C; A' of (5.22) is ``state_matrix``.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Matrix = npt.NDArray[np.float64]

_NOTHING = 1e-9
"""Part of a matrix that counts as rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class Loop:
    """One linear loop; all (6, 6), SI.

    Attributes:
        inertia: of the plant.
        stiffness, damping: what the nodes make of errors and of their rates.
        friction: viscous friction of the plant.
        free: dimension of the null space of ``stiffness``: how many directions comply.
    """

    inertia: Matrix
    stiffness: Matrix
    damping: Matrix
    friction: Matrix
    free: int

    @property
    def bases(self) -> tuple[Matrix, Matrix]:
        """Bases: (6, 6 - free) of held motions, (6, free) of those without stiffness."""
        _, _, right = np.linalg.svd(self.stiffness)
        held = 6 - self.free
        return right[:held].T, right[held:].T

    @property
    def drifts(self) -> bool:
        """Whether a motion has neither stiffness nor damping: two poles at 0 in one block."""
        return self.free > 0 and not _acts(self.damping + self.friction, self.bases[1])

    def scaled(self, factor: float) -> "Loop":
        """The servo with ``factor`` times its natural frequencies: K by its square, B by it."""
        return Loop(
            self.inertia,
            factor**2 * self.stiffness,
            factor * self.damping,
            self.friction,
            self.free,
        )

    def reduced(self) -> tuple[Matrix, Matrix, Matrix, Matrix]:
        """The loop without motions nothing acts on: what their poles at 0 would blur.

        A block of two poles at 0 comes out of an eigenvalue solver as a pair 1e-8 apart; both are
        known beforehand. So positions without stiffness are left out of the state, and their
        rates too where they have no damping.

        Returns:
            P, (n, m): rates of the positions kept, from the rates kept; Z, (6, n): joint angles of
            the positions kept; R, (6, m): joint rates of the rates kept; and R^T, (m, 6).
        """
        held, _ = self.bases
        rates = held if self.drifts else np.eye(6)
        return held.T @ rates, held, rates, rates.T


def _acts(matrix: Matrix, basis: Matrix) -> bool:
    size = float(np.linalg.norm(matrix))
    return size > 0.0 and float(np.linalg.norm(matrix @ basis)) > _NOTHING * size


def pid_loop(
    inertia: Matrix,
    C: Matrix,
    Kp: Sequence[float],
    Kd: Sequence[float],
    free: int,
    *,
    compliant_damping: Sequence[float] = (0.0,) * 6,
    friction: Sequence[float] = (0.0,) * 6,
) -> Loop:
    """tau = K_p C e + K_d C e_dot (5.11, 5.15, 5.22), and damping of the compliant directions.

    Args:
        inertia: (6, 6), of the plant; ``np.diag`` of d_ii for the thesis' model.
        C: (6, 6), rows of any law (``compliance.laws``).
        Kp, Kd: gains of the six nodes, N m/rad and N m s/rad.
        free: how many directions comply.
        compliant_damping: K_dc of the six nodes, N m s/rad: -K_dc (I - C) theta_dot.
        friction: viscous, N m s/rad.
    """
    return Loop(
        inertia,
        np.diag(Kp) @ C,
        np.diag(Kd) @ C + np.diag(compliant_damping) @ (np.eye(6) - C),
        np.diag(friction),
        free,
    )


def weighted_loop(
    inertia: Matrix,
    model: Matrix,
    C: Matrix,
    natural_frequency: float,
    damping_ratio: float,
    free: int,
    *,
    compliant_rate: float = 0.0,
    friction: Sequence[float] = (0.0,) * 6,
) -> Loop:
    """tau = M (wn^2 C e + 2 zeta wn C e_dot - mu (I - C) theta_dot).

    With the plant's own M and no friction, C being a projector, the poles are the roots of
    (s^2 + 2 zeta wn s + wn^2)^(6-n) (s (s + mu))^n, whatever Jacobian, tool and pose.

    Args:
        inertia: (6, 6), of the plant.
        model: (6, 6), M of the rows.
        C: (6, 6), a projector.
        natural_frequency, damping_ratio: wn, rad/s, and zeta.
        free: n, how many directions comply.
        compliant_rate: mu, 1/s.
        friction: viscous, N m s/rad.
    """
    compliant = compliant_rate * (np.eye(6) - C)
    return Loop(
        inertia,
        natural_frequency**2 * model @ C,
        model @ (2.0 * damping_ratio * natural_frequency * C + compliant),
        np.diag(friction),
        free,
    )


def scheduled_loop(loop: Loop, factor: float) -> Loop:
    """The loop with the velocity gains of Maples and Goldman (5.13, 5.14) in place of its own.

    K_v_i = A sqrt(sum_j |K_p_ij|): each joint brakes its own rate alone.

    Args:
        loop: whose stiffness they follow.
        factor: A; 2 zeta sqrt(d) damps a joint of inertia d with zeta.
    """
    gains = factor * np.sqrt(np.abs(loop.stiffness).sum(axis=1))
    return Loop(loop.inertia, loop.stiffness, np.diag(gains), loop.friction, loop.free)

"""The simplified Lagrangian dynamics as a model of an arm: plain floats and no recursion."""

from collections.abc import Mapping, Sequence
from math import cos, sin

import numpy as np

from rfms_can.arm import JOINT_COUNT, Arm
from rfms_can.dynamics.rigid_body import Matrix
from rfms_can.dynamics.terms import CONSTANTS
from rfms_can.errors import ArmError
from rfms_can.kinematics import jacobian


class SimplifiedDynamics:
    """D_i, D_ii and D_23 of Eq. 4.9, 4.11, 4.12 as corrected; all other terms are neglected.

    Attributes:
        constants: by name, Nm and kg m2 (``dynamics/terms.py``).
        M: (6, 6), kg m2: diagonal, and D_23.
        g: (6,), torque that holds the arm, Nm.
    """

    def __init__(self, arm: Arm, constants: Mapping[str, float]) -> None:
        """Take the constants of ``arm``.

        Raises:
            ArmError: one is missing.
        """
        missing = [name for name in CONSTANTS if name not in constants]
        if missing:
            raise ArmError(f"{arm.name}: simplified dynamics lack {', '.join(missing)}")
        self.arm = arm
        self.constants = {name: float(constants[name]) for name in CONSTANTS}
        k = self.constants
        self._gravity = (k["c21"], k["c22"], k["c31"], k["c32"], k["c50"])
        self._first = (k["b10"], k["b11"], k["b12"], k["b13"], k["b14"], k["b15"])
        self._second = (k["b20"], k["b25"], k["b26"])
        self._coupling = (k["b230"], k["b231"], k["b232"])
        self._wrist = (k["b30"], k["b31"], k["b40"], k["b41"])
        self.M: Matrix = np.zeros((JOINT_COUNT, JOINT_COUNT))
        self.M[4, 4], self.M[5, 5] = k["b50"], k["b60"]
        self.g: Matrix = np.zeros(JOINT_COUNT)
        self._q: tuple[float, ...] = tuple(arm.park)
        self.update(arm.park)

    def update(self, q: Sequence[float]) -> None:
        """Compute :attr:`M` and :attr:`g` at joint angles ``q`` (6, rad)."""
        self._q = tuple(q)
        _, q2, q3, q4, q5, _ = q
        s2, c2, s3, c3, q23 = sin(q2), cos(q2), sin(q3), cos(q3), q2 + q3
        s23, c23, s4, c4, s5, c5 = sin(q23), cos(q23), sin(q4), cos(q4), sin(q5), cos(q5)
        c21, c22, c31, c32, c50 = self._gravity
        g, M = self.g.copy(), self.M.copy()  # what was handed over stays as it is
        self.g, self.M = g, M
        forearm = c31 * c23 + c32 * s23 + c50 * (s23 * c5 + c23 * c4 * s5)
        g[2] = forearm
        g[1] = c21 * c2 + c22 * s2 + forearm
        g[3] = -c50 * s23 * s4 * s5
        g[4] = c50 * (c23 * s5 + s23 * c4 * c5)
        b0, b1, b2, b3, b4, b5 = self._first
        M[0, 0] = b0 + c2 * (b1 * c2 + b3 * c23 + b4 * s23) + c23 * (b2 * c23 + b5 * s23)
        b0, b1, b2 = self._second
        M[1, 1] = b0 + b1 * c3 + b2 * s3
        b0, b1, b2 = self._coupling
        M[1, 2] = M[2, 1] = b0 + b1 * c3 + b2 * s3
        b0, b1, b2, b3 = self._wrist
        M[2, 2] = b0 + b1 * c5
        M[3, 3] = b2 + b3 * s5 * s5

    @property
    def J(self) -> Matrix:
        """Jacobian in the T6 frame at the T6 origin, (6, 6) (m, rad)."""
        return np.array(jacobian(self.arm, self._q))

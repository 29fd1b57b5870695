"""The math processor: row sets of each cycle, from a model of the arm (VI.4.5)."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from rfms_can.arm import Arm
from rfms_can.compliance import LAWS, ControlLaw, LawRows, regular_pose
from rfms_can.dynamics.model import LoadedDynamics
from rfms_can.kinematics import jacobian
from rfms_can.master.force.law_rows import ComplyingRows
from rfms_can.master.force.specification import RIGID, Compliance
from rfms_can.wire.contract import LAST_SET, NO_SET
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.vocabulary import Law

RowValues = tuple[float, ...]
"""Values of one ROWS frame, in the order of the wire's record."""

COMPLIANT_DAMPING: Final = 30.0
"""mu, 1/s: damping of the compliant directions against the commanded motion. What moves by itself
stops within a tenth of a second; a push of 30 N sends a tip of 5 kg off at 0.2 m/s. With a third of
it what friction is left lets a peg lean while it goes down, until it touches its hole twice."""
_IDENTITY: Final = [[float(i == j) for j in JOINTS] for i in JOINTS]


class MathProcessor:
    """Computes the two rows of the law for each joint, and gravity, at measured joint angles.

    Args:
        arm: the arm.
        dynamics: its model, and the load in its hand.
        law: how it complies.
        Kp: gains of the six nodes, N m/rad.
        natural: their natural frequency, rad/s.

    Attributes:
        dynamics: the model.
        compliance: what the next rows are for.
        complying: the law's rows while something complies.
    """

    def __init__(
        self,
        arm: Arm,
        dynamics: LoadedDynamics,
        law: ControlLaw,
        Kp: Sequence[float] = (1.0,) * 6,
        natural: float = 1.0,
    ) -> None:
        self._arm = arm
        self._law = LAWS[law]
        self.dynamics = dynamics
        self._set = NO_SET
        self._made: dict[int, Compliance] = {NO_SET: Compliance()}
        self.compliance = Compliance()
        self.complying = ComplyingRows(arm, law, Kp, natural)
        self._own_inertia = np.diag(np.asarray(Kp) / natural**2)

    def made(self, number: int) -> Compliance:
        """What a set of rows that was sent is for."""
        return self._made.get(number, Compliance())

    def rows(self, q: Sequence[float]) -> tuple[int, list[RowValues]]:
        """The next set at joint angles ``q`` (6, rad): its number and the values of its frames."""
        self.dynamics.update(q)
        compliance, weighted = self.compliance, self._law.wire is Law.WEIGHTED
        number = self._set = self._set % LAST_SET + 1
        inertia = self.dynamics.M.tolist()
        damping, bits = 0.0, 0
        if compliance.selection.size and self._law.complies:
            rows = self._complying(q)
            law = (rows.weighted if weighted else rows.errors).tolist()
            damping, bits = COMPLIANT_DAMPING * self._law.damped, compliance.bits
        else:
            compliance = compliance._replace(selection=RIGID)
            law = inertia if weighted else _IDENTITY
        self._made[number] = compliance
        first, second = (inertia, law) if weighted else (law, inertia)
        gravity = self.dynamics.g.tolist()
        tail = (number, self._law.wire, damping, bits, compliance.number)
        return number, [(*first[i], *second[i], gravity[i], *tail) for i in range(len(JOINTS))]

    def _complying(self, q: Sequence[float]) -> LawRows:
        regular, dynamics = regular_pose(self._arm, q), self.dynamics
        J = dynamics.J if regular == tuple(q) else np.array(jacobian(self._arm, regular))
        # with no model, the inertia that the gains were made for is the metric
        M = dynamics.M if dynamics.M.any() else self._own_inertia
        return self.complying.rows(self.compliance, J, M)

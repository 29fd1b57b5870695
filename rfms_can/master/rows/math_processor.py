"""The math processor: row sets of each cycle, from a model of the arm (VI.4.5)."""

from collections.abc import Callable, Sequence
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from rfms_can.arm import Arm, Load
from rfms_can.compliance import LAWS, ControlLaw, LawRows, regular_pose
from rfms_can.dynamics.model import LoadedDynamics
from rfms_can.kinematics import jacobian
from rfms_can.master.rows.compliance import RIGID, Compliance
from rfms_can.master.rows.law_rows import ComplyingRows
from rfms_can.tables import complete
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.vocabulary import Law

Matrix = npt.NDArray[np.float64]
RowValues = tuple[float, ...]
"""Values of one ROWS frame, in the order of the wire's record."""

COMPLIANT_DAMPING: Final = 30.0
"""mu, 1/s: damping of the compliant directions against the commanded motion. What moves by itself
stops within a tenth of a second; a push of 30 N sends a tip of 5 kg off at 0.2 m/s. With a third of
it what friction is left lets a peg lean while it goes down, until it touches its hole twice."""
_IDENTITY: Final = [[float(i == j) for j in JOINTS] for i in JOINTS]


class WireRows(NamedTuple):
    """What travels as row n of a law, by the torque equation of the nodes.

    Attributes:
        complying: of the law's rows.
        rigid: of the inertia's, where nothing complies.
    """

    complying: Callable[[LawRows], Matrix]
    rigid: Callable[[list[list[float]]], list[list[float]]]


_WIRE_ROWS: Final = complete(
    {
        Law.PID: WireRows(lambda rows: rows.errors, lambda _inertia: _IDENTITY),
        Law.WEIGHTED: WireRows(lambda rows: rows.weighted, lambda inertia: inertia),
    },
    Law,
)


class RowSet(NamedTuple):
    """One set of rows, with what it was made of.

    Attributes:
        number: of the set; SYNC names it.
        compliance: what it complies in.
        values: of the six ROWS frames.
        J: (6, 6), Jacobian in the T6 frame at the measured joint angles.
        M: (6, 6), joint-space inertia, kg m2.
        gravity: (6,), torque that holds arm and load, Nm.
        law: rows of the law in the compliance frame; None where nothing complies.
    """

    number: int
    compliance: Compliance
    values: Sequence[RowValues]
    J: Matrix
    M: Matrix
    gravity: Matrix
    law: LawRows | None


class MathProcessor:
    """Computes the two rows of the law for each joint, and gravity, at measured joint angles.

    Args:
        arm: the arm.
        dynamics: its model, and the load in its hand.
        law: how it complies.
        Kp: gains of the six nodes, N m/rad.
        natural: their natural frequency, rad/s.

    Attributes:
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
        self._dynamics = dynamics
        self.complying = ComplyingRows(arm, law, Kp, natural)
        self._own_inertia = np.diag(np.asarray(Kp) / natural**2)

    def rows(self, number: int, q: Sequence[float], compliance: Compliance, load: Load) -> RowSet:
        """A set of rows.

        Args:
            number: of the set.
            q: joint angles, rad (6).
            compliance: what it is for.
            load: in the hand.
        """
        dynamics = self._dynamics
        dynamics.carry(load)
        dynamics.update(q)
        J, M, g = dynamics.J, dynamics.M, dynamics.g
        wire = _WIRE_ROWS[self._law.wire]
        inertia = M.tolist()
        damping, bits, rows = 0.0, 0, None
        if compliance.selection.size and self._law.complies:
            rows = self._complying(q, compliance, J, M)
            law = wire.complying(rows).tolist()
            damping, bits = COMPLIANT_DAMPING * self._law.damped, compliance.bits
        else:
            compliance = compliance._replace(selection=RIGID)
            law = wire.rigid(inertia)
        gravity = g.tolist()
        tail = (number, self._law.wire, damping, bits, compliance.number)
        values = [(*law[i], *inertia[i], gravity[i], *tail) for i in range(len(JOINTS))]
        return RowSet(number, compliance, values, J, M, g, rows)

    def _complying(
        self, q: Sequence[float], compliance: Compliance, J: Matrix, M: Matrix
    ) -> LawRows:
        regular = regular_pose(self._arm, q)
        if regular != tuple(q):
            J = np.array(jacobian(self._arm, regular))
        # with no model, the inertia that the gains were made for is the metric
        return self.complying.rows(compliance, J, M if M.any() else self._own_inertia)

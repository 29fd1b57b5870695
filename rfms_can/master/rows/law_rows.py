"""The rows of a control law while the arm complies: what the math processor sends of it."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from rfms_can.arm import Arm
from rfms_can.compliance import (
    LAWS,
    ControlLaw,
    LawRows,
    Projection,
    RowsAtPose,
    Selection,
    Servos,
    compliance_jacobian,
    conflicts,
    out_of_reach,
)
from rfms_can.master.rows.compliance import Compliance

Matrix = npt.NDArray[np.float64]


class ComplyingRows:
    """Makes the rows of one law; what a method fixes once, it fixes where compliance begins.

    Args:
        arm: the arm.
        law: how it complies.
        Kp: gains of the six nodes, N m/rad.
        natural: their natural frequency, rad/s.

    Attributes:
        reported: singularities met, in words, each once.
    """

    def __init__(self, arm: Arm, law: ControlLaw, Kp: Sequence[float], natural: float) -> None:
        self.reported: list[str] = []
        self._law = LAWS[law]
        self._servos = Servos(Kp, natural, arm.a2)
        self._number: int | None = None
        self._rows: RowsAtPose | None = None

    def rows(self, compliance: Compliance, J: Matrix, M: Matrix) -> LawRows:
        """Rows at one pose.

        Args:
            compliance: what complies, and where.
            J: (6, 6), Jacobian in the T6 frame, at a regular pose.
            M: (6, 6), joint-space inertia, kg m2.
        """
        J = compliance_jacobian(J, compliance.frame)
        selection = compliance.selection
        if self._rows is None or compliance.number != self._number:
            self._number = compliance.number
            self._rows = self._law.begin(J, M, selection, self._servos)
            self._note_loss(J, selection)
        rows = self._rows(J, M)
        if rows.projection is not None and len(rows.projection.blocked):
            self._note_conflicts(rows.projection, J, selection)
        return rows

    def _note_conflicts(self, projection: Projection, J: Matrix, selection: Selection) -> None:
        for conflict in conflicts(projection, J, selection):
            words = f"{' '.join(conflict.rigid)} beside {' '.join(conflict.compliant)}"
            self._report(f"near a singularity {words} could not be held")

    def _note_loss(self, J: Matrix, selection: Selection) -> None:
        lost = out_of_reach(J, selection, self._servos.length)
        if lost:
            self._report(f"near a singularity the arm can hardly comply in {' '.join(lost)}")

    def _report(self, words: str) -> None:
        if words not in self.reported:
            self.reported.append(words)

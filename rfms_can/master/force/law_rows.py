"""The rows of a control law while the arm complies: what the math processor sends of it."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from rfms_can.arm import Arm
from rfms_can.compliance import (
    ControlLaw,
    LawRows,
    Projection,
    Selection,
    compliance_jacobian,
    conflicts,
    free_joint_rows,
    hybrid_rows,
    match_joints,
    matched_stiffness,
    out_of_reach,
    stiffness_rows,
)
from rfms_can.master.force.specification import Compliance

Matrix = npt.NDArray[np.float64]


class ComplyingRows:
    """Makes the rows of one law; what a method fixes once, it fixes where compliance begins.

    Args:
        arm: the arm.
        law: how it complies.
        Kp: gains of the six nodes, N m/rad.
        natural: their natural frequency, rad/s.

    Attributes:
        J: (6, 6), Jacobian of the compliance frame of the last rows.
        last: rows made last.
        reported: singularities met, in words, each once.
    """

    def __init__(self, arm: Arm, law: ControlLaw, Kp: Sequence[float], natural: float) -> None:
        self.law = law
        self.J: Matrix = np.eye(6)
        self.last: LawRows | None = None
        self.reported: list[str] = []
        self._length = arm.a2
        self._Kp = Kp
        self._natural = natural
        self._number: int | None = None
        self._joints: tuple[int, ...] = ()
        self._stiffness: tuple[float, ...] = ()

    def rows(self, compliance: Compliance, J: Matrix, M: Matrix) -> LawRows:
        """Rows at one pose.

        Args:
            compliance: what complies, and where.
            J: (6, 6), Jacobian in the T6 frame, at a regular pose.
            M: (6, 6), joint-space inertia, kg m2.
        """
        self.J = J = compliance_jacobian(J, compliance.frame)
        selection = compliance.selection
        if compliance.number != self._number:
            self._number = compliance.number
            self._begin(compliance, J, M)
        if self.law is ControlLaw.STIFFNESS:
            rows = stiffness_rows(J, self._stiffness, M, self._Kp)
        elif self.law is ControlLaw.FREE_JOINT:
            rows = free_joint_rows(J, selection, self._joints, M)
        else:
            rows = hybrid_rows(J, selection, M)
        if rows.projection is not None and len(rows.projection.blocked):
            self._note_conflicts(rows.projection, J, selection)
        self.last = rows
        return rows

    def _note_conflicts(self, projection: Projection, J: Matrix, selection: Selection) -> None:
        for conflict in conflicts(projection, J, selection):
            words = f"{' '.join(conflict.rigid)} beside {' '.join(conflict.compliant)}"
            self._report(f"near a singularity {words} could not be held")

    def _begin(self, compliance: Compliance, J: Matrix, M: Matrix) -> None:
        selection = compliance.selection
        if self.law is ControlLaw.FREE_JOINT:
            self._joints = match_joints(J, selection, self._length).joints
        elif self.law is ControlLaw.STIFFNESS:
            self._stiffness = matched_stiffness(J, selection, M, self._natural)
        lost = out_of_reach(J, selection, self._length)
        if lost:
            self._report(f"near a singularity the arm can hardly comply in {' '.join(lost)}")

    def _report(self, words: str) -> None:
        if words not in self.reported:
            self.reported.append(words)

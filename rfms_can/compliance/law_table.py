"""The table of control laws: all that a law is, for master, run settings and stability analysis.

Who needs to know something about a law asks its entry. There is no branch on a law elsewhere, so a
new law is a member of ``ControlLaw``, rows in ``laws.py`` and an entry here; without the entry this
module does not import. No field has a default: each law answers each question.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

from rfms_can.arm import Arm
from rfms_can.compliance.cartesian import pose_error_correction
from rfms_can.compliance.laws import (
    ControlLaw,
    LawRows,
    Matrix,
    free_joint_rows,
    hybrid_rows,
    matched_stiffness,
    position_rows,
    stiffness_rows,
)
from rfms_can.compliance.matching import match_joints
from rfms_can.compliance.selection import Selection
from rfms_can.tables import complete
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Law


class Servos(NamedTuple):
    """What a law knows of the joints it commands.

    Attributes:
        Kp: gains of the six nodes, N m/rad.
        natural_frequency: of the errors, rad/s.
        length: what a radian is worth, m; of the size of the arm's links.
    """

    Kp: Sequence[float]
    natural_frequency: float
    length: float


RowsAtPose = Callable[[Matrix, Matrix], LawRows]
"""Rows from J, (6, 6), of the compliance frame, and M, (6, 6), kg m2, at a regular pose."""
Begin = Callable[[Matrix, Matrix, Selection, Servos], RowsAtPose]
"""From J and M where compliance begins, what complies, and the servos: the rows from there on."""
Correction = Callable[[Arm, Sequence[float], Sequence[float], Transform, Matrix, Matrix], Matrix]
"""Arguments and result of ``pose_error_correction``."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LawDefinition:
    """All that distinguishes a law.

    Attributes:
        begin: fixes what the method fixes where compliance begins, and gives the function that
            makes the rows from there on.
        begins_at_each_pose: when poses are compared, each counts as a beginning (joints are
            matched to it); otherwise what the first pose fixed is kept (a stiffness is given).
        wire: the torque equation of the nodes: PID on ``errors``, or ``weighted``.
        complies: whether it lets anything go. If not, the arm stays rigid whatever a move
            selects: no bias force, and no force loop to close.
        damped: whether the compliant directions are damped by M (I - C) (``free_damping``), which
            touches no others because C is a projector.
        parts_directions: whether C separates the directions of the compliance frame itself, so
            that ``conflicts`` can name those it cannot hold apart.
        needs_model: whether its torque is made with the inertia matrix of a model.
        correction: joint errors to add to C e, which only the master can compute (rad, from both
            poses); None for a law that is complete in its rows.
    """

    begin: Begin
    begins_at_each_pose: bool
    wire: Law
    complies: bool
    damped: bool
    parts_directions: bool
    needs_model: bool
    correction: Correction | None


def _position(J: Matrix, M: Matrix, selection: Selection, servos: Servos) -> RowsAtPose:
    return lambda J, M: position_rows(M)


def _hybrid(J: Matrix, M: Matrix, selection: Selection, servos: Servos) -> RowsAtPose:
    return lambda J, M: hybrid_rows(J, selection, M)


def _stiffness(J: Matrix, M: Matrix, selection: Selection, servos: Servos) -> RowsAtPose:
    stiffness = matched_stiffness(J, selection, M, servos.natural_frequency)
    return lambda J, M: stiffness_rows(J, stiffness, M, servos.Kp)


def _free_joint(J: Matrix, M: Matrix, selection: Selection, servos: Servos) -> RowsAtPose:
    joints = match_joints(J, selection, servos.length).joints
    return lambda J, M: free_joint_rows(J, selection, joints, M)


LAWS: Final = complete(
    {
        ControlLaw.POSITION: LawDefinition(
            begin=_position,
            begins_at_each_pose=False,
            wire=Law.PID,
            complies=False,
            damped=False,
            parts_directions=False,
            needs_model=False,
            correction=None,
        ),
        ControlLaw.STIFFNESS: LawDefinition(
            begin=_stiffness,
            begins_at_each_pose=False,
            wire=Law.PID,
            complies=True,
            damped=False,
            parts_directions=False,
            needs_model=False,
            correction=None,
        ),
        ControlLaw.FREE_JOINT: LawDefinition(
            begin=_free_joint,
            begins_at_each_pose=True,
            wire=Law.PID,
            complies=True,
            damped=True,
            parts_directions=False,
            needs_model=False,
            correction=None,
        ),
        ControlLaw.RAIBERT_CRAIG: LawDefinition(
            begin=_hybrid,
            begins_at_each_pose=False,
            wire=Law.PID,
            complies=True,
            damped=True,
            parts_directions=True,
            needs_model=False,
            correction=pose_error_correction,
        ),
        ControlLaw.HYBRID: LawDefinition(
            begin=_hybrid,
            begins_at_each_pose=False,
            wire=Law.PID,
            complies=True,
            damped=True,
            parts_directions=True,
            needs_model=False,
            correction=None,
        ),
        ControlLaw.WEIGHTED: LawDefinition(
            begin=_hybrid,
            begins_at_each_pose=False,
            wire=Law.WEIGHTED,
            complies=True,
            damped=True,
            parts_directions=True,
            needs_model=True,
            correction=None,
        ),
    },
    ControlLaw,
)

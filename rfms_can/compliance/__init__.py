"""Compliance: selection words, the compliance frame, and the laws of Chapter V as rows.

Mathematics alone, shared by the master, which sends the rows, and the stability analysis.
"""

from rfms_can.compliance.cartesian import cartesian_error, cartesian_part
from rfms_can.compliance.frame import compliance_jacobian
from rfms_can.compliance.law_table import LAWS, LawDefinition, RowsAtPose, Servos
from rfms_can.compliance.laws import (
    ControlLaw,
    LawRows,
    free_damping,
    free_joint_rows,
    hybrid_rows,
    matched_stiffness,
    position_rows,
    stiffness_rows,
)
from rfms_can.compliance.matching import Matching, match_joints
from rfms_can.compliance.projector import (
    COUPLING_LIMIT,
    Projection,
    bounded_projector,
    largest_element,
    largest_norm,
    metric_norm,
)
from rfms_can.compliance.regular import regular_pose
from rfms_can.compliance.report import Conflict, conflicts, out_of_reach
from rfms_can.compliance.selection import (
    DIRECTIONS,
    Selection,
    SelectionError,
    parse_bias,
)

__all__ = [
    "COUPLING_LIMIT",
    "DIRECTIONS",
    "LAWS",
    "Conflict",
    "ControlLaw",
    "LawDefinition",
    "LawRows",
    "Matching",
    "Projection",
    "RowsAtPose",
    "Selection",
    "SelectionError",
    "Servos",
    "bounded_projector",
    "cartesian_error",
    "cartesian_part",
    "compliance_jacobian",
    "conflicts",
    "free_damping",
    "free_joint_rows",
    "hybrid_rows",
    "largest_element",
    "largest_norm",
    "match_joints",
    "matched_stiffness",
    "metric_norm",
    "out_of_reach",
    "parse_bias",
    "position_rows",
    "regular_pose",
    "stiffness_rows",
]

"""Kinematics of a six-joint arm with a spherical wrist (Appendix A), in convention B.

``direct`` and ``jacobian`` take joint angles; ``InverseKinematics`` gives all six from T6,
``JointSolver`` one, for a node that runs alone. Angles in radians, lengths in metres.
"""

from rfms_can.kinematics.closed_form import (
    EXACT,
    EXACT_WRIST_BOUND,
    WIRE,
    WRIST_BOUND,
    Tolerance,
)
from rfms_can.kinematics.configuration import CONFIGURATIONS, Configuration, configuration_of
from rfms_can.kinematics.direct import direct
from rfms_can.kinematics.geometry import Geometry, Joints, Limits, SphericalWrist
from rfms_can.kinematics.inverse import InverseKinematics, inverse, inverse_all
from rfms_can.kinematics.jacobian import inverse_jacobian, jacobian
from rfms_can.kinematics.joint_solver import JointSolver
from rfms_can.kinematics.limits import nearest_turn, within_limits
from rfms_can.kinematics.singularity import (
    REGULAR_BOUNDS,
    SingularityMargins,
    nearest_singularity,
    singularity_margins,
)

__all__ = [
    "CONFIGURATIONS",
    "EXACT",
    "EXACT_WRIST_BOUND",
    "REGULAR_BOUNDS",
    "WIRE",
    "WRIST_BOUND",
    "Configuration",
    "Geometry",
    "InverseKinematics",
    "JointSolver",
    "Joints",
    "Limits",
    "SingularityMargins",
    "SphericalWrist",
    "Tolerance",
    "configuration_of",
    "direct",
    "inverse",
    "inverse_all",
    "inverse_jacobian",
    "jacobian",
    "nearest_singularity",
    "nearest_turn",
    "singularity_margins",
    "within_limits",
]

"""Homogeneous transforms, differential motion and the drive transform (Ch. II, section 3.4.3)."""

from rfms_can.transform.differential import (
    Matrix4,
    Matrix6,
    Vector6,
    differential_operator,
    differential_transform,
)
from rfms_can.transform.drive import DriveTransform, motion_of
from rfms_can.transform.homogeneous import (
    RIGID_TOLERANCE,
    WIRE_ROTATION_TOLERANCE,
    NearestRotation,
    Transform,
    Vector3,
)

__all__ = [
    "RIGID_TOLERANCE",
    "WIRE_ROTATION_TOLERANCE",
    "DriveTransform",
    "Matrix4",
    "Matrix6",
    "NearestRotation",
    "Transform",
    "Vector3",
    "Vector6",
    "differential_operator",
    "differential_transform",
    "motion_of",
]

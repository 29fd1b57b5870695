"""The user's program API: transforms, position equations, modes, moves."""

from rfms_can.coordinator.arm import Arm, Gripper
from rfms_can.coordinator.equation import Equation, Expression
from rfms_can.coordinator.link import Link
from rfms_can.transform import Transform

__all__ = ["Arm", "Equation", "Expression", "Gripper", "Link", "Transform"]

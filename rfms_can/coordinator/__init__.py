"""The user's program API: transforms, position equations, modes, moves.

Everything a program needs: :class:`Arm`, the types of its arguments, and the errors it may catch.
"""

from rfms_can.compliance.selection import SelectionError
from rfms_can.coordinator.aio import AsyncArm
from rfms_can.coordinator.arm import Arm
from rfms_can.coordinator.connection import connect, connect_async, emergency_stop
from rfms_can.coordinator.equation import Equation, Expression
from rfms_can.coordinator.gripper import AsyncGripper, Gripper
from rfms_can.coordinator.link import Link
from rfms_can.coordinator.mode_settings import ModeSettings
from rfms_can.coordinator.moves import MovePlan
from rfms_can.coordinator.sensor import Sensor, connect_sensor
from rfms_can.errors import (
    EquationError,
    FaultError,
    JointPositionError,
    LeaseError,
    LinkError,
    ModeError,
    MoveError,
    ProgramError,
    RfmsError,
    StoppedError,
    TrackingError,
    TransformError,
)
from rfms_can.link.keys import ClientKeys
from rfms_can.messages import (
    Circular,
    Linear,
    MoveOutcome,
    Outcome,
    Status,
    Table,
    TableRow,
    Weave,
)
from rfms_can.transform import Transform

__all__ = [
    "Arm",
    "AsyncArm",
    "AsyncGripper",
    "Circular",
    "ClientKeys",
    "Equation",
    "EquationError",
    "Expression",
    "FaultError",
    "Gripper",
    "JointPositionError",
    "LeaseError",
    "Linear",
    "Link",
    "LinkError",
    "ModeError",
    "ModeSettings",
    "MoveError",
    "MoveOutcome",
    "MovePlan",
    "Outcome",
    "ProgramError",
    "RfmsError",
    "SelectionError",
    "Sensor",
    "Status",
    "StoppedError",
    "Table",
    "TableRow",
    "TrackingError",
    "Transform",
    "TransformError",
    "Weave",
    "connect",
    "connect_async",
    "connect_sensor",
    "emergency_stop",
]

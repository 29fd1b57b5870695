"""The server's refusals as exceptions: a program catches the same ones in every process."""

from typing import Final

from rfms_can.compliance.selection import SelectionError
from rfms_can.errors import (
    EquationError,
    FaultError,
    JointLimitError,
    JointPositionError,
    KinematicsError,
    LeaseError,
    LinkError,
    ModeError,
    MoveError,
    ProgramError,
    RfmsError,
    SingularityError,
    StoppedError,
    TrackingError,
    TransformError,
    UnreachableError,
)
from rfms_can.messages import Refusal

ERRORS: Final[dict[str, type[RfmsError]]] = {
    "EquationError": EquationError,
    "FaultError": FaultError,
    "JointLimitError": JointLimitError,
    "JointPositionError": JointPositionError,
    "KinematicsError": KinematicsError,
    "LeaseError": LeaseError,
    "LinkError": LinkError,
    "ModeError": ModeError,
    "MoveError": MoveError,
    "ProgramError": ProgramError,
    "SelectionError": SelectionError,
    "SingularityError": SingularityError,
    "StoppedError": StoppedError,
    "TrackingError": TrackingError,
    "TransformError": TransformError,
    "UnreachableError": UnreachableError,
}
"""The classes a server may name; another name, of a newer server, is a ``ProgramError``."""


def error_of(refusal: Refusal) -> RfmsError:
    """The exception of a refusal."""
    error = ERRORS.get(refusal.error, ProgramError)(refusal.reason)
    if refusal.remedy and isinstance(error, MoveError | KinematicsError):
        error.remedy = refusal.remedy
    return error

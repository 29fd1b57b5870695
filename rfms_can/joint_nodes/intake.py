"""The frames of one set-point, as they come in: poses, COMPLY and BIAS, in any order."""

from rfms_can.wire.contract import BIAS_BELONGS, COMPLY_BELONGS
from rfms_can.wire.records import Setpoint


class Intake:
    """What has come for this cycle.

    Attributes:
        first, second: SETPOINT_1 and SETPOINT_2, or None.
        displacement: own element of COMPLY, rad, or None.
        bias: own element of BIAS, Nm, or None.
    """

    __slots__ = ("bias", "displacement", "first", "second")

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """A new cycle: nothing has come."""
        self.first: Setpoint | None = None
        self.second: Setpoint | None = None
        self.displacement: float | None = None
        self.bias: float | None = None

    @property
    def complete(self) -> bool:
        """Whether all is here that SETPOINT_1 says belongs to it."""
        first = self.first
        if first is None or (first.poses == 2) is not (self.second is not None):
            return False
        extras = first.extras
        if extras & COMPLY_BELONGS and self.displacement is None:
            return False
        return not (extras & BIAS_BELONGS and self.bias is None)

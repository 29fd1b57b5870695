"""What a joint has received for the cycle under way: frames come one by one, in any order."""

from typing import Final

from rfms_can.wire.contract import (
    BIAS_BELONGS,
    COMPLY_BELONGS,
    JOINT_SETPOINT_BELONGS,
    KNOWN_EXTRAS,
)
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import JointAngles, Measure, Reference, Setpoint

ALL_ERRORS: Final = (1 << len(JOINTS)) - 1
"""``CycleInputs.heard`` when all six errors are known."""


class CycleInputs:
    """Frames of one cycle, and which of them have been acted on.

    Attributes:
        setpoint, second_setpoint: SETPOINT_1 and SETPOINT_2, or None.
        joint_setpoint, second_joint_setpoint: JOINT_SETPOINT_1 and _2, or None.
        displacement: own element of COMPLY, rad, or None.
        bias: own element of BIAS, Nm, or None.
        measure: the board's sample, or None.
        new_sample: whether ``measure`` has not been read yet.
        reference: REFERENCE that has not been acted on, or None.
        errors, rates, accelerations: of the six joints, rad, rad/s, rad/s2.
        heard: bits of the joints whose error is known; bit 0 is joint 1.
        servoed: whether the six errors have been acted on.
        dac_due: whether the cycle owes a DAC frame that has not gone out yet.
        setpoint_due: whether SETPOINT_1 is missed at the next SYNC where no DAC frame is owed.
        sampled_in: cycle of the last sample, low byte, as the plant counts: also where SYNC fails.
    """

    __slots__ = (
        "accelerations",
        "bias",
        "dac_due",
        "displacement",
        "errors",
        "heard",
        "joint_setpoint",
        "measure",
        "new_sample",
        "rates",
        "reference",
        "sampled_in",
        "second_joint_setpoint",
        "second_setpoint",
        "servoed",
        "setpoint",
        "setpoint_due",
    )

    def __init__(self) -> None:
        self.sampled_in = 0
        self.errors = [0.0] * len(JOINTS)
        self.rates = [0.0] * len(JOINTS)
        self.accelerations = [0.0] * len(JOINTS)
        self.begin(dac_due=False)

    def begin(self, dac_due: bool, setpoint_due: bool = False) -> None:
        """A new cycle: nothing has been received; frames of the cycle before are of no use."""
        self.setpoint: Setpoint | None = None
        self.second_setpoint: Setpoint | None = None
        self.joint_setpoint: JointAngles | None = None
        self.second_joint_setpoint: JointAngles | None = None
        self.displacement: float | None = None
        self.bias: float | None = None
        self.measure: Measure | None = None
        self.new_sample = False
        self.reference: Reference | None = None
        self.heard = 0
        self.servoed = False
        self.dac_due = dac_due
        self.setpoint_due = setpoint_due

    def take_error(self, index: int, error: float, rate: float, acceleration: float) -> None:
        """One of the six errors is known."""
        self.errors[index] = error
        self.rates[index] = rate
        self.accelerations[index] = acceleration
        self.heard |= 1 << index

    @property
    def setpoint_complete(self) -> bool:
        """Whether all is here that SETPOINT_1 says belongs to it."""
        first = self.setpoint
        if first is None or (first.poses == 2) is not (self.second_setpoint is not None):
            return False
        extras = first.extras
        if extras & ~KNOWN_EXTRAS:
            return False  # of a later version: a joint that left it out would go elsewhere
        if extras & COMPLY_BELONGS and self.displacement is None:
            return False
        if extras & JOINT_SETPOINT_BELONGS:
            second = self.second_joint_setpoint is not None
            if self.joint_setpoint is None or (first.poses == 2) is not second:
                return False
        return not (extras & BIAS_BELONGS and self.bias is None)

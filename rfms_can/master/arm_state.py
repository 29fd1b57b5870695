"""Where the arm is, as the master hears it: six encoders, referenced by the frames of homing."""

from collections.abc import Mapping

from rfms_can.arm import Gripper
from rfms_can.node.encoder_reference import EncoderReference
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import Measure, Reference
from rfms_can.wire.vocabulary import Parameter


class ArmState:
    """Joint angles from MEASURE; before homing is over from the coarse positions.

    Args:
        parameters: configuration of joint nodes 1 to 6: both ends use the same scales.

    Attributes:
        q: joint angles, rad, at the last SYNC (6).
        braked: which joints the plant holds (6).
        jaw_counts: encoder of the gripper's jaw.
        open_counts: the same with the jaw at its open end, where homing leaves it.
    """

    def __init__(self, parameters: Mapping[int, Mapping[Parameter, float]]) -> None:
        self._parameters = parameters
        self._encoders = [EncoderReference(parameters[joint]) for joint in JOINTS]
        self._measures: list[Measure | None] = [None] * len(JOINTS)
        self.q = [0.0] * len(JOINTS)
        self.braked = [True] * len(JOINTS)
        self.jaw_counts = 0
        self.open_counts = 0

    def measure(self, joint: int, measure: Measure) -> None:
        """Take MEASURE of joint 1 to 6."""
        index = joint - 1
        self._measures[index] = measure
        self.braked[index] = bool(measure.braked)
        encoder = self._encoders[index]
        if encoder.zero_counts is not None:
            self.q[index] = encoder.angle(measure.counts)

    def reference(self, joint: int, reference: Reference) -> None:
        """Take REFERENCE of joint 1 to 6: the node finds its index in the same frames."""
        index = joint - 1
        encoder, measure = self._encoders[index], self._measures[index]
        if measure is None or encoder.zero_counts is not None:
            return
        if encoder.find(measure, reference):
            self.q[index] = encoder.angle(measure.counts)
        else:
            self.q[index] = encoder.coarse_angle(reference.coarse_adc)

    def forget(self, joint: int) -> None:
        """Joint 1 to 6 homes again: its reference is of no use any more."""
        self._encoders[joint - 1] = EncoderReference(self._parameters[joint])

    def jaw_opening(self, gripper: Gripper) -> float:
        """Opening of the jaw, m, once ``open_counts`` are known."""
        return gripper.stroke + (self.jaw_counts - self.open_counts) / gripper.counts_per_metre

    @property
    def referenced(self) -> bool:
        """Whether all six encoders know where they are."""
        return all(self.zeros_known)

    @property
    def zeros_known(self) -> list[bool]:
        """Which encoders know where they are (6)."""
        return [encoder.zero_counts is not None for encoder in self._encoders]

    @property
    def zero_counts(self) -> list[int]:
        """Encoder counts at joint angle 0, for readers of a recorded log (6)."""
        return [encoder.zero_counts or 0 for encoder in self._encoders]

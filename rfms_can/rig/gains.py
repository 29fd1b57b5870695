"""The gains of the joints' servos in a run, to be printed beside its numbers."""

from collections.abc import Sequence
from typing import NamedTuple

from rfms_can.arm.calibration import Calibration
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.rig.settings import RunSettings
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.vocabulary import Parameter


class Gains(NamedTuple):
    """Of one joint's servo.

    Attributes:
        kp, ki, kd: Nm/rad, Nm/(rad s), Nms/rad.
        natural_frequency: of the error, rad/s; determines the gains, and is used directly by the
            law of the weighted inertia.
        damping_ratio: likewise.
    """

    kp: float
    ki: float
    kd: float
    natural_frequency: float
    damping_ratio: float


_PARAMETERS = (
    Parameter.KP,
    Parameter.KI,
    Parameter.KD,
    Parameter.NATURAL_FREQUENCY,
    Parameter.DAMPING_RATIO,
)


def gains(settings: RunSettings, calibration: Calibration | None = None) -> Sequence[Gains]:
    """Gains sent to the joint nodes; independent of control law and dynamics compensation."""
    parameters = all_parameters(
        settings.the_arm, settings.friction, 1.0 / settings.rate, calibration
    )
    return [Gains(*(parameters[joint][p] for p in _PARAMETERS)) for joint in JOINTS]

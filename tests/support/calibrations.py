"""A calibration that says exactly what an arm's data sheet says, for tests."""

import msgspec

from rfms_can.arm import Arm
from rfms_can.arm.calibration import Calibration, JointCalibration
from rfms_can.arm.torque_law import TorqueLaw
from rfms_can.dynamics.fitted import fitted_constants
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.plant.variant import Variant


def exact_calibration(variant: Variant, notes: tuple[str, ...] = ()) -> Calibration:
    """What a perfect experiment would find out about a plant."""
    return calibration_of(variant.rigid, variant.laws, notes)


def calibration_of(
    arm: Arm, laws: tuple[TorqueLaw, ...], notes: tuple[str, ...] = ()
) -> Calibration:
    full = ArmDynamics(arm)
    constants = fitted_constants(full)
    first, second, third, fourth, fifth, sixth = (_joint(law) for law in laws)
    a, b, c, d, e, f = (drive.armature for drive in arm.drives)
    values = {
        "arm": arm.name,
        "joint": [first, second, third, fourth, fifth, sixth],
        "constants": constants,
        "deviations": dict.fromkeys(constants, 0.0),
        "links": {"parameters": full.parameters.tolist(), "armature": [a, b, c, d, e, f]},
        "notes": list(notes),
    }
    return msgspec.convert(msgspec.to_builtins(values), type=Calibration)


def _joint(law: TorqueLaw) -> JointCalibration:
    return JointCalibration(
        law.slope_positive,
        law.offset_positive,
        law.slope_negative,
        law.offset_negative,
        law.viscous,
        -law.offset_positive,
        law.offset_negative,
        0.92,
        -11.0,
        {"slope_positive": 1e-5},
    )

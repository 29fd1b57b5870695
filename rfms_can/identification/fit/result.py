"""Result of an identification, and the calibration for a master."""

from typing import NamedTuple

import msgspec

from rfms_can.analysis.cycles import Floats
from rfms_can.arm import Arm
from rfms_can.arm.calibration import Calibration
from rfms_can.arm.torque_law import TorqueLaw
from rfms_can.identification.fit.constants import PoseInertia
from rfms_can.identification.fit.least_squares import Fit
from rfms_can.identification.fit.links import LinkFit
from rfms_can.identification.fit.static import Breakaway
from rfms_can.identification.fit.torque import LAW, TorqueFit


class Identification(NamedTuple):
    """Result of an identification.

    Attributes:
        arm: the arm.
        converters: Eq. 4.14 of each joint (6).
        torque: Eq. 4.13 of each joint (6).
        breakaways: of the joints.
        gravity: Eq. 4.9.
        poses: inertia of each joint at each pose.
        inertia: Eq. 4.11.
        links: parameters of the full dynamics.
        coupling: Eq. 4.12, by the links.
        validation: of motions excluded from all fits: torque and its residual, root mean square,
            Nm (2, 6).
        notes: remarks.
    """

    arm: Arm
    converters: list[Fit]
    torque: list[TorqueFit]
    breakaways: list[Breakaway]
    gravity: Fit
    poses: list[PoseInertia]
    inertia: Fit
    links: LinkFit
    coupling: Fit
    validation: Floats
    notes: list[str]

    @property
    def laws(self) -> tuple[TorqueLaw, ...]:
        """Torque against current (6)."""
        return tuple(fit.law for fit in self.torque)

    @property
    def constants(self) -> dict[str, float]:
        """Of the simplified dynamics."""
        return {**self.gravity.values, **self.inertia.values, **self.coupling.values}

    @property
    def deviations(self) -> dict[str, float]:
        """Of the constants."""
        return {**self.gravity.deviations, **self.inertia.deviations, **self.coupling.deviations}

    def static(self, joint: int, direction: float) -> tuple[float, float]:
        """Static friction of a joint index in a direction, Nm, and its spread.

        Without a breakaway in the data, the friction of the moving joint is used.
        """
        own = [b for b in self.breakaways if (b.joint, b.direction) == (joint, direction)]
        if own:
            return max(own[0].torque, 0.0), own[0].spread
        law = self.laws[joint]
        kinetic = -law.offset_positive if direction > 0.0 else law.offset_negative
        return max(kinetic, 0.0), kinetic


def calibration_of(found: Identification) -> Calibration:
    """The calibration for a master."""
    joints = []
    for joint, (torque, converter) in enumerate(zip(found.torque, found.converters, strict=True)):
        positive, negative = found.static(joint, 1.0), found.static(joint, -1.0)
        joints.append(
            {
                **{name: torque.fit.values[name] for name in LAW},
                "viscous": max(torque.law.viscous, 0.0),
                "static_positive": positive[0],
                "static_negative": negative[0],
                "adc_slope": converter.values["slope"],
                "adc_offset": converter.values["offset"],
                "deviations": {
                    **{name: torque.fit.deviations[name] for name in LAW},
                    "static_positive": positive[1],
                    "static_negative": negative[1],
                    "adc_slope": converter.deviations["slope"],
                    "adc_offset": converter.deviations["offset"],
                },
            }
        )
    links = {
        "parameters": found.links.parameters.tolist(),
        "armature": found.links.armature.tolist(),
    }
    whole = {
        "arm": found.arm.name,
        "joint": joints,
        "constants": found.constants,
        "deviations": found.deviations,
        "links": links,
        "notes": found.notes,
    }
    return msgspec.convert(whole, type=Calibration)

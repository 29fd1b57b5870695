"""True parameters of a simulated plant, and the values measured in the thesis."""

from typing import Final, NamedTuple

import msgspec

from rfms_can.arm import Arm
from rfms_can.arm.calibration import Calibration
from rfms_can.arm.puma import OUNCE_INCH
from rfms_can.dynamics.fitted import fitted_constants
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.dynamics.terms import in_other_convention
from rfms_can.plant.variant import Variant

GRAVITY_M_S2: Final = 9.81

THESIS_OZ_IN: Final = {
    **{"c21": 6373.0, "c31": -80.0, "c32": 1130.0, "c50": -70.0},
    **{"b10": 522.0, "b11": 121.0, "b12": 26.0, "b13": 86.0, "b14": 141.0, "b15": 22.0},
    **{"b20": 1757.0, "b25": 23.0, "b26": 131.0},
    **{"b30": 317.0, "b31": 79.0},
    **{"b40": 43.0, "b41": 5.0, "b50": 31.0, "b60": 67.0},
}
"""S thesis, Eq. 4.16 and 4.30, convention A: oz-in, and oz-in-s2 with Ia in b10 ... b60."""


class Verdict(NamedTuple):
    """Assessment of one of the thesis' values.

    Attributes:
        word: verdict.
        why: the reason.
    """

    word: str
    why: str


VERDICTS: Final = {
    "c21": Verdict("sign", "minus the torque that holds the arm; its size is plausible"),
    "c31": Verdict("noise", "an eighth of joint 3's own friction, which stands at 650 oz-in"),
    "c32": Verdict("sign", "minus the torque that holds the arm; its size is good"),
    "c50": Verdict("doubtful", "17 times a bare wrist's: below friction, or a tool was mounted"),
    "b10": Verdict("plausible", ""),
    "b11": Verdict("poor", "half of the value that follows from the links' masses"),
    "b12": Verdict("impossible", "positive: an arm stretched out would be easier to turn"),
    "b13": Verdict("impossible", "must equal b25 and 2 a2 c31 / g: 86, 23 and -8 oz-in-s2"),
    "b14": Verdict("good", "agrees with b26, as it must"),
    "b15": Verdict("impossible", "must be a3 / a2 = 0.05 times b14: 7 oz-in-s2, not 22"),
    "b20": Verdict("too high", "1.8 to 2.8 times links and drive together"),
    "b25": Verdict("impossible", "must equal b13: 23 and 86"),
    "b26": Verdict("good", "agrees with b14, as it must"),
    "b30": Verdict("too high", "1.9 to 2.5 times links and drive together"),
    "b31": Verdict("impossible", "must be 2 d4 |c50| / g: 6 oz-in-s2 by its own c50, not 79"),
    "b40": Verdict("plausible", ""),
    "b41": Verdict("noise", "175 times a bare wrist's"),
    "b50": Verdict("good", ""),
    "b60": Verdict("too high", "2.3 times links and drive together"),
}
"""Of Eq. 4.16 and 4.30, held against the published masses (AKB 1986) and against one another."""


def thesis_constants() -> dict[str, float]:
    """Eq. 4.16 and 4.30 in SI and in convention B."""
    in_a = {name: OUNCE_INCH * number for name, number in THESIS_OZ_IN.items()}
    return in_other_convention(in_a)


class Identity(NamedTuple):
    """Two values that are equal for every arm of this shape.

    Attributes:
        name: of the constant.
        equals: what it must equal, in words.
        value, expected: kg m2.
    """

    name: str
    equals: str
    value: float
    expected: float


def identities(arm: Arm, constants: dict[str, float]) -> tuple[Identity, ...]:
    """Identities between the constants of one arm, convention B.

    Gravity and inertia hold the same masses and lengths: b14 and b26 are 2 a2 c32 / g, b13 and b25
    2 a2 c31 / g, b31 is -2 d4 c50 / g. Links are assumed thin compared with their length.
    """
    k, per_g = constants, 1.0 / GRAVITY_M_S2
    return (
        Identity("b13", "b25", k["b13"], k["b25"]),
        Identity("b25", "2 a2 c31 / g", k["b25"], 2.0 * arm.a2 * k["c31"] * per_g),
        Identity("b14", "b26", k["b14"], k["b26"]),
        Identity("b26", "2 a2 c32 / g", k["b26"], 2.0 * arm.a2 * k["c32"] * per_g),
        Identity("b31", "-2 d4 c50 / g", k["b31"], -2.0 * arm.d4 * k["c50"] * per_g),
    )


def truth_of(variant: Variant) -> Calibration:
    """The calibration that a perfect experiment would give for a plant."""
    full = ArmDynamics(variant.rigid)
    constants = fitted_constants(full)
    joints = [
        {
            "slope_positive": law.slope_positive,
            "offset_positive": law.offset_positive,
            "slope_negative": law.slope_negative,
            "offset_negative": law.offset_negative,
            "viscous": law.viscous,
            "static_positive": max(-law.offset_positive, 0.0),
            "static_negative": max(law.offset_negative, 0.0),
            "adc_slope": errors.adc_slope,
            "adc_offset": errors.adc_offset + errors.adc_slope * errors.current_offset,
        }
        for law, errors in zip(variant.laws, variant.board_errors, strict=True)
    ]
    whole = {
        "arm": variant.arm.name,
        "joint": joints,
        "constants": constants,
        "deviations": dict.fromkeys(constants, 0.0),
        "links": {
            "parameters": full.parameters.tolist(),
            "armature": [drive.armature for drive in variant.arm.drives],
        },
        "notes": ["the plant's truth"],
    }
    return msgspec.convert(whole, type=Calibration)

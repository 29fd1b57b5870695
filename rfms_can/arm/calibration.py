"""Identified parameters of one arm: a file written by ``rfms identify`` and read by a master.

TOML: ``[[joint]]`` six times, ``[constants]`` of the simplified dynamics with ``[deviations]``, and
``[links]`` with parameters of the full ones. Only sums of the latter can be measured (base
parameters): torques follow from them, the mass of a single link does not.
"""

import tomllib
from pathlib import Path
from typing import Annotated, Final

import msgspec

from rfms_can.arm.mechanism import Arm
from rfms_can.arm.torque_law import TorqueLaw
from rfms_can.errors import ArmError

Positive = Annotated[float, msgspec.Meta(gt=0.0)]
Magnitude = Annotated[float, msgspec.Meta(ge=0.0)]
Ten = tuple[float, float, float, float, float, float, float, float, float, float]
Six = tuple[float, float, float, float, float, float]


class JointCalibration(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One joint's torque calibration (Eq. 4.13, 4.14); see ``TorqueLaw`` for the signs.

    Attributes:
        slope_positive, offset_positive, slope_negative, offset_negative, viscous: the law.
        static_positive, static_negative: breakaway torque, Nm.
        adc_slope, adc_offset: A_c and B_c of I_adc = A_c I_dac + B_c, codes.
        deviations: standard deviation of each of these, by name.
    """

    slope_positive: Positive
    offset_positive: float
    slope_negative: Positive
    offset_negative: float
    viscous: Magnitude
    static_positive: Magnitude
    static_negative: Magnitude
    adc_slope: float
    adc_offset: float
    deviations: dict[str, Magnitude] = msgspec.field(default_factory=dict)

    @property
    def law(self) -> TorqueLaw:
        """Torque against current."""
        return TorqueLaw(
            self.slope_positive,
            self.offset_positive,
            self.slope_negative,
            self.offset_negative,
            self.viscous,
        )


_SixJoints = tuple[
    JointCalibration,
    JointCalibration,
    JointCalibration,
    JointCalibration,
    JointCalibration,
    JointCalibration,
]


class _Links(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """``[links]``."""

    parameters: tuple[Ten, Ten, Ten, Ten, Ten, Ten]
    armature: Six


class Calibration(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Result of an identification.

    Attributes:
        arm: name of the arm it was made on.
        joints: torque calibration, one per joint.
        constants: of the simplified dynamics by name (``dynamics/terms.py``), Nm and kg m2.
        deviations: standard deviation of each of them.
        links: of the full dynamics: parameters as ``ArmDynamics.parameters``, armature kg m2.
        notes: remarks, e.g. an amplifier with a current offset.
    """

    arm: str
    joints: _SixJoints = msgspec.field(name="joint")
    constants: dict[str, float]
    deviations: dict[str, float]
    links: _Links
    notes: list[str] = msgspec.field(default_factory=list)

    @property
    def parameters(self) -> tuple[Ten, ...]:
        """Inertial parameters of the links (6, 10)."""
        return self.links.parameters

    @property
    def armature(self) -> Six:
        """Drives' inertia, kg m2 (6)."""
        return self.links.armature

    def check(self, arm: Arm) -> None:
        """Refuse the calibration of another arm.

        Raises:
            ArmError: naming both.
        """
        if self.arm != arm.name:
            raise ArmError(f"the calibration is of arm {self.arm}, not of {arm.name}")


def load_calibration(path: Path) -> Calibration:
    """Read a calibration file.

    Raises:
        ArmError: it cannot be read, or a value is missing or invalid.
    """
    try:
        return msgspec.convert(tomllib.loads(path.read_text(encoding="utf-8")), type=Calibration)
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise ArmError(f"calibration {path}: {error}") from error
    except msgspec.ValidationError as error:
        raise ArmError(
            f"calibration {path}: {error}; write a new one with rfms identify --out {path}"
        ) from error


def save_calibration(path: Path, calibration: Calibration) -> None:
    """Write a calibration file.

    Raises:
        ArmError: it cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(as_toml(calibration), encoding="utf-8")
    except OSError as error:
        raise ArmError(f"calibration {path}: {error.strerror}") from error


_HEAD: Final = "# Written by rfms identify; read with --calibration. SI units, angles in rad.\n"


def as_toml(calibration: Calibration) -> str:
    """The file's text."""
    whole = msgspec.to_builtins(calibration)
    lines = [_HEAD, f"arm = {_value(whole['arm'])}", f"notes = {_value(whole['notes'])}"]
    for joint in whole["joint"]:
        lines += ["", "[[joint]]", *_pairs(joint)]
    for name in ("constants", "deviations", "links"):
        lines += ["", f"[{name}]", *_pairs(whole[name])]
    return "\n".join(lines) + "\n"


def _pairs(table: dict[str, object]) -> list[str]:
    return [f"{name} = {_value(value)}" for name, value in table.items()]


def _value(value: object) -> str:
    """A number, a text, or a list or table of them, in TOML."""
    if isinstance(value, dict):
        return "{ " + ", ".join(_pairs(value)) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, str):
        return msgspec.json.encode(value).decode()  # a TOML basic string escapes as JSON does
    return repr(value)

"""A node's configuration as it crosses the wire: what each parameter may be, and the closing hash.

Values travel as float32. Lengths of the arm are whole micrometres and its angles whole units of
1e-4 degrees: float32 holds whole numbers exactly to 16.7 million, so master, node and arm data
divide the same number and work with the same doubles.
"""

import binascii
import math
import struct
from collections.abc import Mapping
from enum import IntEnum
from typing import Final, NamedTuple

from rfms_can.tables import complete
from rfms_can.wire.nodes import BOARDS, PLANT
from rfms_can.wire.vocabulary import Parameter

_PAIR: Final = struct.Struct("<Bf")
_FLOAT: Final = struct.Struct("<f")

MICROMETRES: Final = 1e6
"""Units of a length of the arm in a metre."""
RIGHT_ANGLE_UNITS: Final = 900_000
"""Units of an angle of the arm in 90 degrees."""
LARGEST_WHOLE: Final = float(2**24)
"""Up to here float32 holds every whole number."""


class Clock(IntEnum):
    """Who says when a control cycle begins: CONFIG's CLOCK."""

    VIRTUAL = 0
    """The simulated bus: events in time order."""
    LOCKSTEP = 1
    """The slowest node: a cycle ends when all have answered, or at a wall-clock barrier."""
    REALTIME = 2
    """An absolute monotonic schedule."""


class Kinematics(IntEnum):
    """Who solves the joint angles, and how: CONFIG's KINEMATICS."""

    BY_MASTER = 0
    """The master; they come in JOINT_SETPOINT."""
    SPHERICAL_WRIST = 1
    """Each joint its own from T6, in closed form: alpha = (90, 0, -90, 90, -90, 0) degrees."""


class ParameterRange(NamedTuple):
    """What a node takes for a parameter.

    Attributes:
        unit: SI; ``u`` is rad (joint) or m (gripper), ``Nm`` is N of a gripper.
        low, high: bounds; of the magnitude where it is ``signed``.
        signed: either sign, but not less than ``low`` in magnitude.
        whole: a whole number.
        gripper: whether the gripper has it too.
        default: what holds where it is not sent; None: it must be, as all of contract 2.0.
    """

    unit: str
    low: float
    high: float
    signed: bool = False
    whole: bool = False
    gripper: bool = False
    default: float | None = None

    def refusal(self, value: float) -> str | None:
        """Why a value cannot be taken, with the bound it breaks; None if it can."""
        magnitude = abs(value) if self.signed else value
        # a bound is taken also where float32, in which values travel, rounds it outwards
        low, high = min(self.low, _as_float32(self.low)), max(self.high, _as_float32(self.high))
        if not low <= magnitude <= high:  # a NaN fails it
            of = "magnitude " if self.signed else ""
            return f"{value:g} {self.unit}: {of}must be in {self.low:g}..{self.high:g}"
        if self.whole and value != math.floor(value):
            return f"{value:g} {self.unit}: must be a whole number"
        return None


def _as_float32(value: float) -> float:
    rounded: float = _FLOAT.unpack(_FLOAT.pack(value))[0]
    return rounded


_LENGTH: Final = ParameterRange("um", -LARGEST_WHOLE, LARGEST_WHOLE, whole=True)
_ANGLE: Final = ParameterRange(
    "1e-4 deg", -4.0 * RIGHT_ANGLE_UNITS, 4.0 * RIGHT_ANGLE_UNITS, whole=True
)

PARAMETERS: Final[dict[Parameter, ParameterRange]] = complete(
    {
        Parameter.ARM_ID: ParameterRange("", 0.0, LARGEST_WHOLE, whole=True, gripper=True),
        Parameter.PERIOD: ParameterRange("s", 2e-4, 1.0, gripper=True),
        Parameter.KP: ParameterRange("Nm/rad", 0.0, 1e6),
        Parameter.KI: ParameterRange("Nm/(rad s)", 0.0, 1e7),
        Parameter.KD: ParameterRange("Nm s/rad", 0.0, 1e6),
        Parameter.INTEGRAL_LIMIT: ParameterRange("Nm", 0.0, 1e4),
        Parameter.INTEGRAL_DEADBAND: ParameterRange("rad", 0.0, 0.1),
        Parameter.NATURAL_FREQUENCY: ParameterRange("rad/s", 0.0, 1e4),
        Parameter.DAMPING_RATIO: ParameterRange("", 0.0, 10.0),
        Parameter.TORQUE_LIMIT: ParameterRange("Nm", 1e-3, 1e4, gripper=True),
        Parameter.TORQUE_PER_CODE: ParameterRange("Nm", 1e-9, 10.0, signed=True, gripper=True),
        Parameter.COUNTS_PER_UNIT: ParameterRange("1/u", 1.0, 1e9, signed=True, gripper=True),
        Parameter.RATE_PER_CODE: ParameterRange("rad/s", 1e-9, 1.0, signed=True),
        Parameter.COULOMB_POSITIVE: ParameterRange("Nm", 0.0, 1e4),
        Parameter.COULOMB_NEGATIVE: ParameterRange("Nm", 0.0, 1e4),
        Parameter.VISCOUS: ParameterRange("Nm s/rad", 0.0, 1e4),
        Parameter.FRICTION_SPEED: ParameterRange("rad/s", 0.0, 1.0),
        Parameter.POSITION_MIN: ParameterRange("rad", -64.0, 64.0),
        Parameter.POSITION_MAX: ParameterRange("u", -64.0, 64.0, gripper=True),
        Parameter.SPEED_LIMIT: ParameterRange("rad/s", 1e-3, 100.0),
        Parameter.ACCELERATION_LIMIT: ParameterRange("rad/s2", 1e-3, 1e4),
        Parameter.COARSE_PER_CODE: ParameterRange("rad", 1e-9, 1.0, signed=True),
        Parameter.COARSE_ZERO: ParameterRange("rad", -64.0, 64.0),
        Parameter.INDEX_INTERVAL_COUNTS: ParameterRange("counts", 1.0, LARGEST_WHOLE, whole=True),
        Parameter.HOMING_SPEED: ParameterRange("rad/s", 1e-4, 10.0),
        Parameter.DITHER_FRACTION: ParameterRange("", 0.0, 1.0),
        Parameter.DITHER_PERIOD: ParameterRange("s", 1e-3, 10.0),
        Parameter.TORQUE_PER_FORCE_CODE: ParameterRange("Nm", 1e-9, 10.0, signed=True),
        Parameter.CLOCK: ParameterRange("", 0.0, float(max(Clock)), whole=True, gripper=True),
        Parameter.BARRIER: ParameterRange("s", 1e-3, 3600.0, gripper=True),
        Parameter.SENSOR_SOURCE: ParameterRange("", 1.0, 31.0, whole=True, gripper=True),
        Parameter.KINEMATICS: ParameterRange("", 0.0, 15.0, whole=True),
        Parameter.FOLLOWING_ERROR_LIMIT: ParameterRange("rad", 1e-4, 0.5),
        Parameter.OVERSPEED_LIMIT: ParameterRange("rad/s", 1e-3, 150.0),
        Parameter.TACHOMETER_LIMIT: ParameterRange("rad/s", 1e-3, 100.0),
        Parameter.CONTINUOUS_TORQUE: ParameterRange("Nm", 1e-3, 1e4),
        Parameter.OVERLOAD_TIME: ParameterRange("s", 1e-3, 60.0),
        Parameter.STALL_TIME: ParameterRange("s", 1e-3, 5.0),
        Parameter.STUCK_TIME: ParameterRange("s", 1e-3, 1.0),
        Parameter.HOMING_TIME: ParameterRange("s", 0.1, 3600.0, gripper=True),
        Parameter.CURRENT_TOLERANCE: ParameterRange("", 1e-3, 0.25, default=0.035),
        Parameter.RATE_ERROR_LIMIT: ParameterRange("", 0.01, 0.5, default=0.2),
        **{p: _LENGTH for p in Parameter if p.name.startswith(("DH_A_", "DH_D_"))},
        **{p: _ANGLE for p in Parameter if p.name.startswith(("DH_ALPHA_", "DH_OFFSET_"))},
    },
    [p for p in Parameter if p is not Parameter.COMMIT],
)
"""All parameters but COMMIT, which closes a set. A joint has every one."""

JOINT_PARAMETERS: Final = frozenset(p for p, r in PARAMETERS.items() if r.default is None)
"""Those a joint needs: all of contract 2.0. A master that does not know one added later configures
the joint all the same."""
DEFAULTS: Final = {p: r.default for p, r in PARAMETERS.items() if r.default is not None}
"""What holds for those that were not sent."""
GRIPPER_PARAMETERS: Final = frozenset(p for p, known in PARAMETERS.items() if known.gripper)
"""Those the gripper has."""

UNHASHED: Final = frozenset((Parameter.CLOCK, Parameter.BARRIER))
"""Parameters that the hash of a configuration leaves out."""


def configuration_hash(values: Mapping[Parameter, float]) -> int:
    """CRC-16 (0x1021) of parameter and value pairs in ascending order; never 0 (no hash).

    CLOCK and BARRIER are left out: they say how the bus is driven, and HEARTBEATs of one program
    are the same on every bus.
    """
    data = b"".join(_PAIR.pack(p, values[p]) for p in sorted(values) if p not in UNHASHED)
    return binascii.crc_hqx(data, 0xFFFF) or 1


def plant_hash(arm_id: float, period_s: float) -> int:
    """Configuration hash of the plant: arm id and control period, s."""
    return configuration_hash({Parameter.ARM_ID: arm_id, Parameter.PERIOD: period_s})


_NOT_BEYOND: Final = (
    (Parameter.POSITION_MIN, Parameter.POSITION_MAX, 1.0),
    (Parameter.INTEGRAL_LIMIT, Parameter.TORQUE_LIMIT, 1.0),
    (Parameter.CONTINUOUS_TORQUE, Parameter.TORQUE_LIMIT, 1.0),
    (Parameter.HOMING_SPEED, Parameter.SPEED_LIMIT, 1.0),
    (Parameter.OVERSPEED_LIMIT, Parameter.SPEED_LIMIT, 1.5),
    (Parameter.TACHOMETER_LIMIT, Parameter.SPEED_LIMIT, 1.0),
)
"""A parameter, another that bounds it, and how many times it."""
_ROUNDING: Final = 1.0 + 1e-6
"""Both have travelled as float32."""


def contradiction(values: Mapping[Parameter, float]) -> str | None:
    """Which parameter of a set lies beyond another that bounds it; None if none does."""
    for lesser, greater, factor in _NOT_BEYOND:
        low, high = values.get(lesser), values.get(greater)
        if low is None or high is None:
            continue
        if low > (high if factor == 1.0 else factor * high * _ROUNDING):
            of = "" if factor == 1.0 else f"{factor:g} times "
            return f"{lesser.name} {low:g} is beyond {of}{greater.name} {high:g}"
    return None


def sensor_sources(node: int) -> frozenset[int]:
    """Nodes that may send MEASURE and REFERENCE of a node: plant, the node itself, its board."""
    return frozenset((PLANT, node, BOARDS[node]))


# --- the arm's geometry ---------------------------------------------------------------------------


class DhRow(NamedTuple):
    """One link, Denavit-Hartenberg: Rz(theta + offset) Tz(d) Tx(a) Rx(alpha); m and rad."""

    a: float
    d: float
    alpha: float
    offset: float = 0.0


def _dh_parameters(joint: int) -> tuple[Parameter, Parameter, Parameter, Parameter]:
    a, d, alpha, offset = (Parameter[f"DH_{x}_{joint}"] for x in ("A", "D", "ALPHA", "OFFSET"))
    return a, d, alpha, offset


def geometry_values(rows: tuple[DhRow, ...]) -> dict[Parameter, float]:
    """The parameters that carry six links.

    Raises:
        ValueError: a length is no whole number of micrometres, or an angle none of 1e-4 degrees.
    """
    values: dict[Parameter, float] = {}
    for joint, row in enumerate(rows, 1):
        a, d, alpha, offset = _dh_parameters(joint)
        values[a], values[d] = _whole_micrometres(row.a), _whole_micrometres(row.d)
        values[alpha], values[offset] = _whole_angle(row.alpha), _whole_angle(row.offset)
    return values


def geometry_rows(values: Mapping[Parameter, float]) -> tuple[DhRow, ...]:
    """The six links that a configuration carries, in the doubles of the arm's data."""
    quarter = math.pi / 2.0
    rows = []
    for joint in range(1, 7):
        a, d, alpha, offset = (values[p] for p in _dh_parameters(joint))
        rows.append(
            DhRow(
                a / MICROMETRES,
                d / MICROMETRES,
                alpha / RIGHT_ANGLE_UNITS * quarter,
                offset / RIGHT_ANGLE_UNITS * quarter,
            )
        )
    return tuple(rows)


def _whole_micrometres(length: float) -> float:
    units = float(round(length * MICROMETRES))
    if units / MICROMETRES != length:
        raise ValueError(f"length {length!r} m is not a whole number of micrometres")
    return units


def _whole_angle(angle: float) -> float:
    units = float(round(angle / (math.pi / 2.0) * RIGHT_ANGLE_UNITS))
    if units / RIGHT_ANGLE_UNITS * (math.pi / 2.0) != angle:
        raise ValueError(f"angle {angle!r} rad is not a whole number of 1e-4 degrees")
    return units

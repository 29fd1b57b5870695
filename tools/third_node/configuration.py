"""Parameters, their ranges, the hash, and COMMIT (docs/node.md, Configuration)."""

import math
import struct

from third_node.codec import float32
from third_node.protection import crc16

TAKEN, UNKNOWN, REFUSED_STATE, WRONG_HASH, REFUSED_VALUE, UNSUPPORTED = range(6)
COMMIT = 255
CLOCK, BARRIER = 28, 29
LOCKSTEP = 1

Values = dict[int, float]
"""Parameters by number."""

TABLE: dict[int, tuple[str, float, float, str]] = {
    0: ("ARM_ID", 0, 16777216, "whole"),
    1: ("PERIOD", 0.0002, 1, ""),
    2: ("KP", 0, 1000000, ""),
    3: ("KI", 0, 10000000, ""),
    4: ("KD", 0, 1000000, ""),
    5: ("INTEGRAL_LIMIT", 0, 10000, ""),
    6: ("INTEGRAL_DEADBAND", 0, 0.1, ""),
    7: ("NATURAL_FREQUENCY", 0, 10000, ""),
    8: ("DAMPING_RATIO", 0, 10, ""),
    9: ("TORQUE_LIMIT", 0.001, 10000, ""),
    10: ("TORQUE_PER_CODE", 1e-9, 10, "magnitude"),
    11: ("COUNTS_PER_UNIT", 1, 1e9, "magnitude"),
    12: ("RATE_PER_CODE", 1e-9, 1, "magnitude"),
    13: ("COULOMB_POSITIVE", 0, 10000, ""),
    14: ("COULOMB_NEGATIVE", 0, 10000, ""),
    15: ("VISCOUS", 0, 10000, ""),
    16: ("FRICTION_SPEED", 0, 1, ""),
    17: ("POSITION_MIN", -64, 64, ""),
    18: ("POSITION_MAX", -64, 64, ""),
    19: ("SPEED_LIMIT", 0.001, 100, ""),
    20: ("ACCELERATION_LIMIT", 0.001, 10000, ""),
    21: ("COARSE_PER_CODE", 1e-9, 1, "magnitude"),
    22: ("COARSE_ZERO", -64, 64, ""),
    23: ("INDEX_INTERVAL_COUNTS", 1, 16777216, "whole"),
    24: ("HOMING_SPEED", 0.0001, 10, ""),
    25: ("DITHER_FRACTION", 0, 1, ""),
    26: ("DITHER_PERIOD", 0.001, 10, ""),
    27: ("TORQUE_PER_FORCE_CODE", 1e-9, 10, "magnitude"),
    28: ("CLOCK", 0, 2, "whole"),
    29: ("BARRIER", 0.001, 3600, ""),
    30: ("SENSOR_SOURCE", 1, 31, "whole"),
    31: ("KINEMATICS", 0, 15, "whole"),
    32: ("FOLLOWING_ERROR_LIMIT", 0.0001, 0.5, ""),
    33: ("OVERSPEED_LIMIT", 0.001, 150, ""),
    34: ("TACHOMETER_LIMIT", 0.001, 100, ""),
    35: ("CONTINUOUS_TORQUE", 0.001, 10000, ""),
    36: ("OVERLOAD_TIME", 0.001, 60, ""),
    37: ("STALL_TIME", 0.001, 5, ""),
    38: ("STUCK_TIME", 0.001, 1, ""),
    39: ("HOMING_TIME", 0.1, 3600, ""),
    40: ("CURRENT_TOLERANCE", 0.001, 0.25, ""),
    41: ("RATE_ERROR_LIMIT", 0.01, 0.5, ""),
}
"""Name, lowest, highest, kind: whole, of the magnitude, or neither; by number."""
for _link in range(6):
    TABLE[64 + _link] = (f"DH_A_{_link + 1}", -16777216, 16777216, "whole")
    TABLE[70 + _link] = (f"DH_D_{_link + 1}", -16777216, 16777216, "whole")
    TABLE[76 + _link] = (f"DH_ALPHA_{_link + 1}", -3600000, 3600000, "whole")
    TABLE[82 + _link] = (f"DH_OFFSET_{_link + 1}", -3600000, 3600000, "whole")

DEFAULTS: Values = {40: 0.035, 41: 0.2}
"""What holds where a master leaves a parameter out; it needs all others."""

NUMBER = {entry[0]: number for number, entry in TABLE.items()}


def value_is_good(number: int, value: float) -> bool:
    """Whether a value is in its range; the bounds, as they travel, are."""
    _, low, high, kind = TABLE[number]
    if kind == "whole" and value != math.floor(value):
        return False
    if kind == "magnitude":
        value = abs(value)
    return float32(low) <= value <= float32(high)


def hash_of(values: Values) -> int:
    """The hash of a set; 0 would mean no configuration."""
    data = b""
    for number in sorted(values):
        if number not in (CLOCK, BARRIER):
            data += bytes([number]) + struct.pack("<f", values[number])
    return crc16(data) or 1


class Geometry:
    """a2, a3, d4, d (m) of the closed form; ``solvable``: whether it is this one."""

    def __init__(self, values: Values) -> None:
        a, d, alpha, offset = ([values[first + i] for i in range(6)] for first in (64, 70, 76, 82))
        right = [900000, 0, -900000, 900000, -900000, 0]
        zeros = [a[0], d[0], a[3], a[4], a[5], d[4], d[5], *offset]
        self.solvable = alpha == right and not any(zeros) and a[1] > 0 and d[3] > 0
        self.a2 = a[1] / 1e6
        self.a3 = a[2] / 1e6
        self.d4 = d[3] / 1e6
        self.d = d[1] / 1e6 + d[2] / 1e6


class Parameters:
    """The set in force, by name: ``parameters.KP`` and so on."""

    def __init__(self, values: Values) -> None:
        self._by_name = {TABLE[number][0]: value for number, value in values.items()}
        self.geometry = Geometry(values)

    def __getattr__(self, name: str) -> float:
        try:
            return self._by_name[name]
        except KeyError:
            raise AttributeError(name) from None

    @property
    def watch_s(self) -> float:
        """Longest time between two SYNCs, W, s."""
        return self.BARRIER if self.CLOCK == LOCKSTEP else self.PERIOD

    def objection(self, joint: int) -> int:
        """Why a whole set of a joint cannot be taken; TAKEN if it can."""
        if self.SENSOR_SOURCE not in (9, 10 + joint):
            return UNSUPPORTED
        if (
            self.POSITION_MIN > self.POSITION_MAX
            or self.INTEGRAL_LIMIT > self.TORQUE_LIMIT
            or self.CONTINUOUS_TORQUE > self.TORQUE_LIMIT
            or self.HOMING_SPEED > self.SPEED_LIMIT
            or self.OVERSPEED_LIMIT > 1.5 * self.SPEED_LIMIT * (1 + 1e-6)
            or self.TACHOMETER_LIMIT > self.SPEED_LIMIT
        ):
            return REFUSED_VALUE
        solved = self.KINEMATICS == 0 or (self.KINEMATICS == 1 and self.geometry.solvable)
        return TAKEN if solved else UNSUPPORTED


class Configuration:
    """The set of a joint, as far as it has come."""

    def __init__(self, joint: int) -> None:
        self.joint = joint
        self.clear()

    def clear(self) -> None:
        """Hold nothing."""
        self.held: Values = {}  # of the set that is being sent
        self.closed = False  # a COMMIT came since the last parameter
        self.hash = 0  # of the set in force
        self.values: Parameters | None = None  # in force

    def parameter(self, number: int, value: float) -> tuple[int, bool]:
        """Status, and whether the set that was in force is void now."""
        if number not in TABLE:
            return UNKNOWN, False
        if not value_is_good(number, value):
            return REFUSED_VALUE, False
        voided = self.closed
        if self.closed:
            self.clear()
        self.held[number] = value
        return TAKEN, voided

    def forget_open_set(self) -> None:
        """RESET: a set that no COMMIT closed that was taken is cleared."""
        if self.values is None:
            self.clear()

    def commit(self, total: int, its_hash: int) -> tuple[int, bool]:
        """Status, and whether a new set is in force."""
        self.closed = True
        own = hash_of(self.held)
        if (
            total != len(self.held)
            or its_hash != own
            or TABLE.keys() - self.held.keys() - DEFAULTS.keys()
        ):
            return WRONG_HASH, False
        if self.hash == own:
            return TAKEN, False
        new = Parameters({**DEFAULTS, **self.held})
        status = new.objection(self.joint)
        if status != TAKEN:
            return status, False
        self.hash = own
        self.values = new
        return TAKEN, True

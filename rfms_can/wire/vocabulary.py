"""The enumerations of the wire: the DBC's value tables by name. A test holds them against it."""

from enum import IntEnum
from typing import Final


def name_of(kind: type[IntEnum], value: int) -> str:
    """Name of a value that has arrived; its number if only a later version has a name for it."""
    try:
        return kind(value).name
    except ValueError:
        return f"{kind.__name__} {value}"


class NodeState(IntEnum):
    """States of a node, and of the bus as the master runs it."""

    INIT = 0
    PREOP = 1
    HOMING = 2
    READY = 3
    OPERATIONAL = 4
    QUICKSTOP = 5
    FAULT = 6


DRIVEN: Final = frozenset((NodeState.HOMING, NodeState.OPERATIONAL, NodeState.QUICKSTOP))
"""States in which an arm is driven: of a node, and of the master in SYNC."""


class Command(IntEnum):
    """Network management commands."""

    ANNOUNCE = 0
    HOME = 1
    START = 2
    STOP = 3
    RESET = 4
    QUICKSTOP = 5


class FaultCode(IntEnum):
    """Fault of an emergency message (EMCY)."""

    NONE = 0
    SYNC_MISSING = 1
    SETPOINT_MISSING = 2
    MEASURE_MISSING = 3
    ERROR_MISSING = 4
    ROWS_MISSING = 5
    SETPOINT_STEP = 6
    ENCODER_GLITCH = 7
    SOFT_LIMIT = 8
    HARD_LIMIT = 9
    HOMING_FAILED = 10
    DBC_MISMATCH = 11
    EMERGENCY_STOP = 12
    RUNAWAY = 13
    DUPLICATE_NODE = 14
    SENSOR_MISMATCH = 15
    SENSOR_STUCK = 16
    ADC_SATURATED = 17
    AMPLIFIER_FAULT = 18
    OVERSPEED = 19
    FOLLOWING_ERROR = 20
    OVERLOAD = 21
    STALL = 22
    ROWS_IMPLAUSIBLE = 23
    FOREIGN_MASTER = 24
    BAD_FRAMES = 25
    BUS_OFF = 26
    QUEUE_OVERFLOW = 27


class TrajectoryState(IntEnum):
    """State of the trajectory generator (Table 3.3)."""

    IDLE = 0
    LINEAR = 1
    PRE = 2
    START = 3
    BLEND = 4


class Mode(IntEnum):
    """Interpolation of a segment."""

    JOINT = 0
    CARTESIAN = 1


class Blend(IntEnum):
    """Matching polynomial of transitions: what of the old motion it matches."""

    THESIS = 0
    """Position and velocity, by linear extrapolation (3.17 to 3.19, row 3 of Table 3.3)."""
    CONTINUOUS = 1
    """Acceleration and jerk as well; the default."""


class GripperCommand(IntEnum):
    """Command to the gripper."""

    HOLD = 0
    OPEN = 1
    CLOSE = 2


class Law(IntEnum):
    """Control law of a row set."""

    PID = 0
    WEIGHTED = 1


class Parameter(IntEnum):
    """Parameters of a node, by CONFIG number; SI, ``UNIT`` is rad (joint) or m (gripper)."""

    ARM_ID = 0
    PERIOD = 1
    KP = 2
    KI = 3
    KD = 4
    INTEGRAL_LIMIT = 5
    INTEGRAL_DEADBAND = 6
    NATURAL_FREQUENCY = 7
    DAMPING_RATIO = 8
    TORQUE_LIMIT = 9
    TORQUE_PER_CODE = 10
    COUNTS_PER_UNIT = 11
    RATE_PER_CODE = 12
    COULOMB_POSITIVE = 13
    COULOMB_NEGATIVE = 14
    VISCOUS = 15
    FRICTION_SPEED = 16
    POSITION_MIN = 17
    POSITION_MAX = 18
    SPEED_LIMIT = 19
    ACCELERATION_LIMIT = 20
    COARSE_PER_CODE = 21
    COARSE_ZERO = 22
    INDEX_INTERVAL_COUNTS = 23
    HOMING_SPEED = 24
    DITHER_FRACTION = 25
    DITHER_PERIOD = 26
    TORQUE_PER_FORCE_CODE = 27
    CLOCK = 28
    BARRIER = 29
    SENSOR_SOURCE = 30
    KINEMATICS = 31
    FOLLOWING_ERROR_LIMIT = 32
    OVERSPEED_LIMIT = 33
    TACHOMETER_LIMIT = 34
    CONTINUOUS_TORQUE = 35
    OVERLOAD_TIME = 36
    STALL_TIME = 37
    STUCK_TIME = 38
    HOMING_TIME = 39
    CURRENT_TOLERANCE = 40
    RATE_ERROR_LIMIT = 41
    DH_A_1 = 64
    DH_A_2 = 65
    DH_A_3 = 66
    DH_A_4 = 67
    DH_A_5 = 68
    DH_A_6 = 69
    DH_D_1 = 70
    DH_D_2 = 71
    DH_D_3 = 72
    DH_D_4 = 73
    DH_D_5 = 74
    DH_D_6 = 75
    DH_ALPHA_1 = 76
    DH_ALPHA_2 = 77
    DH_ALPHA_3 = 78
    DH_ALPHA_4 = 79
    DH_ALPHA_5 = 80
    DH_ALPHA_6 = 81
    DH_OFFSET_1 = 82
    DH_OFFSET_2 = 83
    DH_OFFSET_3 = 84
    DH_OFFSET_4 = 85
    DH_OFFSET_5 = 86
    DH_OFFSET_6 = 87
    COMMIT = 255


class ConfigStatus(IntEnum):
    """Whether a node accepted a parameter."""

    TAKEN = 0
    UNKNOWN = 1
    REFUSED_STATE = 2
    WRONG_HASH = 3
    REFUSED_VALUE = 4
    UNSUPPORTED = 5

"""The enumerations of the wire: the DBC's value tables by name. A test holds them against it."""

from enum import IntEnum


class NodeState(IntEnum):
    """States of a node, and of the bus as the master runs it."""

    INIT = 0
    PREOP = 1
    HOMING = 2
    READY = 3
    OPERATIONAL = 4
    QUICKSTOP = 5
    FAULT = 6


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
    LOST_FRAME = 1
    SYNC_MISSING = 2
    SETPOINT_MISSING = 3
    MEASURE_MISSING = 4
    ERROR_MISSING = 5
    DAC_MISSING = 6
    REFUSED_FRAMES = 7
    UNREACHABLE = 8
    SETPOINT_STEP = 9
    ENCODER_GLITCH = 10
    ADC_SATURATED = 11
    OVER_TORQUE = 12
    RUNAWAY = 13
    SOFT_LIMIT = 14
    HARD_LIMIT = 15
    HOMING_FAILED = 16
    CONFIG_REFUSED = 17
    DBC_MISMATCH = 18
    FOREIGN_MASTER = 19
    DUPLICATE_NODE = 20
    EMERGENCY_STOP = 21
    NODE_LOST = 22
    NODE_REJOINED = 23
    PLANT_FAILED = 24
    BUS_OFF = 25
    ROWS_MISSING = 26


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
    """Matching polynomial of transitions."""

    THESIS = 0
    CONTINUOUS = 1


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
    DITHER_PART = 25
    DITHER_PERIOD = 26
    TORQUE_PER_FORCE_CODE = 27
    COMMIT = 255


class ConfigStatus(IntEnum):
    """Whether a node accepted a parameter."""

    TAKEN = 0
    UNKNOWN = 1
    REFUSED_STATE = 2
    WRONG_HASH = 3

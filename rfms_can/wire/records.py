"""One typed record for each kind of frame: the DBC's signals, in its order, without the header.

Units and ranges are the DBC's; a test holds names and order against it.
"""

from typing import NamedTuple


class Estop(NamedTuple):
    """Emergency stop: constant payload, any sender, no header."""

    code: int
    inverse: int


class Nmt(NamedTuple):
    """Network management, master to nodes."""

    command: int
    node: int
    argument: int


class Sync(NamedTuple):
    """Start of a cycle."""

    cycle: int
    state: int
    row_set: int
    dbc_hash: int
    reserved: int = 0


class Emcy(NamedTuple):
    """Emergency message of a node."""

    fault: int
    culprit: int
    frame: int
    value: float
    bound: float
    cycle: int
    error_register: int


class Measure(NamedTuple):
    """Encoder and ADCs of one board, sampled at SYNC."""

    counts: int
    current_adc: int
    velocity_adc: int
    cycle: int
    index_seen: int
    braked: int
    board_fault: int = 0


class Force(NamedTuple):
    """Wrist force and torque."""

    f_x: float
    f_y: float
    f_z: float
    m_x: float
    m_y: float
    m_z: float
    cycle: int
    saturated: int = 0


class Setpoint(NamedTuple):
    """Cartesian set-point and the trajectory generator's state."""

    o_x: float
    o_y: float
    o_z: float
    a_x: float
    a_y: float
    a_z: float
    p_x: float
    p_y: float
    p_z: float
    r: float
    blend_p: float
    acceleration_time: float
    state: int
    mode: int
    configuration: int
    blend: int
    cycle: int
    sequence: int
    poses: int
    extras: int
    reserved: int = 0


class Comply(NamedTuple):
    """Joint displacements by compliance."""

    joint_1: float
    joint_2: float
    joint_3: float
    joint_4: float
    joint_5: float
    joint_6: float
    cycle: int


class JointAngles(NamedTuple):
    """Joint angles of one pose, for joints that do not solve theirs from T6."""

    joint_1: float
    joint_2: float
    joint_3: float
    joint_4: float
    joint_5: float
    joint_6: float
    cycle: int
    joints: int


class Bias(NamedTuple):
    """Joint torques of a bias force."""

    torque_1: float
    torque_2: float
    torque_3: float
    torque_4: float
    torque_5: float
    torque_6: float
    cycle: int


class Gripper(NamedTuple):
    """Gripper command."""

    command: int
    force: float
    cycle: int


class Reference(NamedTuple):
    """Coarse position and index latch, while homing."""

    coarse_adc: int
    index_counts: int
    index_valid: int
    cycle: int


class JointError(NamedTuple):
    """A joint's error, its rate, and the desired acceleration."""

    error: float
    error_rate: float
    acceleration: float
    cycle: int


class Dac(NamedTuple):
    """DAC codes of a node for its board."""

    current_dac: int
    force_dac: int
    cycle: int


class Position(NamedTuple):
    """What a node commands a board that closes a position loop of its own."""

    position: float
    speed: float
    torque: float
    cycle: int


class Rows(NamedTuple):
    """Row n of the law and of the joint-space inertia; gravity, what complies."""

    law_1: float
    law_2: float
    law_3: float
    law_4: float
    law_5: float
    law_6: float
    inertia_1: float
    inertia_2: float
    inertia_3: float
    inertia_4: float
    inertia_5: float
    inertia_6: float
    gravity: float
    set: int
    law: int
    damping: float
    selection: int
    specification: int
    reserved: int = 0


class Config(NamedTuple):
    """One parameter of a node."""

    parameter: int
    total: int
    value: float
    hash: int


class ConfigAck(NamedTuple):
    """A node's answer to a parameter."""

    parameter: int
    status: int
    value: float
    hash: int


class Heartbeat(NamedTuple):
    """A node is alive, and how it is."""

    state: int
    bus_offs: int
    error_register: int
    boot_id: int
    dbc_hash: int
    config_hash: int
    discarded: int
    overflows: int

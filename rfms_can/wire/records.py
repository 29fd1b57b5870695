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


class Emcy(NamedTuple):
    """Emergency message of a node."""

    fault: int
    register: int
    value: float
    cycle: int


class Measure(NamedTuple):
    """Encoder and ADCs of one board, sampled at SYNC."""

    counts: int
    current_adc: int
    velocity_adc: int
    cycle: int
    index_seen: int
    braked: int


class Force(NamedTuple):
    """Wrist force and torque."""

    f_x: float
    f_y: float
    f_z: float
    m_x: float
    m_y: float
    m_z: float
    cycle: int


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


class Comply(NamedTuple):
    """Joint displacements by compliance."""

    joint_1: float
    joint_2: float
    joint_3: float
    joint_4: float
    joint_5: float
    joint_6: float
    cycle: int


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


class Rows(NamedTuple):
    """Two rows n of the law: C_theta and M, or M and M C_theta; gravity, what complies."""

    c_1: float
    c_2: float
    c_3: float
    c_4: float
    c_5: float
    c_6: float
    mc_1: float
    mc_2: float
    mc_3: float
    mc_4: float
    mc_5: float
    mc_6: float
    gravity: float
    set: int
    law: int
    damping: float
    selection: int
    specification: int


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
    """Heartbeat: state and health of a node."""

    state: int
    register: int
    boot_id: int
    dbc_hash: int
    config_hash: int
    discarded: int

"""The safety core, file by file, each with the tests that are about it: seconds, the first first.

A test file earns its place by what it kills in seconds: runs of a whole system are not here.
"""

from pathlib import Path
from typing import Final

from node_mutants.mutant import source_of

ROOT: Final = Path(__file__).resolve().parents[2]

_OF_A_JOINT: Final = (
    *("test_joint_node", "test_joint_bounds", "test_joint_trust", "test_joint_guards"),
    *("test_safety_counts", "test_joint_told", "test_joint_stale", "test_joint_duplicate"),
    *("test_joint_between", "test_joint_bus_watch", "test_safety_detectors", "test_joint_sensors"),
    *("test_joint_drive", "test_joint_implausible_rows", "test_joint_stop"),
    *("test_joint_amplifier", "test_joint_faults"),
)
"""A joint node by itself on a bench: what it hears, what it answers, when it stops."""
_OF_ITS_LIFE: Final = (
    *("test_joint_configuration", "test_joint_homing", "test_joint_ladder", "test_joint_states"),
    *("test_safety_boots", "test_safety_edges", "test_joint_controller", "test_joint_robustness"),
)
"""Its bring-up, its states, and random lives of it."""

CORE: Final[dict[str, tuple[str, ...]]] = {
    "joint_nodes/ladder.py": ("test_safety_tables", "test_joint_ladder", "test_joint_faults"),
    "joint_nodes/states.py": ("test_safety_tables", "test_joint_states"),
    "joint_nodes/state_actions.py": ("test_safety_tables", "test_joint_state_actions"),
    "joint_nodes/stop_ramp.py": (
        *("test_joint_stop_ramp", "test_joint_stop", "test_joint_guards", "test_safety_tables"),
        *("test_joint_bounds", "test_safety_stop"),
    ),
    "joint_nodes/motion_watch.py": (
        *("test_joint_drive", "test_joint_runaway", "test_joint_stop", "test_safety_detectors"),
        *("test_joint_guards", "test_joint_bounds"),
    ),
    "joint_nodes/sensing.py": (
        *("test_joint_sensors", "test_joint_bounds", "test_joint_amplifier", "test_joint_guards"),
        *("test_safety_tables", "test_safety_detectors", "test_joint_drive", "test_joint_ladder"),
        *("test_joint_homing", "test_joint_faults", "test_joint_node"),
    ),
    "joint_nodes/detectors/bus.py": (
        *("test_joint_bus_watch", "test_safety_tables", "test_safety_detectors"),
    ),
    "joint_nodes/detectors/drive.py": (
        *("test_joint_amplifier", "test_joint_drive", "test_safety_tables"),
        "test_safety_detectors",
    ),
    "joint_nodes/detectors/following.py": (
        *("test_joint_drive", "test_joint_stop", "test_safety_detectors"),
    ),
    "joint_nodes/detectors/plausible_rows.py": (
        *("test_joint_implausible_rows", "test_safety_tables", "test_safety_detectors"),
    ),
    "joint_nodes/detectors/runaway.py": (
        *("test_joint_runaway", "test_safety_tables", "test_joint_guards", "test_safety_edges"),
    ),
    "joint_nodes/detectors/sensors.py": (
        *("test_joint_sensors", "test_safety_tables", "test_safety_detectors", "test_safety_edges"),
    ),
    "joint_nodes/detectors/setpoint_step.py": (
        *("test_joint_bounds", "test_joint_told", "test_safety_tables", "test_joint_guards"),
        "test_safety_detectors",
    ),
    "joint_nodes/controller.py": (
        *(*_OF_A_JOINT, "test_safety_tables", "test_joint_runaway", "test_joint_ladder"),
        *("test_joint_controller", "test_joint_compliance", "test_joint_homing"),
        "test_joint_robustness",
    ),
    "joint_nodes/field_node.py": (*_OF_A_JOINT, *_OF_ITS_LIFE, "test_port_counts"),
    "joint_nodes/inputs.py": (*_OF_A_JOINT, "test_joint_compliance"),
    "joint_nodes/joint.py": (*_OF_A_JOINT, "test_joint_compliance", "test_joint_robustness"),
    "kinematics/limits.py": (
        *("test_kinematics_limits", "test_kinematics_joint_solver"),
        "test_joint_guards",
    ),
    "master/blame.py": ("test_safety_blame", "test_master_faults"),
    "master/corruption.py": ("test_master_watches", "test_safety_blame", "test_safety_tables"),
    "master/lateness.py": ("test_master_watches", "test_safety_blame", "test_safety_tables"),
    "master/own_frames.py": ("test_master_watches", "test_safety_blame", "test_safety_tables"),
    "master/traffic.py": ("test_master_watches", "test_safety_blame", "test_safety_tables"),
    "master/verification.py": (
        *("test_safety_counts", "test_verification_named", "test_safety_edges"),
        "test_master_verification",
    ),
    "node/encoder_reference.py": ("test_joint_homing", "test_gripper_node"),
    "node/endpoint.py": (*_OF_A_JOINT, *_OF_ITS_LIFE, "test_port_counts", "test_plant_node"),
    "node/port_counts.py": (
        *("test_safety_counts", "test_safety_tables", "test_safety_edges", "test_port_counts"),
    ),
    "plant/board.py": ("test_plant_board", "test_safety_counts"),
    "plant/brake_watchdog.py": ("test_plant_brake_watchdog", "test_joint_guards"),
    "wire/codec.py": (
        *("test_safety_counts", "test_wire_codec", "test_wire_contract"),
        "test_wire_layout",
    ),
    "wire/protection.py": (
        *("test_wire_protection", "test_safety_counts", "test_wire_bit_errors"),
        "test_joint_trust",
    ),
}
"""Files under ``rfms_can/``, and files under ``tests/`` without their ``.py``."""

FOLDER: Final = "joint_nodes"
"""Every file of this folder is in ``CORE``, or here with what it does instead of guarding."""

NOT_CORE: Final[dict[str, str]] = {
    "joint_nodes/__init__.py": "no code",
    "joint_nodes/angle_solver.py": "inverse kinematics",
    "joint_nodes/detectors/__init__.py": "no code",
    "joint_nodes/compliance.py": "rows of the law",
    "joint_nodes/friction.py": "the servo's friction torque",
    "joint_nodes/gripper.py": "the gripper's drive",
    "joint_nodes/homing.py": "the search for the index",
    "joint_nodes/servo.py": "the torque of the law",
}

LEFT_OUT: Final[dict[str, frozenset[str]]] = {
    "joint_nodes/controller.py": frozenset({"record_terms"}),
    "joint_nodes/joint.py": frozenset({"record_terms"}),
}
"""Functions without mutants: they record what happened, for tools."""


def path_of_test(name: str) -> Path:
    """Of a test file."""
    return ROOT / "tests" / f"{name}.py"


def tests_of(file: str) -> str:
    """The text of all tests of a file of the core."""
    return "\n".join(path_of_test(name).read_text(encoding="utf-8") for name in CORE[file])


def code_of(file: str) -> str:
    """The text of a file of the core."""
    return source_of(file)

"""The faults that exist are those that a node raises and a test provokes."""

import ast
from pathlib import Path
from typing import Final

import pytest

from rfms_can.joint_nodes.ladder import LADDERS
from rfms_can.tables import complete
from rfms_can.wire.vocabulary import FaultCode

TESTS: Final = Path(__file__).parent
PACKAGE: Final = TESTS.parent / "rfms_can"

LADDER: Final = "test_joint_ladder.py"
BOUNDS: Final = "test_joint_bounds.py"
HOMING: Final = "test_joint_homing.py"
NODE: Final = "test_joint_node.py"
RUNAWAY: Final = "test_joint_runaway.py"
DUPLICATE: Final = "test_joint_duplicate.py"
SENSORS: Final = "test_joint_sensors.py"
AMPLIFIER: Final = "test_joint_amplifier.py"
DRIVE: Final = "test_joint_drive.py"
ROWS: Final = "test_joint_implausible_rows.py"
BUS: Final = "test_joint_bus_watch.py"

F = FaultCode
PROVOKED: Final[dict[FaultCode, tuple[str, str]]] = complete(
    {
        F.SYNC_MISSING: (LADDER, "test_the_third_missing_sync_stops_the_joint_and_says_so_once"),
        F.SETPOINT_MISSING: (LADDER, "test_missing_setpoints_hold_then_stop"),
        F.MEASURE_MISSING: (LADDER, "test_three_missing_measurements_end_torque"),
        F.ERROR_MISSING: (LADDER, "test_three_missing_errors_of_another_joint_stop_this_one"),
        F.ROWS_MISSING: (
            LADDER,
            "test_a_row_set_that_is_named_but_not_here_stops_the_joint_in_three_cycles",
        ),
        F.SETPOINT_STEP: (
            BOUNDS,
            "test_a_setpoint_step_beyond_the_speed_limit_is_refused_and_stops_the_joint",
        ),
        F.ENCODER_GLITCH: (
            BOUNDS,
            "test_an_encoder_that_stays_elsewhere_stops_the_joint_where_it_is",
        ),
        F.SOFT_LIMIT: (BOUNDS, "test_too_fast_towards_the_end_of_the_range_stops_in_time"),
        F.HARD_LIMIT: (BOUNDS, "test_beyond_the_range_torque_goes_off"),
        F.HOMING_FAILED: (
            HOMING,
            "test_wrong_potentiometer_fails_homing_and_keeps_the_arm_disabled",
        ),
        F.DBC_MISMATCH: (NODE, "test_a_master_with_another_dbc_ends_torque_at_once"),
        F.EMERGENCY_STOP: (NODE, "test_emergency_stop_ends_torque_at_once"),
        F.RUNAWAY: (RUNAWAY, "test_a_motor_that_drives_away_loses_its_torque_within_five_cycles"),
        F.DUPLICATE_NODE: (DUPLICATE, "test_a_second_node_of_its_number_stops_a_joint_in_motion"),
        F.SENSOR_MISMATCH: (SENSORS, "test_sensors_that_contradict_each_other_end_torque"),
        F.SENSOR_STUCK: (
            SENSORS,
            "test_a_tachometer_that_sticks_is_found_when_the_joint_slows_down",
        ),
        F.ADC_SATURATED: (
            SENSORS,
            "test_a_velocity_converter_at_its_rail_is_replaced_by_the_encoder_then_damps",
        ),
        F.AMPLIFIER_FAULT: (
            AMPLIFIER,
            "test_an_amplifier_that_sticks_ends_torque_in_its_second_cycle",
        ),
        F.OVERSPEED: (DRIVE, "test_a_joint_that_is_too_fast_for_two_cycles_loses_its_torque"),
        F.FOLLOWING_ERROR: (
            DRIVE,
            "test_a_joint_that_is_faster_than_it_is_told_loses_its_torque_in_two_cycles",
        ),
        F.OVERLOAD: (DRIVE, "test_a_joint_that_carries_too_much_is_damped_also_after_reset"),
        F.STALL: (DRIVE, "test_a_joint_that_pushes_and_does_not_turn_is_damped"),
        F.ROWS_IMPLAUSIBLE: (ROWS, "test_three_syncs_that_name_such_rows_stop_the_joint"),
        F.FOREIGN_MASTER: (BUS, "test_a_heartbeat_of_a_second_master_stops_the_joint"),
        F.BAD_FRAMES: (BUS, "test_three_bad_frames_in_ten_cycles_stop_the_joint"),
        F.BUS_OFF: (BUS, "test_a_controller_that_was_off_the_bus_damps_the_joint"),
        F.QUEUE_OVERFLOW: (BUS, "test_frames_lost_in_three_cycles_in_a_row_stop_the_joint"),
    },
    LADDERS,
)
"""The test that provokes each fault and reads it in the node's EMCY."""


def faults_in(tree: ast.AST) -> set[str]:
    """Members of FaultCode that are named in a piece of code."""
    return {
        node.attr
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute)
        and isinstance(node.value, ast.Name)
        and node.value.id == "FaultCode"
    }


def names_in(tree: ast.Module) -> dict[str, set[str]]:
    """Names that a module has for members of FaultCode."""
    return {
        statement.target.id: faults_in(statement.value)
        for statement in tree.body
        if isinstance(statement, ast.AnnAssign)
        and isinstance(statement.target, ast.Name)
        and isinstance(statement.value, ast.Attribute)
    }


def raised() -> set[str]:
    """Faults that a node passes to its ladder, or to what does so."""
    found = set()
    for path in PACKAGE.rglob("*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        names = names_in(tree)
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and ast.unparse(node.func).endswith((".miss", ".trip")):
                for argument in node.args:
                    found |= faults_in(argument) | names.get(ast.unparse(argument), set())
    return found


def test_a_node_raises_every_fault() -> None:
    never = {fault.name for fault in LADDERS} - raised()
    assert never == set(), "no node raises it: raise it, or take it out of the vocabulary"


@pytest.mark.parametrize("fault", PROVOKED, ids=lambda fault: fault.name)
def test_a_test_provokes_every_fault_and_reads_its_code(fault: FaultCode) -> None:
    file, name = PROVOKED[fault]
    functions = [
        node
        for node in ast.parse((TESTS / file).read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef) and node.name == name
    ]
    assert functions, f"{file} has no {name}"
    assert fault.name in faults_in(functions[0]), f"{name} does not read FaultCode.{fault.name}"

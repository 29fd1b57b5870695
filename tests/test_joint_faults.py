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


def raised() -> set[str]:
    """Faults that a node passes to its ladder, or to what does so."""
    found = set()
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and ast.unparse(node.func).endswith(
                (".miss", ".trip", "._leave_range")
            ):
                found |= faults_in(ast.Module([ast.Expr(arg) for arg in node.args], []))
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

"""Faults of processes on a real vcan0: a full socket, a link that goes down."""

import pytest

from rfms_can.cli.app import main
from rfms_can.faults.processes.trial import made
from rfms_can.faults.trial import Trial

pytestmark = pytest.mark.vcan

RACES = ("brakes of joints that are sound", "asks for torque after its brake")
"""A halted master waits for no joint: one that is late is braked, now and then (docs/faults.md)."""


@pytest.mark.parametrize(
    ("row", "name", "told"),
    [
        (17, "no_room_to_send", "joint"),
        (15, "cut_bus", "socketcan:vcan0 has gone (Network is down)"),
    ],
)
def test_a_fault_of_processes_is_found_named_and_survived(row: int, name: str, told: str) -> None:
    result = made(Trial(row, name, "puma260", 0), "socketcan:vcan0", main)
    facts = result.facts
    assert facts is not None, result.problems
    problems = [why for told in result.problems for why in told.split("; ")]
    assert [why for why in problems if not any(race in why for race in RACES)] == []
    assert told in facts.told
    assert facts.left == []

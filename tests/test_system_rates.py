"""Every rate the plant names is one the arm can be run at; and what a run says that broke off."""

import json
from pathlib import Path

import pytest
from support.system import SHORT

from rfms_can.coordinator import Arm
from rfms_can.errors import ProgramError
from rfms_can.rig.program import load_program
from rfms_can.rig.runner import execute
from rfms_can.rig.settings import RunSettings

pytestmark = pytest.mark.system


@pytest.mark.parametrize("arm", ["puma260", "puma560"])
@pytest.mark.parametrize("rate", [50.0, 100.0, 125.0, 200.0])
def test_slower_rates_run_without_a_fault(arm: str, rate: float) -> None:
    outcome = execute(load_program(SHORT), RunSettings(arm=arm, rate=rate))
    assert outcome.fault is None
    assert outcome.result.incomplete == 0
    assert max(joint.moving_max for joint in outcome.result.joints) < 0.015


def test_the_summary_says_why_a_program_ended_early(tmp_path: Path) -> None:
    def program(arm: Arm) -> None:
        arm.move("nowhere", "somehow")

    with pytest.raises(ProgramError):
        execute(program, RunSettings(), record=tmp_path)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["fault"] is None
    assert summary["error"] == "ProgramError: position 'nowhere' is not defined; there are: none"

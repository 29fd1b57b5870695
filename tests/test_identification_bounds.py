"""Experiments run without a model: the errors that leaves are no fault, on either arm."""

from pathlib import Path

import pytest

from rfms_can.arm import PUMA_260
from rfms_can.identification.experiments.plan import experiments
from rfms_can.identification.experiments.procedure import run_one, tasks_of
from rfms_can.rig.settings import RunSettings

pytestmark = pytest.mark.system

BURSTS = [each for each in experiments(PUMA_260) if each.name == "burst-1-load"]


@pytest.mark.parametrize("plant", ["nominal", "worn:0"])
def test_bursts_of_a_small_arm_are_no_fault(plant: str, tmp_path: Path) -> None:
    """Joint 1 follows by 0.04 rad there: more than an arm with a model may be off."""
    (task,) = tasks_of(BURSTS, RunSettings(arm="puma260", plant=plant), tmp_path)
    assert len(run_one(task).marks) == 6


def test_a_bound_of_the_users_own_is_kept(tmp_path: Path) -> None:
    (task,) = tasks_of(BURSTS, RunSettings(arm="puma260", following_error=0.2), tmp_path)
    assert task.settings.following_error == 0.2

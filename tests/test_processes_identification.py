"""Probe and experiments over a bus of processes: the same data as on the simulated bus."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rfms_can.identification.experiments.actions import Burst, Pose
from rfms_can.identification.experiments.plan import Experiment
from rfms_can.identification.experiments.probing import WiringError, probe, require_sound
from rfms_can.identification.experiments.procedure import run_one, tasks_of
from rfms_can.rig.settings import RunSettings

pytestmark = pytest.mark.processes

POSE: Pose = (0.1, 1.4, -3.3, 0.1, -1.25, 0.1)
SETTINGS = RunSettings(arm="puma560", plant="table41")


def hub() -> RunSettings:
    return replace(SETTINGS, bus=f"hub:identify-{os.getpid()}", clock="lockstep")


def test_the_probe_finds_the_same_joint_on_a_hub() -> None:
    require_sound(probe(hub()))
    with pytest.raises(WiringError, match=r"^joint 2: its encoder counts backwards"):
        require_sound(probe(replace(hub(), plant="perturbed:2")))


def test_an_experiment_brings_the_same_data_on_a_hub(tmp_path: Path) -> None:
    short = Experiment("short", True, (Burst(4, POSE, 0.3, 1),))
    tables = []
    for settings in (SETTINGS, hub()):
        (task,) = tasks_of([short], settings, tmp_path)
        data = run_one(task)
        tables.append(data.table)
        assert [mark.joint for mark in data.marks] == [4, 4]
    ours, theirs = tables
    rows = min(len(ours), len(theirs))
    assert rows > 100
    np.testing.assert_array_equal(ours[: rows - 2], theirs[: rows - 2])

"""A run in a scene: what a program meets without knowing, and what the run tells of it."""

import csv
import json
import math
from collections.abc import Callable
from pathlib import Path

import pytest
from pytest import approx

from rfms_can.bus.budget import Cycle, budget
from rfms_can.bus.timing import BusTiming
from rfms_can.coordinator import Arm, Transform
from rfms_can.plant.scene.catalogue import SCENES, scene_from
from rfms_can.plant.scene.surface import SURFACE
from rfms_can.rig.runner import bus_bound, execute
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig

DOWN = Transform.rotation((0.0, 1.0, 0.0), math.pi)
TIP = Transform.translation(0.0, 0.0, 0.160)


def touching(depth: float) -> Callable[[Arm], None]:
    """Down to ``depth`` under where the plate should be (m), without complying."""

    def program(arm: Arm) -> None:
        tip = arm.transform("tip", TIP)
        plate = arm.transform("plate", SURFACE @ DOWN)
        above = arm.transform("above", Transform.translation(0.0, 0.0, -0.01))
        below = arm.transform("below", Transform.translation(0.0, 0.0, depth))
        far = arm.mode("far", segment_time=1.2, acceleration_time=0.3)
        slow = arm.mode("slow", segment_time=0.8, acceleration_time=0.2, interpolation="cartesian")
        arm.move(arm.position("above the plate", arm.t6 @ tip == plate @ above), far)
        arm.wait(arm.move(arm.position("on the plate", arm.t6 @ tip == plate @ below), slow))

    return program


def settings(scene: str, sensor: str = "none") -> RunSettings:
    return RunSettings(arm="puma560", scene=scene, sensor=sensor)


@pytest.mark.system
def test_a_plate_higher_than_a_program_thinks_is_met_and_reported(tmp_path: Path) -> None:
    outcome = execute(
        touching(0.002), settings("surface:z_mm=0.2", "ideal"), record=tmp_path / "met"
    )
    scene = outcome.result.scene
    assert outcome.fault is None and scene is not None
    assert outcome.result.bus_load is not None and outcome.result.bus_bound is not None
    assert 0.8 * outcome.result.bus_bound < outcome.result.bus_load < outcome.result.bus_bound
    assert scene.touching and scene.contact_cycles > 10
    assert scene.largest_axial > 5.0
    assert scene.largest_lateral <= 0.2 * scene.largest_axial * 1.02
    assert scene.tip[2] == approx(-scene.largest_depth, abs=2e-6)
    rows = list(csv.DictReader((tmp_path / "met" / "truth.csv").open()))
    assert [int(row["cycle"]) for row in rows] == sorted({int(row["cycle"]) for row in rows})
    assert max(float(row["depth"]) for row in rows) == scene.largest_depth
    told = json.loads((tmp_path / "met" / "summary.json").read_text())
    assert told["scene"]["contact_cycles"] == scene.contact_cycles
    recorded = json.loads((tmp_path / "met" / "settings.json").read_text())["settings"]
    assert (recorded["scene"], recorded["sensor"]) == ("surface:z_mm=0.2", "ideal")


@pytest.mark.system
def test_a_plate_out_of_the_way_is_not_met(tmp_path: Path) -> None:
    result = execute(touching(0.0), settings("surface:z_mm=-1")).result
    assert result.scene is not None
    assert (result.scene.contact_cycles, result.scene.largest_force) == (0, 0.0)
    assert not result.scene.touching
    assert result.scene.lowest == approx(1e-3, abs=2e-4)


def test_the_bus_is_bounded_with_what_a_scene_and_a_sensor_put_on_it() -> None:
    free, sensed, scene, both = (
        bus_bound(settings(*words))
        for words in (("free",), ("free", "good"), ("peg",), ("peg", "good"))
    )
    assert free < sensed < scene < both
    assert both - scene == approx(sensed - free)
    timing = BusTiming(1_000_000, 5_000_000)
    full = budget(250.0, timing, cycle=Cycle.FULL)
    second = sum(r.wire_ns for r in full.responses if r.stream.name == "SETPOINT_2")
    assert both == approx(full.load - second * 250e-9)


def test_without_a_scene_nothing_is_watched() -> None:
    assert SimulatedRig(RunSettings()).scene is None


@pytest.mark.parametrize("name", SCENES)
def test_every_scene_stands_clear_of_the_parked_arm(name: str) -> None:
    rig = SimulatedRig(settings(name))
    assert rig.plant.physics.contacts == 0
    assert rig.plant.physics.model.clearance() > 0.02


def test_every_key_at_its_bounds_makes_a_scene() -> None:
    for name, entry in SCENES.items():
        for bound in ("minimum", "maximum"):
            pairs = ",".join(f"{key.name}={getattr(key, bound)}" for key in entry.keys)
            scene_from(f"{name}:{pairs}", "puma560")

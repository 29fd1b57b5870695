"""What tasks in contact come to, by the plant's truth: a surface, a peg, and the examples.

Forces are means of a control period. The arm has the thesis' friction, 14 N m in joint 1.
"""

import math
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import pytest
from example_run import EXAMPLES, example

from rfms_can.analysis.campaign.insertion import insert
from rfms_can.analysis.campaign.job import Group, Insertion, Job
from rfms_can.coordinator import Arm, Transform
from rfms_can.rig.runner import execute
from rfms_can.rig.session import Program, Rig
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig

pytestmark = pytest.mark.system

BIAS = 20.0
THESIS_FORCE, THESIS_MOMENT = 6.7, 0.28
"""A pound and a half, N; two and a half pound inches, N m (V.5)."""


class Met(NamedTuple):
    """What the tool did to the surface while it moved, and at rest after it."""

    moving: npt.NDArray[np.float64]
    moment: npt.NDArray[np.float64]
    resting: npt.NDArray[np.float64]
    lost: int


def follow(arm: Arm) -> None:
    """Touch the plate, press on it, go 100 mm along it at 50 mm/s, and rest."""
    tip = arm.transform("tip", Transform.translation(0.0, 0.0, 0.16))
    down = Transform.rotation((0.0, 1.0, 0.0), math.pi)
    plate = arm.transform("plate", Transform.translation(0.6, 0.15, 0.0) @ down)

    def at(name: str, x: float, z: float) -> str:
        place = arm.transform(name, Transform.translation(x, 0.0, z))
        return arm.position(f"at {name}", arm.t6 @ tip == plate @ place, tool=tip)

    above, below = at("above", 0.05, -0.02), at("below", 0.05, 0.01)
    start, end = at("start", 0.05, 0.0), at("end", -0.05, 0.0)
    go = arm.mode(
        "go",
        segment_time=1.5,
        acceleration_time=0.3,
        mass=0.388,
        mass_centre=(0.0, 0.0, 0.0896),
    )
    touch = arm.mode(
        "touch",
        speed=0.02,
        acceleration_time=0.05,
        interpolation="cartesian",
        stop_on_force={"fz": 5.0},
    )
    press = arm.mode(
        "press",
        segment_time=0.5,
        acceleration_time=0.1,
        interpolation="cartesian",
        comply={"fz": BIAS},
    )
    slide = arm.mode(
        "slide",
        speed=0.05,
        acceleration_time=0.2,
        interpolation="cartesian",
        comply={"fz": BIAS},
    )
    arm.wait(arm.move(above, go))
    arm.tare()
    arm.wait(arm.move(below, touch))
    assert arm.guard is not None and "fz" in arm.guard
    arm.wait(arm.move(start, press))
    arm.sleep(0.5)
    arm.wait(arm.move(end, slide))
    arm.sleep(1.0)


def rig_of(program: Program, settings: RunSettings) -> SimulatedRig:
    """Run, and keep the plant's truth."""
    rigs: list[SimulatedRig] = []

    def watch(rig: Rig) -> None:
        assert isinstance(rig, SimulatedRig) and rig.watch is not None
        rig.watch.keep = True
        rigs.append(rig)

    assert execute(program, settings, watch=watch).fault is None
    return rigs[0]


@cache
def met(loop: str) -> Met:
    settings = RunSettings(
        arm="puma560", scene="surface", friction="thesis", sensor="good", force_loop=loop
    )
    watch = rig_of(follow, settings).watch
    assert watch is not None
    rows = watch.rows
    force = np.array([row.contact.force for row in rows])
    moment = np.array([row.contact.torque for row in rows])
    speed = np.abs(np.gradient([row.tip.px for row in rows])) / 0.004
    touching = force[:, 2] != 0.0
    first = int(np.argmax(touching))
    moving = speed > 0.045
    moving[: first + 200] = False
    return Met(-force[moving, 2], moment[moving], -force[-200:, 2], int((~touching[first:]).sum()))


def rms(values: npt.NDArray[np.float64]) -> float:
    return float(np.sqrt((values * values).mean()))


def test_closed_loop_the_force_is_kept_within_2_n_moving_and_1_n_at_rest() -> None:
    found = met("closed")
    assert found.lost == 0
    assert len(found.moving) > 300
    assert rms(found.moving - BIAS) < 2.0
    assert rms(found.resting - BIAS) < 1.0


def test_open_loop_a_moving_arm_is_within_the_thesis_bounds() -> None:
    found = met("open")
    assert found.lost == 0
    assert np.abs(found.moving - BIAS).max() < THESIS_FORCE
    assert np.abs(found.moment).max() < THESIS_MOMENT


@cache
def peg(law: str, seed: int) -> Insertion:
    program: Path = EXAMPLES / "peg_in_hole.py"
    return insert(Job(Group(law, "open", "thesis", 1.0, 0.5), seed, 0.9), program)


@pytest.mark.parametrize("seed", range(3))
def test_a_peg_goes_in_open_loop_with_half_the_force_of_position_control(seed: int) -> None:
    complying, rigid = peg("weighted", seed), peg("position", seed)
    assert complying.inserted, complying.why
    assert complying.lateral_peak < 40.0
    assert complying.lateral_mean < 0.5 * rigid.lateral_mean


@pytest.mark.parametrize(
    ("name", "scene"),
    [("touch", "surface"), ("follow_surface", "curved"), ("trace_corner", "corner")],
)
def test_the_examples_in_contact_end_without_a_fault(name: str, scene: str) -> None:
    settings = RunSettings(arm="puma560", scene=scene, friction="thesis", sensor="good")
    watch = rig_of(example(name).program, settings).watch
    assert watch is not None
    assert sum(row.contact.points > 0 for row in watch.rows) > 200

"""What is spared is not missed: hidden fixtures and long steps change only the time taken."""

import math

import numpy as np
import pytest
from support.scene import SceneBench

from rfms_can.arm import JOINT_COUNT, PUMA_560
from rfms_can.plant.contact_wrench import Contacts
from rfms_can.plant.physics import MAX_TIP_SPEED, PlantPhysics
from rfms_can.plant.scene.catalogue import scene_from
from rfms_can.plant.scene.peg_in_hole import HOLE
from rfms_can.transform import Transform

DOWN = Transform.rotation((0.0, 1.0, 0.0), math.pi)
ZERO = (0,) * JOINT_COUNT


def insertion(bench: SceneBench) -> list[tuple[list[float], Contacts]]:
    """Down the chamfer and into the hole, complying sideways: all that is seen on the way."""
    seen: list[tuple[list[float], Contacts]] = []
    for k in range(150):
        bench.control(
            HOLE @ Transform.translation(0.0, 0.0, 0.001 - 0.015 * k / 150) @ DOWN,
            1e-3,
            comply=(0, 1, 3, 4),
            each=lambda: seen.append((bench.model.q[:], bench.model.contact_force())),
        )
    return seen


@pytest.mark.parametrize("friction", ["none", "thesis"])
def test_hidden_fixtures_change_no_bit_of_an_insertion(friction: str) -> None:
    runs = []
    for hides in (True, False):
        bench = SceneBench("peg:x_mm=0.8,y_mm=-0.5,tilt_x_deg=0.5", friction)
        bench.put(HOLE @ Transform.translation(0.0, 0.0, 0.001) @ DOWN)
        if not hides:
            bench.model.disable_broad_phase()
        runs.append(insertion(bench))
    assert runs[0] == runs[1]
    assert max(contact.points for _, contact in runs[0]) >= 2


def test_most_of_the_hole_is_hidden_from_a_peg_that_leans_on_one_side() -> None:
    bench = SceneBench("peg:x_mm=0.2")
    bench.put(HOLE @ Transform.translation(0.0, 0.0, -0.03) @ DOWN)
    model, _ = bench.model.engine
    shown = np.flatnonzero(model.pair_margin > 0.0)
    assert 0 < len(shown) < 0.3 * model.npair
    # every second pair is a wall; the hole lies off along +x, so the peg leans on the wall at -x
    half = model.npair // 2
    assert all(abs(pair // 2 - half // 2) < half // 4 for pair in shown)


@pytest.mark.parametrize("scene", ["surface", "peg"])
def test_steps_are_short_only_where_the_tool_may_touch_something(scene: str) -> None:
    near = MAX_TIP_SPEED / 250.0
    for height, step_s in ((near + 0.08, 1e-3), (0.002, 2.5e-4)):
        tip = HOLE @ Transform.translation(0.0, 0.0, height) @ DOWN
        q = SceneBench(scene).solve(tip)
        built = scene_from(scene, "puma560")
        plant = PlantPhysics(PUMA_560, "corke", 250.0, initial_q=q, scene=built)
        plant.step_period(ZERO, ZERO, (True,) * JOINT_COUNT)
        model, data = plant.model.engine
        assert model.opt.timestep == step_s
        assert data.time == pytest.approx(0.004)


def test_an_arm_at_rest_keeps_resting_when_steps_grow_short() -> None:
    """The drives hold gravity; what friction holds besides it goes on holding."""
    bench = SceneBench("surface", "thesis")
    bench.put(HOLE @ Transform.translation(0.0, 0.0, 0.05) @ DOWN)
    torque, q = [0.97 * t for t in bench.holding()], bench.model.q[:]
    for step_s in (2.5e-4, 1e-3, 2.5e-4):
        bench.model.set_step(step_s)
        bench.model.step(torque, steps=20)
        assert bench.model.q == q

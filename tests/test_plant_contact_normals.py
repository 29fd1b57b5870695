"""Where two shapes touch, and which way they push: exact, to some nanometres."""

import itertools
import math
from collections.abc import Iterator
from random import Random
from typing import Any

import mujoco
import numpy as np
import pytest
from pytest import approx
from support.scene import Floats, SceneBench

from rfms_can.plant.contact import CONTACT_DISTANCE, SKIN
from rfms_can.plant.scene.corner import CORNER
from rfms_can.plant.scene.curved import CROWN
from rfms_can.plant.scene.peg_in_hole import HOLE, PegInHole
from rfms_can.plant.scene.surface import SURFACE
from rfms_can.transform import Transform

PEG = PegInHole()
DOWN = Transform.rotation((0.0, 1.0, 0.0), math.pi)
BOX = mujoco.mjtGeom.mjGEOM_BOX
FACET = math.tau / PEG.facets
CONE = -PEG.chamfer + SKIN, -SKIN
"""Heights between which the chamfer is a cone: below and above it is rounded."""


class Touch:
    """One contact of the peg: its normal, from the box it is with towards the peg."""

    def __init__(self, bench: SceneBench, contact: Any) -> None:
        self.model, self.data = bench.model.engine
        first, second = contact.geom
        swapped = self.model.geom_type[second] == BOX
        self.peg, self.box = (first, second) if swapped else (second, first)
        self.normal: Floats = contact.frame[:3] * (-1.0 if swapped else 1.0)
        self.dist = float(contact.dist)
        turn = np.array(HOLE.rows())
        self.point: Floats = turn[:, :3].T @ (contact.pos - turn[:, 3])
        self.seen: Floats = turn[:, :3].T @ self.normal

    @property
    def face(self) -> Floats:
        """Out of the face of the box that looks at the hole."""
        face: Floats = -self.data.geom_xmat[self.box].reshape(3, 3)[:, 0]
        return face

    def gap(self) -> float:
        """Of the slab across the normal between the two shapes: no distance is shorter."""
        data, model, n = self.data, self.model, self.normal
        along = float(n @ data.geom_xmat[self.peg].reshape(3, 3)[:, 2])
        radius, half, _ = model.geom_size[self.peg]
        peg = half * abs(along) + radius * math.sqrt(max(0.0, 1.0 - along**2))
        box = np.abs(n @ data.geom_xmat[self.box].reshape(3, 3)) @ model.geom_size[self.box]
        between = data.geom_xpos[self.peg] - data.geom_xpos[self.box]
        return float(n @ between - peg - box)


def touches(bench: SceneBench) -> list[Touch]:
    """The nearest contact of every pair, as MuJoCo finds it now."""
    model, data = bench.model.engine
    mujoco.mj_collision(model, data)
    found: dict[int, Touch] = {}
    for contact in data.contact:
        touch = Touch(bench, contact)
        if touch.box not in found or touch.dist < found[touch.box].dist:
            found[touch.box] = touch
    return list(found.values())


@pytest.fixture(scope="module")
def hole() -> SceneBench:
    bench = SceneBench("peg")
    bench.model.disable_broad_phase()
    return bench


def sweep(bench: SceneBench, heights: tuple[float, float], reach: float) -> Iterator[list[Touch]]:
    """The peg leaning on the hole on all sides, 10 micrometres to some picometres deep."""
    dice = Random(1)
    for side, tilt in itertools.product(range(24), (0.0, 1e-6, -1e-4, 0.05, -0.5, 0.5)):
        about = side * FACET / 2.0 if side % 2 else dice.uniform(0.0, math.tau)
        axis = about + math.pi / 2.0 * dice.randrange(4)
        height = dice.uniform(*heights)
        lean = Transform.rotation((math.cos(axis), math.sin(axis), 0.0), math.radians(tilt))
        offset = reach + max(height + PEG.chamfer, 0.0)
        x, y = offset * math.cos(about), offset * math.sin(about)
        bench.put(HOLE @ Transform.translation(x, y, height) @ lean @ DOWN)
        first = touches(bench)
        yield first
        if first:  # out again along the deepest, to where it hardly touches
            deepest = min(first, key=lambda touch: touch.dist)
            _, data = bench.model.engine
            at = data.geom_xpos[deepest.peg].copy()
            for depth in (1e-5, 1e-6, 2e-8, 5e-9, 1e-9, 3e-10, 1e-11):
                data.geom_xpos[deepest.peg] = at + deepest.normal * (
                    CONTACT_DISTANCE - deepest.dist - depth
                )
                yield touches(bench)


@pytest.mark.parametrize("heights", [(-0.04, -0.006), (-0.0032, 0.0002)], ids=["bore", "chamfer"])
def test_no_contact_points_but_where_the_two_are_nearest(
    hole: SceneBench, heights: tuple[float, float]
) -> None:
    """The way apart that a contact names is the shortest: edges, faces, and what just touches.

    Of a side that leans on a face by half a degree MuJoCo looks at two points, along the face's
    normal.
    """
    exact = seen = 0
    for found in sweep(hole, heights, PEG.clearance + 2.3e-4):
        for touch in found:
            seen += 1
            if touch.gap() == approx(touch.dist, abs=2e-8):
                exact += 1
            else:
                assert touch.normal @ touch.face == approx(1.0, abs=1e-9)
            assert touch.normal @ touch.face > -1e-6  # never out of the wall's back
    assert seen > 2000
    assert exact > seen // 2


def test_a_chamfer_pushes_at_45_degrees_and_the_bore_towards_its_axis(hole: SceneBench) -> None:
    faces = {"chamfer": 0, "bore": 0}
    heights = (-0.035, -0.006), (-PEG.chamfer + 5e-4, -5e-4)
    for found in itertools.chain(*(sweep(hole, h, PEG.clearance + 2.3e-4) for h in heights)):
        for touch in found:
            x, y, z = touch.point
            away = touch.seen @ np.array([x, y, 0.0]) / math.hypot(x, y)
            if CONE[0] < z < CONE[1]:
                faces["chamfer"] += 1
                assert math.degrees(math.asin(touch.seen[2])) == approx(45.0, abs=1.0)
                assert away < -0.68
            elif -0.049 < z < -PEG.chamfer - SKIN:
                faces["bore"] += 1
                assert abs(math.degrees(math.asin(touch.seen[2]))) < 1.0
                assert away < -0.98
    assert min(faces.values()) > 300


@pytest.mark.parametrize("facet", [0, 13, 30])
def test_the_bore_is_where_it_is_drawn(hole: SceneBench, facet: int) -> None:
    for depth in (-2e-6, 1e-8, 3e-6):
        reach, about = PEG.clearance + depth, facet * FACET
        x, y = reach * math.cos(about), reach * math.sin(about)
        hole.put(HOLE @ Transform.translation(x, y, -0.02) @ DOWN)
        assert hole.model.contact_force().depth == approx(max(depth, 0.0), abs=1e-9)


@pytest.mark.parametrize(
    ("scene", "tip", "out"),
    [
        ("surface", SURFACE, (0.0, 0.0, 1.0)),
        ("curved", CROWN, (0.0, 0.0, 1.0)),
        ("corner", CORNER @ Transform.translation(-0.1, -0.02, 0.0), (0.0, -1.0, 0.0)),
        ("corner", CORNER @ Transform.translation(-0.02, -0.1, 0.0), (-1.0, 0.0, 0.0)),
    ],
)
def test_other_surfaces_are_where_they_are_drawn(
    scene: str, tip: Transform, out: tuple[float, float, float]
) -> None:
    bench = SceneBench(scene)
    for depth in (-1e-6, 1e-8, 3e-6, 2e-5):
        x, y, z = (-depth * axis for axis in out)
        bench.put(tip @ Transform.translation(x, y, z) @ DOWN)
        assert bench.model.contact_force().depth == approx(max(depth, 0.0), abs=1e-8)


@pytest.mark.parametrize("clearance", [2e-5, 2e-4, 2e-3])
def test_faces_under_the_skin_close_the_ring(clearance: float) -> None:
    """Each is as wide as the ring is there: nowhere could the peg get between two of them."""
    peg = PegInHole(clearance=clearance)
    half = math.tan(math.pi / peg.facets)
    bore = peg.radius + clearance
    for shape, farthest in zip(peg.hole()[:2], (bore, bore + peg.chamfer), strict=True):
        assert shape.size[1] - SKIN > (farthest + SKIN) * half

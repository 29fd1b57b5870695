"""A peg and a hole in the plant: what fits goes in, what does not is pushed back, and is felt."""

import importlib
import math
import pkgutil

import numpy as np
import pytest
from pytest import approx
from support.scene import SceneBench

from rfms_can.arm import PUMA_560
from rfms_can.plant import scene
from rfms_can.plant.scene import Kind
from rfms_can.plant.scene.catalogue import SCENES, scene_from
from rfms_can.plant.scene.peg_in_hole import HOLE, PegInHole
from rfms_can.transform import Transform

PEG = PegInHole()
STEP_S = 2.5e-4
DOWN = Transform.rotation((0.0, 1.0, 0.0), math.pi)


class PegBench(SceneBench):
    """A PUMA 560 with the peg over the hole; offsets are seen from the mouth of the hole, m."""

    def __init__(self, x: float = 0.0, z: float = 0.005) -> None:
        super().__init__("peg")
        self.put(at(x, z))

    def lower(self, x: float, to: float, seconds: float) -> None:
        """Lower the peg from above to a height, with a lateral offset."""
        for height in np.linspace(0.005, to, round(seconds / 0.01)):
            self.control(at(x, float(height)), 0.01)

    @property
    def end(self) -> Transform:
        """The end of the peg, seen from the mouth of the hole."""
        return HOLE.inverse() @ self.tip


def at(x: float, z: float) -> Transform:
    """The pose of the tip with the end of the peg at an offset from the mouth of the hole."""
    return HOLE @ Transform.translation(x, 0.0, z) @ DOWN


def test_every_file_that_builds_a_scene_is_in_the_catalogue() -> None:
    builders = {}
    for module in pkgutil.iter_modules(scene.__path__, "rfms_can.plant.scene."):
        if hasattr(found := importlib.import_module(module.name), "build"):
            builders[module.name] = found.build
    known = {entry.build for entry in SCENES.values()}
    assert [name for name, build in builders.items() if build not in known] == []


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_calls_itself_what_the_catalogue_calls_it(name: str) -> None:
    assert scene_from(name, PUMA_560.name).name == name


def test_the_facets_are_within_a_tenth_of_the_clearance() -> None:
    assert PEG.facet_error < PEG.clearance / 10.0
    wall = next(shape for shape in PEG.hole() if shape.kind is Kind.BOX)
    inner = wall.pose @ Transform.translation(-wall.size[0], 0.0, 0.0)
    assert math.hypot(inner.px, inner.py) == approx(PEG.radius + PEG.clearance, abs=1e-12)


def test_the_chamfer_begins_at_the_bore_and_ends_at_the_mouth() -> None:
    face = PEG.hole()[1]
    for end, (r, z) in (
        (1.0, (PEG.radius + PEG.clearance + PEG.chamfer, 0.0)),
        (-1.0, (PEG.radius + PEG.clearance, -PEG.chamfer)),
    ):
        corner = face.pose @ Transform.translation(-face.size[0], 0.0, end * face.size[2])
        assert [corner.px, corner.pz] == approx([r, z], abs=1e-12)


def test_a_peg_on_the_axis_goes_in_and_touches_nothing() -> None:
    bench = PegBench()
    bench.lower(0.0, -0.03, 0.6)
    assert bench.model.contacts == 0
    bench.control(at(0.0, -0.03), 0.3)
    assert bench.model.contacts == 0
    assert bench.end.pz == approx(-0.03, abs=2e-4)


def test_the_sensor_feels_the_weight_of_the_tool_at_rest() -> None:
    bench = PegBench()
    bench.control(at(0.0, 0.005), 0.3)
    tool = PEG.tool()
    weight = 9.81 * tool.mass  # z of T6 looks down: the hand pulls the tool up, along -z
    assert bench.model.wrist_force() == approx([0.0, 0.0, -weight, 0.0, 0.0, 0.0], abs=0.02)


@pytest.mark.parametrize("gap", [0.5, 0.95])
def test_within_the_clearance_the_bore_is_not_touched(gap: float) -> None:
    bench = PegBench()
    bench.lower(gap * PEG.clearance, -0.02, 0.6)
    assert bench.model.contacts == 0


def test_beyond_it_the_chamfer_pushes_the_peg_aside_and_the_sensor_says_where_to() -> None:
    bench = PegBench(0.001)
    bench.lower(0.001, -0.02, 0.6)
    bench.control(at(0.001, -0.02), 0.5)
    assert bench.model.contacts > 0
    tip = bench.end
    assert math.hypot(tip.px, tip.py) < PEG.clearance + 3e-4  # elastic: position control pushes on
    fx, fy, *_ = bench.model.wrist_force()
    # The wall pushes the peg towards -x of the base, which is +x of T6: the hand pushes it back.
    assert fx < -5.0
    assert abs(fy) < abs(fx)


def test_the_chamfer_gives_way_to_a_millimetre_and_the_rim_stops_what_is_farther_out() -> None:
    beyond = PEG.clearance + PEG.chamfer + 0.002
    bench = PegBench(beyond)
    bench.lower(beyond, -0.002, 0.4)
    assert bench.model.contacts > 0
    assert bench.end.pz > -0.0015
    assert bench.model.wrist_force()[2] > 10.0  # the mouth pushes up; the hand, along +z, down

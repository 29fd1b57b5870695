"""docs/scenes.md says of every scene what the code does."""

import itertools
import math
import re
from pathlib import Path

import draw_scenes
import pytest
from pytest import approx

from rfms_can.arm import PUMA_560
from rfms_can.kinematics import InverseKinematics, configuration_of
from rfms_can.plant.scene.catalogue import SCENES, scene_from
from rfms_can.plant.scene.peg_in_hole import PegInHole
from rfms_can.transform import Transform

PAGE = (Path(__file__).parents[1] / "docs" / "scenes.md").read_text(encoding="utf-8")
ROWS = [
    [cell.strip().strip("`") for cell in line.strip("|").split("|")]
    for line in PAGE.splitlines()
    if line.startswith("|")
]


def test_every_key_stands_there_with_its_bounds() -> None:
    told, scene = set(), ""
    for row in ROWS:
        if len(row) == 6 and re.fullmatch(r"[a-z_]+_(mm|deg)|friction", row[1]):
            scene = row[0] or scene
            numbers = (float(cell.replace("−", "-")) for cell in row[2:5])
            told.add((scene, row[1], *numbers, row[5]))
    assert told == {
        (name, key.name, key.default, key.minimum, key.maximum, key.meaning)
        for name, entry in SCENES.items()
        for key in entry.keys
    }


@pytest.mark.parametrize("name", [name for name in SCENES if name != "free"])
def test_every_place_and_tip_is_where_it_says(name: str) -> None:
    rows = [row for row in ROWS if row[0] == name and len(row) == 4]
    assert len(rows) == 1, f"docs/scenes.md: one row for {name} in the table of scenes"
    (row,) = rows
    scene = scene_from(name, "puma560")
    assert scene.tool is not None
    numbers = re.search(r"\(([\d.]+), ([\d.]+), ([\d.]+)\) m", row[3])
    assert numbers is not None
    x, y, z = map(float, numbers.groups())
    assert (scene.place.px, scene.place.py, scene.place.pz) == approx((x, y, z))
    tip = re.search(r"(\d+) mm from T6", row[1])
    if tip is not None:
        assert 1e3 * scene.tool.tip.pz == approx(float(tip[1]))
        mass = re.search(r"([\d.]+) kg", row[1])
        assert mass is not None and scene.tool.mass == approx(float(mass[1]), abs=5e-3)


def test_every_scene_is_pictured() -> None:
    pictured = {view.scene.partition(":")[0] for view in draw_scenes.VIEWS}
    assert pictured == set(SCENES) - {"free"}


@pytest.mark.parametrize(
    ("words", "name"), [("peg", "peg"), ("ball on a rod", "curved"), ("cube", "corner")]
)
def test_every_tool_weighs_what_it_says(words: str, name: str) -> None:
    (row,) = (row for row in ROWS if row[0] == words and len(row) == 3)
    tool = scene_from(name, "puma560").tool
    assert tool is not None
    assert tool.mass == approx(float(row[1].split()[0]), abs=5e-5)
    assert 1e3 * tool.com[2] == approx(float(row[2].split()[0]), abs=0.05)


def test_the_hole_has_as_many_faces_as_it_says_and_no_more_than_it_needs() -> None:
    peg = PegInHole()
    assert f"{peg.facets} at 0.2 mm" in PAGE
    assert (
        f"its {2 * peg.facets} boxes"
        in (Path(__file__).parents[1] / "tools" / "draw_scenes.py").read_text()
    )
    assert peg.facet_error < 0.1 * peg.clearance


@pytest.mark.parametrize("name", [name for name in SCENES if name != "free"])
def test_within_100_mm_of_every_place_the_wrist_is_as_far_from_singular_as_it_says(
    name: str,
) -> None:
    assert "is 49 degrees or more within 100 mm of every" in PAGE
    scene = scene_from(name, "puma560")
    assert scene.tool is not None
    held = Transform.rotation((0.0, 1.0, 0.0), math.pi) @ scene.tool.tip.inverse()
    configuration = configuration_of(PUMA_560, PUMA_560.park)
    for x, y, z in itertools.product((-0.1, -0.05, 0.0, 0.05, 0.1), repeat=3):
        if math.hypot(x, y, z) <= 0.1:
            pose = scene.place @ Transform.translation(x, y, z) @ held
            q = InverseKinematics(PUMA_560).solve(pose, configuration, PUMA_560.park)
            assert math.degrees(abs(q[4])) > 49.0
            assert 60.0 < -90.0 - math.degrees(q[2]) < 110.0  # from the stretched elbow

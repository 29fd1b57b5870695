#!/usr/bin/env python3
"""Draw the scenes: docs/images/scenes.png, as MuJoCo sees them, and the arm as a line of links.

Needs OpenGL without a display: MUJOCO_GL=egl (the default here) or osmesa.
"""

import argparse
import math
import os
from pathlib import Path
from typing import Any, Final, NamedTuple

os.environ.setdefault("MUJOCO_GL", "egl")

import mujoco
import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from rfms_can.analysis.canvas import INK
from rfms_can.arm import PUMA_560
from rfms_can.kinematics import InverseKinematics, configuration_of
from rfms_can.plant.arm_model import ArmModel
from rfms_can.plant.scene.catalogue import scene_from
from rfms_can.plant.scene.corner import CORNER
from rfms_can.plant.scene.curved import CROWN
from rfms_can.plant.scene.peg_in_hole import HOLE
from rfms_can.plant.scene.surface import SURFACE
from rfms_can.transform import Transform

IMAGES: Final = Path(__file__).parents[1] / "docs" / "images"
PIXELS: Final = (480, 640)
DOWN: Final = Transform.rotation((0.0, 1.0, 0.0), math.pi)
STEEL_COLOUR, TOOL_COLOUR = (0.62, 0.68, 0.74, 1.0), (0.88, 0.48, 0.15, 1.0)
LINK_COLOUR: Final = (0.12, 0.37, 0.60, 1.0)
INVISIBLE: Final = (0.0, 0.0, 0.0, 0.0)


class View(NamedTuple):
    """How a scene is shown: where the tip is in the place, and where one looks from."""

    title: str
    scene: str
    tip: Transform
    look_at: Transform
    distance: float
    azimuth: float
    elevation: float
    cut: bool = False


VIEWS: Final = (
    View(
        "peg: 20 mm in a hole cut open (half of its 102 boxes)",
        "peg",
        HOLE @ Transform.translation(0.0, 0.0, -0.022),
        HOLE,
        *(0.22, 160.0, -20.0),
        cut=True,
    ),
    View(
        "surface:tilt_y_deg=10",
        "surface:tilt_y_deg=10",
        SURFACE @ Transform.translation(0.0, 0.0, 1.5e-4),
        SURFACE,
        *(0.95, 135.0, -22.0),
    ),
    View("curved", "curved", CROWN, CROWN, *(0.95, 120.0, -22.0)),
    View(
        "corner: the block has come along AB to B",
        "corner",
        CORNER @ Transform.translation(-0.02, -0.02, 0.0),
        CORNER,
        *(0.55, 75.0, -35.0),
    ),
)


def render(view: View) -> npt.NDArray[np.uint8]:
    """A picture, (height, width, 3)."""
    scene = scene_from(view.scene, PUMA_560.name)
    assert scene.tool is not None
    arm = ArmModel(PUMA_560, PUMA_560.friction_sets["none"], scene.longest_step_s, scene)
    place = view.tip @ DOWN @ scene.tool.tip.inverse()
    configuration = configuration_of(PUMA_560, PUMA_560.park)
    arm.reset(InverseKinematics(PUMA_560).solve(place, configuration, PUMA_560.park))
    model, data = arm.engine
    tool = model.body("tool").id
    for geom in range(model.ngeom):
        mine = model.geom_bodyid[geom] == tool
        hidden = view.cut and not mine and data.geom_xpos[geom][0] > HOLE.px + 1e-3
        model.geom_rgba[geom] = INVISIBLE if hidden else TOOL_COLOUR if mine else STEEL_COLOUR
    model.vis.headlight.ambient[:], model.vis.headlight.diffuse[:] = 0.45, 0.65
    model.vis.quality.numslices = 96
    with mujoco.Renderer(model, *PIXELS) as renderer:
        camera = mujoco.MjvCamera()
        camera.lookat[:] = view.look_at.px, view.look_at.py, view.look_at.pz + 0.02
        camera.distance, camera.azimuth, camera.elevation = view[4:7]
        renderer.update_scene(data, camera)
        _draw_links(renderer.scene, model, data)
        picture: npt.NDArray[np.uint8] = renderer.render().copy()
        renderer.enable_segmentation_rendering()
        seen = renderer.render()[:, :, 0]
    picture[seen < 0] = 255
    return picture


def _draw_links(scene: Any, model: Any, data: Any) -> None:
    """A capsule from each joint to the next, and from T6 to what the hand holds."""
    joints = [data.body(f"link{number}").xpos for number in range(1, 7)]
    wrist, tool = data.site("t6").xpos, data.body("tool")
    hand = wrist + 0.06 * tool.xmat.reshape(3, 3)[:, 2]
    path = [*joints, wrist, hand]
    for start, end, radius in zip(path[:-1], path[1:], (*(0.04,) * 5, 0.03, 0.02), strict=True):
        if np.linalg.norm(end - start) < 1e-6 or scene.ngeom >= scene.maxgeom:
            continue
        geom = scene.geoms[scene.ngeom]
        scene.ngeom += 1
        mujoco.mjv_initGeom(
            geom,
            mujoco.mjtGeom.mjGEOM_CAPSULE,
            np.zeros(3),
            np.zeros(3),
            np.zeros(9),
            np.array(LINK_COLOUR, dtype=np.float32),
        )
        mujoco.mjv_connector(geom, mujoco.mjtGeom.mjGEOM_CAPSULE, radius, start, end)
        geom.objtype, geom.objid, geom.segid = mujoco.mjtObj.mjOBJ_GEOM, 0, scene.ngeom - 1


def draw(out: Path) -> Path:
    """The sheet with all of them."""
    rows = -(-len(VIEWS) // 2)
    figure = Figure(figsize=(9.0, 3.7 * rows), layout="constrained")
    for number, axes in enumerate(figure.subplots(rows, 2).flat):
        axes.axis("off")
        if number < len(VIEWS):
            axes.imshow(render(VIEWS[number]))
            axes.set_title(VIEWS[number].title, fontsize=10, color=INK)
    path = out / "scenes.png"
    figure.savefig(path, dpi=100)
    return path


def main() -> None:
    """Draw them into docs/images, or where asked."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=IMAGES)
    print(draw(parser.parse_args().out))


if __name__ == "__main__":
    main()

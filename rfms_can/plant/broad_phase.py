"""Broad phase of the collision test: hides the fixtures out of the tool's reach from MuJoCo.

Two convex bodies do not touch if a plane separates them. Planes along the faces, and at 45 degrees
between them, of each fixture's bounding box are tested at once against a cylinder in the hand. A
pair separated by more than the contact distance and a margin is hidden from MuJoCo until the tool
may have moved by the margin: MuJoCo finds the same contacts in the same order, and a run is
identical bit by bit. Distances are those of MuJoCo's shapes, which are smaller by a skin
(``contact.CONTACT_DISTANCE``). A hole has some hundred boxes, most of them out of reach.
"""

import math
from collections.abc import Sequence
from operator import mul
from typing import Final

import mujoco
import numpy as np
import numpy.typing as npt

from rfms_can.errors import PlantError
from rfms_can.plant.contact import CONTACT_DISTANCE

Floats = npt.NDArray[np.float64]

MIN_MARGIN: Final = 2e-6
"""Smallest margin, m: how far the tool may move between two updates."""
STEPS_AHEAD: Final = 4.0
"""Margin over the length of the last step."""
REACH: Final = 1.2
"""Bound of the distance from the axes of joints 1 to 3 to any point of the tool, m."""
MIN_PAIRS: Final = 16
"""Number of pairs above which the broad phase pays off."""

_EDGE: Final = 0.5**0.5
_NORMALS: Final = np.array(
    [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [_EDGE, 0.0, _EDGE], [_EDGE, 0.0, -_EDGE]]
)
"""Normals of the planes tried, in the frame of a box, (4, 3): across and between x and z."""


class BroadPhase:
    """Separation test of the tool's one solid shape and the fixtures.

    Args:
        model: of arm and scene; its pairs are of a fixture and a shape of the tool.
        data: its state.

    Raises:
        PlantError: the tool has more than one solid shape.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._margin = model.pair_margin
        fixtures, self._tool = model.pair_geom1, int(model.pair_geom2[0])
        if (model.pair_geom2 != self._tool).any():
            raise PlantError("a scene's tool has one solid shape: which of several may touch?")
        self._positions, self._rotations = data.geom_xpos, data.geom_xmat
        half_extents = _boxes(model, fixtures)  # (n, 3)
        rotations = data.geom_xmat[fixtures].reshape(-1, 3, 3)  # columns: axes of the boxes
        positions = self._fixture_positions = data.geom_xpos[fixtures].copy()  # (n, 3)
        # Fixture n lies within _half of _centre along its three axes,
        axes = rotations.transpose(2, 0, 1)
        self._axes: Floats = np.ascontiguousarray(axes.reshape(-1, 3))  # (3 n, 3)
        self._centre: Floats = np.einsum("inj,nj->in", axes, positions)  # (3, n)
        self._half: Floats = np.ascontiguousarray(half_extents.T)  # (3, n)
        # and within _extent of _offset along the four normals.
        normals = np.einsum("kj,nij->kni", _NORMALS, rotations)
        self._normals: Floats = np.ascontiguousarray(normals.reshape(-1, 3))  # (4 n, 3)
        self._offset: Floats = np.einsum("kni,ni->kn", normals, positions)  # (4, n)
        self._extent: Floats = np.abs(_NORMALS) @ self._half  # (4, n)
        self._bound = float(model.geom_rbound[self._tool])
        # MuJoCo skips a pair if its bounding spheres are farther apart than the margin.
        self._hidden: Floats = -(model.geom_rbound[fixtures] + self._bound)
        size, kind = model.geom_size[self._tool], model.geom_type[self._tool]
        self._radius, self._length = float(size[0]), float(size[1])
        self._enabled = kind == mujoco.mjtGeom.mjGEOM_CYLINDER and len(fixtures) > MIN_PAIRS
        # A joint's lever arm: how far the tool's shape extends from its axis.
        offset = model.geom_pos[self._tool]  # from T6, where the axes of the wrist meet
        wrist = float(np.linalg.norm(offset)) + self._bound
        on_axis = not offset[:2].any() and model.geom_quat[self._tool][0] == 1.0
        self._levers = (*(REACH,) * 3, wrist, wrist, 0.0 if on_axis else wrist)
        self._remaining = 0.0
        self._refine_below = 0.0  # a fast tool has a wide margin: update when steps are this short
        self.update()

    def distance(self) -> float:
        """Distance of the tool's bounding sphere from the nearest box, m; 0 if they intersect."""
        beyond = (self._axes @ self._positions[self._tool]).reshape(3, -1) - self._centre
        beyond = np.maximum(np.abs(beyond) - self._half, 0.0)
        squares = (beyond * beyond).sum(axis=0)
        return max(math.sqrt(squares.min()) - self._bound - CONTACT_DISTANCE, 0.0)

    def enable_all_pairs(self) -> None:
        """Let MuJoCo test all pairs until the tool moves."""
        self._margin[:] = CONTACT_DISTANCE
        self._remaining = 0.0

    def advance(self, qd: Sequence[float], step_s: float) -> None:
        """Update the pairs if the tool may have moved by the margin.

        Args:
            qd: joint speeds of the last step, (6,), rad/s.
            step_s: its length, s.
        """
        if not self._enabled:
            return
        step = step_s * sum(map(mul, self._levers, map(abs, qd)))
        self._remaining -= step
        if self._remaining <= 0.0 or step < self._refine_below:
            self._remaining = max(MIN_MARGIN, STEPS_AHEAD * step)
            self._refine_below = 0.25 * step if step > MIN_MARGIN else 0.0
            self.update(self._remaining + step)  # MuJoCo has the tool where it was a step ago

    def update(self, margin: float = MIN_MARGIN) -> None:
        """Hide the pairs that a plane separates by more than a margin, m; show the others."""
        if not self._enabled:
            return
        axis, position = self._rotations[self._tool][2::3], self._positions[self._tool]
        along = (self._normals @ axis).reshape(4, -1)  # cosines of the tool's axis, (4, n)
        across = np.sqrt(np.maximum(1.0 - along * along, 1e-12))
        offset = (self._normals @ position).reshape(4, -1) - self._offset
        gap = np.abs(offset) - self._extent - self._length * np.abs(along) - self._radius * across
        # The same normals projected perpendicular to the tool's axis: its length drops out.
        offset -= along * (axis @ position - self._fixture_positions @ axis)
        turned = _NORMALS[:, :, None] - along[:, None, :] * (self._axes @ axis).reshape(3, -1)
        reach = (np.abs(turned) * self._half).sum(axis=1)
        np.maximum(gap, (np.abs(offset) - reach) / across - self._radius, out=gap)
        self._margin[:] = np.where(
            gap.max(axis=0) > CONTACT_DISTANCE + margin, self._hidden, CONTACT_DISTANCE
        )


def _boxes(model: mujoco.MjModel, geoms: npt.NDArray[np.int32]) -> Floats:
    """Half lengths of the bounding boxes of boxes and cylinders, (n, 3), m."""
    half: Floats = model.geom_size[geoms].copy()
    lying = model.geom_type[geoms] == mujoco.mjtGeom.mjGEOM_CYLINDER
    half[lying, 2] = half[lying, 1]
    half[lying, 1] = half[lying, 0]
    return half

"""Which fixtures the tool may touch now: spares MuJoCo most of a hole's hundred boxes.

Two convex bodies touch nowhere if a plane separates them. Here planes are tried along the faces and
between the faces of each fixture's box (a cylinder's is the one around it), all at once, against a
cylinder in the hand. A pair so separated by more than the distance at which contact begins and a
margin is hidden from MuJoCo until the tool may have moved by the margin: it sees the same contacts,
in the same order, and a run is the same bit by bit. All of this is between MuJoCo's shapes, which
lie under their skins (``model_builder.TOUCHING``).
"""

import math
from collections.abc import Sequence
from operator import mul
from typing import Final

import mujoco
import numpy as np
import numpy.typing as npt

from rfms_can.errors import PlantError
from rfms_can.plant.model_builder import TOUCHING

Floats = npt.NDArray[np.float64]

NARROWEST: Final = 2e-6
"""How far the tool may move between two looks, m, at the least;"""
STEPS_AHEAD: Final = 4.0
"""and how many steps as long as the last one."""
REACH: Final = 1.2
"""Bound of the distance from the axes of joints 1 to 3 to any point of the tool, m."""
MANY: Final = 16
"""Pairs from which on looking costs less than it spares."""

_EDGE: Final = 0.5**0.5
_NORMALS: Final = np.array(
    [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [_EDGE, 0.0, _EDGE], [_EDGE, 0.0, -_EDGE]]
)
"""Normals of the planes tried, in the frame of a box, (4, 3): across and between x and z."""


class Nearness:
    """The tool's one solid shape against the fixtures.

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
        self._middles, self._turns = data.geom_xpos, data.geom_xmat
        sides = _boxes(model, fixtures)  # (n, 3)
        turns = data.geom_xmat[fixtures].reshape(-1, 3, 3)  # columns: axes of the boxes
        places = self._places = data.geom_xpos[fixtures].copy()  # (n, 3)
        # Fixture n lies within _half of _centre along its three axes,
        axes = turns.transpose(2, 0, 1)
        self._axes: Floats = np.ascontiguousarray(axes.reshape(-1, 3))  # (3 n, 3)
        self._centre: Floats = np.einsum("inj,nj->in", axes, places)  # (3, n)
        self._half: Floats = np.ascontiguousarray(sides.T)  # (3, n)
        # and within _reach of _level along the four normals.
        normals = np.einsum("kj,nij->kni", _NORMALS, turns)
        self._normals: Floats = np.ascontiguousarray(normals.reshape(-1, 3))  # (4 n, 3)
        self._level: Floats = np.einsum("kni,ni->kn", normals, places)  # (4, n)
        self._reach: Floats = np.abs(_NORMALS) @ self._half  # (4, n)
        self._bound = float(model.geom_rbound[self._tool])
        # MuJoCo passes a pair over if its balls are farther apart than their radii and the margin.
        self._hidden: Floats = -(model.geom_rbound[fixtures] + self._bound)
        size, kind = model.geom_size[self._tool], model.geom_type[self._tool]
        self._radius, self._length = float(size[0]), float(size[1])
        self._worthwhile = kind == mujoco.mjtGeom.mjGEOM_CYLINDER and len(fixtures) > MANY
        # A joint's lever: how far the tool's shape reaches from its axis.
        offset = model.geom_pos[self._tool]  # from T6, where the axes of the wrist meet
        wrist = float(np.linalg.norm(offset)) + self._bound
        turns_in_itself = not offset[:2].any() and model.geom_quat[self._tool][0] == 1.0
        self._levers = (*(REACH,) * 3, wrist, wrist, 0.0 if turns_in_itself else wrist)
        self._left = 0.0
        self._slower = 0.0  # a look in haste shows much: look again when steps are this short
        self.look()

    def distance(self) -> float:
        """Of the ball around the tool from the nearest box, m; 0 if they meet."""
        beyond = (self._axes @ self._middles[self._tool]).reshape(3, -1) - self._centre
        beyond = np.maximum(np.abs(beyond) - self._half, 0.0)
        squares = (beyond * beyond).sum(axis=0)
        return max(math.sqrt(squares.min()) - self._bound - TOUCHING, 0.0)

    def show_all(self) -> None:
        """Hide nothing until the tool moves."""
        self._margin[:] = TOUCHING
        self._left = 0.0

    def moved(self, qd: Sequence[float], step_s: float) -> None:
        """Look again if the tool may have moved by the margin.

        Args:
            qd: joint speeds, (6,), rad/s, with which the last step was made.
            step_s: its length, s.
        """
        if not self._worthwhile:
            return
        step = step_s * sum(map(mul, self._levers, map(abs, qd)))
        self._left -= step
        if self._left <= 0.0 or step < self._slower:
            self._left = max(NARROWEST, STEPS_AHEAD * step)
            self._slower = 0.25 * step if step > NARROWEST else 0.0
            self.look(self._left + step)  # MuJoCo has the tool where it was a step ago

    def look(self, margin: float = NARROWEST) -> None:
        """Hide the pairs whose surfaces a plane holds a margin, m, apart; show the others."""
        if not self._worthwhile:
            return
        axis, middle = self._turns[self._tool][2::3], self._middles[self._tool]
        along = (self._normals @ axis).reshape(4, -1)  # cosines of the tool's axis, (4, n)
        across = np.sqrt(np.maximum(1.0 - along * along, 1e-12))
        offset = (self._normals @ middle).reshape(4, -1) - self._level
        gap = np.abs(offset) - self._reach - self._length * np.abs(along) - self._radius * across
        # The same normals turned to stand on the tool's axis: then its length does not matter.
        offset -= along * (axis @ middle - self._places @ axis)
        turned = _NORMALS[:, :, None] - along[:, None, :] * (self._axes @ axis).reshape(3, -1)
        reach = (np.abs(turned) * self._half).sum(axis=1)
        np.maximum(gap, (np.abs(offset) - reach) / across - self._radius, out=gap)
        self._margin[:] = np.where(gap.max(axis=0) > TOUCHING + margin, self._hidden, TOUCHING)


def _boxes(model: mujoco.MjModel, geoms: npt.NDArray[np.int32]) -> Floats:
    """Half lengths of the boxes around boxes and cylinders, (n, 3), m."""
    half: Floats = model.geom_size[geoms].copy()
    lying = model.geom_type[geoms] == mujoco.mjtGeom.mjGEOM_CYLINDER
    half[lying, 2] = half[lying, 1]
    half[lying, 1] = half[lying, 0]
    return half

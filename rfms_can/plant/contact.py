"""What the fixtures do to the tool: the truth that no sensor reads, for whoever judges a run."""

from typing import Final, NamedTuple

import mujoco
import numpy as np

from rfms_can.plant.model_builder import TIP, TOOL, TOUCHING
from rfms_can.transform import Vector3

_NOTHING: Final = (0.0, 0.0, 0.0)


class Contacts(NamedTuple):
    """Tool against fixtures.

    Attributes:
        points: at which they touch.
        force: on the tool, N, along the axes of its tip.
        torque: about its tip, Nm, along the same.
        depth: of the deepest point, m.
    """

    points: int
    force: Vector3
    torque: Vector3
    depth: float


class ContactReader:
    """Adds up the contacts of MuJoCo's last step.

    Args:
        model: of arm and scene.
        data: its state.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._model, self._data = model, data
        self._tool = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, TOOL)
        self._body_of = model.geom_bodyid
        if self._tool >= 0:
            site = data.site(TIP)
            self._origin, self._axes = site.xpos, site.xmat.reshape(3, 3)

    def read(self) -> Contacts:
        """Their sum."""
        data = self._data
        if not data.ncon:
            return Contacts(0, _NOTHING, _NOTHING, 0.0)
        contacts = data.contact
        local = np.empty((data.ncon, 6))
        for index in range(data.ncon):
            mujoco.mj_contactForce(self._model, data, index, local[index])
        # The force that the second body feels, along the rows of the contact's frame.
        frames = contacts.frame.reshape(-1, 3, 3)
        pushed = (local[:, :3, None] * frames).sum(axis=1)
        pushed[self._body_of[contacts.geom[:, 1]] != self._tool] *= -1.0
        (x, y, z), (fx, fy, fz) = (contacts.pos - self._origin).T, pushed.T
        force = pushed.sum(axis=0)
        torque = np.array([y @ fz - z @ fy, z @ fx - x @ fz, x @ fy - y @ fx])
        depth = max(0.0, TOUCHING - float(contacts.dist.min()))
        return Contacts(data.ncon, _along(self._axes, force), _along(self._axes, torque), depth)


def _along(axes: np.ndarray, vector: np.ndarray) -> Vector3:
    """Components of a vector along the columns of ``axes``."""
    x, y, z = (vector @ axes).tolist()
    return x, y, z

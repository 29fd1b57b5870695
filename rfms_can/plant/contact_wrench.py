"""Contact wrench of the fixtures on the tool: ground truth for the evaluation of a run."""

from typing import Final, NamedTuple

import mujoco
import numpy as np

from rfms_can.plant.contact import CONTACT_DISTANCE
from rfms_can.plant.model_builder import TIP, TOOL
from rfms_can.transform import Vector3

_NOTHING: Final = (0.0, 0.0, 0.0)


class Contacts(NamedTuple):
    """Contact of tool and fixtures over a control period.

    Attributes:
        points: contact points, the largest number of any physics step.
        force: on the tool, mean of the period, N, along the axes of its tip.
        torque: about its tip, mean of the period, Nm, along the same.
        depth: penetration of the deepest point at the period's end, m.
    """

    points: int
    force: Vector3
    torque: Vector3
    depth: float


NO_CONTACT: Final = Contacts(0, _NOTHING, _NOTHING, 0.0)


class ContactReader:
    """Adds up the contacts of MuJoCo's steps.

    Args:
        model: of arm and scene, with a tool in the hand: its sensors make MuJoCo compute the
            external wrench on each body.
        data: its state.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._data = data
        site, tool = data.site(TIP), model.body(TOOL).id
        self._tip, self._axes = site.xpos, site.xmat.reshape(3, 3)
        # Torque and force on the tool from outside, about the centre of mass of arm and tool.
        self._external_wrench = data.cfrc_ext[tool]
        self._centre = data.subtree_com[model.body_rootid[tool]]
        self.begin()

    def begin(self) -> None:
        """Start a control period."""
        self._points = self._steps = 0
        self._force: Vector3 = _NOTHING
        self._torque: Vector3 = _NOTHING

    def add(self) -> None:
        """Add the contact wrench of MuJoCo's last step, in base axes, about the tip."""
        points = self._data.ncon
        self._steps += 1
        if not points:
            return
        self._points = max(self._points, points)
        tx, ty, tz, fx, fy, fz = self._external_wrench.tolist()
        x, y, z = (self._centre - self._tip).tolist()
        force, torque = self._force, self._torque
        self._force = force[0] + fx, force[1] + fy, force[2] + fz
        self._torque = (
            torque[0] + tx + y * fz - z * fy,
            torque[1] + ty + z * fx - x * fz,
            torque[2] + tz + x * fy - y * fx,
        )

    def read(self) -> Contacts:
        """The period so far, along the axes of the tip as it stands now."""
        if not self._points:
            return NO_CONTACT
        depth = 0.0
        if self._data.ncon:
            depth = max(0.0, CONTACT_DISTANCE - float(self._data.contact.dist.min()))
        return Contacts(self._points, self._mean(self._force), self._mean(self._torque), depth)

    def _mean(self, total: Vector3) -> Vector3:
        """Components of a sum over the steps along the axes of the tip, over their number."""
        x, y, z = (np.array(total) @ self._axes / self._steps).tolist()
        return x, y, z

"""Rigid-body dynamics of an arm by Pinocchio: Jacobian, inertia matrix and gravity (Ch. II, IV).

The math processor's model. It is built from the *published* link parameters of ``arm.py``; the
plant's MuJoCo model carries the corrected ones, so the two differ as a model and an arm do.
"""

from collections.abc import Sequence
from math import cos, sin
from typing import Final

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from rfms_can.arm import JOINT_COUNT, Arm, Link

GRAVITY: Final = 9.81  # m/s2, along -z of the base

Matrix = npt.NDArray[np.float64]
Configuration = Sequence[float] | Matrix


class ArmDynamics:
    """Jacobian, inertia matrix and gravity of one arm, all from one :meth:`update`.

    Pinocchio returns a new array each time: a stored one never changes. Not thread-safe.

    Attributes:
        J: (6, 6), Jacobian in the T6 frame at the T6 origin; columns d/d theta_1..6, rows
            vx vy vz wx wy wz (m, rad). Eq. 2.12, A.17 to A.22 as corrected.
        M: (6, 6), joint-space inertia with the drives' armature, symmetric, kg m2 (Eq. 4.3).
        g: (6,), torque that holds the arm against gravity, +dU/dq, Nm (D_i of Eq. 4.5).
    """

    def __init__(
        self,
        arm: Arm,
        parameters: Matrix | None = None,
        armature: Sequence[float] | None = None,
    ) -> None:
        """Take an arm's own links, or inertial parameters in their place.

        Args:
            arm: the arm.
            parameters: (6, 10), as :attr:`parameters` gives them; the arm's own if None.
            armature: of the drives, kg m2 (6); the arm's own if None.
        """
        self.arm = arm
        self._model = _pinocchio_model(arm, parameters, armature)
        self._data = self._model.createData()
        self._q = np.zeros(JOINT_COUNT)
        self.J: Matrix = np.zeros((JOINT_COUNT, JOINT_COUNT))
        self.M: Matrix = np.zeros((JOINT_COUNT, JOINT_COUNT))
        self.g: Matrix = np.zeros(JOINT_COUNT)
        self.update(arm.park)

    def update(self, q: Configuration) -> None:
        """Compute :attr:`J`, :attr:`M` and :attr:`g` at joint angles ``q`` (6, rad)."""
        model, data, q_ = self._model, self._data, self._q
        q_[:] = q
        self.J = pin.computeJointJacobian(model, data, q_, JOINT_COUNT)  # the universe is joint 0
        self.M = pin.crba(model, data, q_)
        self.g = pin.computeGeneralizedGravity(model, data, q_)

    def torque(self, q: Configuration, qd: Configuration, qdd: Configuration) -> Matrix:
        """Newton-Euler (Eq. 4.6 to 4.8 as corrected): torque of a motion, (6,), Nm.

        Armature included, friction not.
        """
        torque: Matrix = pin.rnea(self._model, self._data, np.array(q), np.array(qd), np.array(qdd))
        return torque

    def regressor(self, q: Configuration, qd: Configuration, qdd: Configuration) -> Matrix:
        """Y, (6, 60): the torque of a motion is Y times the ten parameters of each link.

        Armature is not included: it adds ``qdd_i`` times itself to the torque of joint i.
        """
        regressor: Matrix = pin.computeJointTorqueRegressor(
            self._model, self._data, np.array(q), np.array(qd), np.array(qdd)
        )
        return regressor

    @property
    def parameters(self) -> Matrix:
        """Inertial parameters of the links, (6, 10): m, m c (3), I xx xy yy xz yz zz.

        In the frame of each link's joint, about its origin; kg, kg m, kg m2.
        """
        inertias = [self._model.inertias[i] for i in range(1, JOINT_COUNT + 1)]
        return np.array([inertia.toDynamicParameters() for inertia in inertias])

    def jacobian(self, q: Configuration) -> Matrix:
        """Jacobian in the T6 frame, (6, 6); see :attr:`J`."""
        self.update(q)
        return self.J

    def inertia_matrix(self, q: Configuration) -> Matrix:
        """Joint-space inertia, (6, 6), kg m2; see :attr:`M`."""
        self.update(q)
        return self.M

    def gravity(self, q: Configuration) -> Matrix:
        """Holding torque, (6,), Nm; see :attr:`g`."""
        self.update(q)
        return self.g


def _pinocchio_model(
    arm: Arm, parameters: Matrix | None = None, armature: Sequence[float] | None = None
) -> pin.Model:
    """The arm's kinematic tree: joint i turns about z of frame i - 1, base on the joint-2 axis."""
    model = pin.Model()
    model.gravity.linear = np.array([0.0, 0.0, -GRAVITY])
    parent, placement = 0, pin.SE3.Identity()
    for index, (link, (alpha, a, d)) in enumerate(zip(arm.links, arm.dh, strict=True)):
        parent = model.addJoint(parent, pin.JointModelRZ(), placement, f"joint{index + 1}")
        # A_i = Rz(q) times this fixed part: from the joint's frame to the link's own frame.
        placement = pin.SE3(_rotation_x(alpha), np.array([a, 0.0, d]))
        inertia = placement.act(_inertia(link))
        if parameters is not None:
            inertia = _body(parameters[index])
        model.appendBodyToJoint(parent, inertia, pin.SE3.Identity())
    own = [drive.armature for drive in arm.drives]
    model.armature = np.array(own if armature is None else armature)
    return model


def _inertia(link: Link) -> pin.Inertia:
    return pin.Inertia(link.mass, np.array(link.com), np.diag(link.inertia))


def _body(parameters: Matrix) -> pin.Inertia:
    """A link from its ten parameters; a massless one has inertia but no centre of mass."""
    if parameters[0] != 0.0:
        return pin.Inertia.FromDynamicParameters(parameters)
    xx, xy, yy, xz, yz, zz = parameters[4:]
    return pin.Inertia(0.0, np.zeros(3), np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))


def _rotation_x(angle: float) -> Matrix:
    c, s = cos(angle), sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])

"""The angle of one joint from a pose: by the arm's closed form, or as the master gives it.

The geometry travels in CONFIG, so a node needs no list of arms. Where the master solves, or where
the wrist is straight, angles come in JOINT_SETPOINT.
"""

import math
from collections.abc import Callable
from typing import Final

from rfms_can.errors import KinematicsError
from rfms_can.joint_nodes.field_node import Parameters
from rfms_can.kinematics import WIRE, Configuration, JointSolver, SphericalWrist
from rfms_can.setpoint.cartesian import CartesianSetpoint
from rfms_can.transform import Transform
from rfms_can.wire.configuration import Kinematics, geometry_rows
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import JointAngles
from rfms_can.wire.vocabulary import Parameter

_WRIST_JOINT: Final = 1 << 3
"""Bit of joint 4, whose angle all joints hold where the wrist is straight."""

Solve = Callable[[Transform, Configuration, float], float]
"""Pose, configuration and the angle whose turn to continue, to the angle (rad); NaN if there is
none."""


class AngleSolver:
    """Solves one joint.

    Args:
        parameters: the node's configuration, whole.
        joint: number of the joint.

    Attributes:
        solve: the angle of a pose without JOINT_SETPOINT.

    Raises:
        KinematicsError: the configuration asks for a closed form that this node does not have.
    """

    __slots__ = ("_form", "_index", "_lower", "_upper", "solve")

    def __init__(self, parameters: Parameters, joint: int) -> None:
        self._index = joint - 1
        self._lower = parameters[Parameter.POSITION_MIN] - WIRE.angle
        self._upper = parameters[Parameter.POSITION_MAX] + WIRE.angle
        self._form = _closed_form(parameters, joint)
        self.solve: Solve = _no_solution if self._form is None else self._form.solve

    def hold(self, theta4: float) -> None:
        """Tell where theta4 (rad) stands while the wrist is straight."""
        if self._form is not None:
            self._form.hold(theta4)

    def given(
        self, setpoint: CartesianSetpoint, first: JointAngles, second: JointAngles | None
    ) -> Solve:
        """What gives the angle of each pose: its JOINT_SETPOINT if that has the joint's bit."""
        index, own_bit = self._index, 1 << self._index
        for angles in (first, second):
            if angles is not None and angles.joints & _WRIST_JOINT:
                self.hold(angles.joint_4)

        def solve(pose: Transform, configuration: Configuration, previous: float) -> float:
            angles = first if pose is setpoint.T6_1 else second
            if angles is None or not angles.joints & own_bit:
                return self.solve(pose, configuration, previous)
            angle = angles[index]
            return angle if self._lower <= angle <= self._upper else math.nan

        return solve


def _no_solution(_pose: Transform, _configuration: Configuration, _previous: float) -> float:
    """Where the master solves, a joint that is given no angle has none."""
    return math.nan


def _closed_form(parameters: Parameters, joint: int) -> JointSolver | None:
    """The closed form of the configured arm; None where the master solves.

    Raises:
        KinematicsError: this node does not have it.
    """
    p, name = parameters, f"arm {parameters[Parameter.ARM_ID]:g}"
    if p[Parameter.KINEMATICS] == Kinematics.BY_MASTER:
        return None
    if p[Parameter.KINEMATICS] != Kinematics.SPHERICAL_WRIST:
        raise KinematicsError(f"{name}: KINEMATICS {p[Parameter.KINEMATICS]:g} is not known here")
    limits = ((p[Parameter.POSITION_MIN], p[Parameter.POSITION_MAX]),) * len(JOINTS)
    return JointSolver(SphericalWrist.of(geometry_rows(p), limits, name), joint)

"""Six joints as their nodes are: on the float32 numbers of the wire, with memories of their own."""

import math
import struct
from collections.abc import Sequence
from typing import Any, Final

from rfms_can.arm import Arm
from rfms_can.joint_nodes.angle_solver import AngleSolver
from rfms_can.joint_nodes.detectors.setpoint_step import STEP_MARGIN
from rfms_can.kinematics import Joints
from rfms_can.master.broadcast import Broadcast, Outgoing
from rfms_can.master.start_up.node_parameters import joint_parameters
from rfms_can.master.trajectory.commanded import Told
from rfms_can.setpoint import CartesianSetpoint, JointSetpoint
from rfms_can.setpoint.frames import setpoint_of
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.protection import Receiver
from rfms_can.wire.records import JointAngles, Setpoint
from rfms_can.wire.vocabulary import GripperCommand, Parameter

_HELD: Final = (GripperCommand.HOLD, 0.0)


def float32(value: float) -> float:
    """As it travels."""
    return float(struct.unpack("f", struct.pack("f", value))[0])


class RefusedError(Exception):
    """What a joint would have stopped for, in words."""


class NodeJoints:
    """The set-points of six joint nodes.

    Args:
        wire: the contract.
        arm: the arm.
        q: where they stand, rad.
        period_s: tau, s.
    """

    def __init__(self, wire: Wire, arm: Arm, q: Joints, period_s: float) -> None:
        parameters = joint_parameters(arm, "thesis", period_s)
        self._receivers: dict[str, Receiver[Any]] = {
            "first": wire.receiver(Setpoint, 1),
            "second": wire.receiver(Setpoint, 2),
            "first angles": wire.receiver(JointAngles, 1),
            "second angles": wire.receiver(JointAngles, 2),
        }
        self._broadcast = Broadcast(wire.sender, 0)
        self._joints = [JointSetpoint(period_s, angle) for angle in q]
        self._told = list(q)
        self._solvers = [AngleSolver(parameters[joint], joint) for joint in JOINTS]
        self._most = [
            STEP_MARGIN * parameters[joint][Parameter.SPEED_LIMIT] * period_s for joint in JOINTS
        ]

    def take(
        self,
        setpoint: CartesianSetpoint,
        told: Told | None,
        displacement: Sequence[float] | None,
        cycle: int,
    ) -> list[float]:
        """The set-points of a cycle, rad.

        Raises:
            RefusedError: a joint cannot use it, or it steps too far.
        """
        frames: list[Frame] = []
        self._broadcast.setpoint(Outgoing(setpoint, told, displacement, None, _HELD), cycle, frames)
        heard = {
            name: receiver.take(frame)
            for frame in frames
            for name, receiver in self._receivers.items()
            if receiver.decoder.codec.id == frame.id
        }
        first, angles = heard["first"], heard.get("first angles")
        cartesian = setpoint_of(first, heard.get("second"))
        result = []
        for k, (joint, solver) in enumerate(zip(self._joints, self._solvers, strict=True)):
            solve = solver.solve
            if angles is not None:
                solve = solver.given(cartesian, angles, heard.get("second angles"))
            before = self._told[k]
            theta = joint.tick(cartesian, solve) + (float32(displacement[k]) if displacement else 0)
            self._told[k] = theta
            if math.isnan(theta):
                raise RefusedError(f"joint {k + 1} cannot use a {setpoint.state.name} set-point")
            if abs(theta - before) > self._most[k]:
                raise RefusedError(f"joint {k + 1}: SETPOINT_STEP ({theta - before:.4g})")
            result.append(theta)
        return result

"""What the master sends in a cycle: SYNC, SETPOINT and what belongs to it, and commands."""

from collections.abc import Sequence
from typing import Final, NamedTuple

from rfms_can.master.rows.sets import MakeSender
from rfms_can.master.trajectory.commanded import Told
from rfms_can.setpoint.cartesian import CartesianSetpoint
from rfms_can.setpoint.frames import values_of
from rfms_can.wire.contract import (
    BIAS_BELONGS,
    COMPLY_BELONGS,
    ESTOP_VALUES,
    JOINT_SETPOINT_BELONGS,
)
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import HEARTBEAT_EVERY
from rfms_can.wire.records import Bias, Comply, Estop, Gripper, JointAngles, Nmt, Setpoint, Sync
from rfms_can.wire.vocabulary import Command, GripperCommand, NodeState

ALL_JOINTS: Final = 0b111111
"""Bits of the joints that JOINT_SETPOINT is for."""


class Outgoing(NamedTuple):
    """What goes out with the SYNC of a cycle: made when the one before is closed, handed on whole.

    Attributes:
        setpoint: the Cartesian set-point.
        told: angles of its poses, where the joints are told them; or None.
        displacement: COMPLY, rad, (6,), or None.
        bias: joint torques beside the servo's, Nm, (6,), or None.
        gripper: command and force (per cent).
    """

    setpoint: CartesianSetpoint
    told: Told | None
    displacement: Sequence[float] | None
    bias: Sequence[float] | None
    gripper: tuple[GripperCommand, float]


class Broadcast:
    """Packs the master's frames.

    Args:
        sends: makes a sender whose counter restarts with the others.
        dbc_hash: what SYNC says of the wire.

    Attributes:
        nmt: sender of commands.
    """

    def __init__(self, sends: MakeSender, dbc_hash: int) -> None:
        self.nmt = sends(Nmt, None)
        self._dbc_hash = dbc_hash
        self._sent_gripper: tuple[GripperCommand, float] | None = None
        self._sync = sends(Sync, None)
        self._gripper = sends(Gripper, None)
        self._first = sends(Setpoint, 1)
        self._second = sends(Setpoint, 2)
        self._first_angles = sends(JointAngles, 1)
        self._second_angles = sends(JointAngles, 2)
        self._comply = sends(Comply, None)
        self._bias = sends(Bias, None)
        self._estop = sends(Estop, None)

    def sync(self, cycle: int, state: NodeState, row_set: int) -> Frame:
        """SYNC of a cycle: the state of the bus, and the number of the rows in force."""
        return self._sync.frame(cycle, state, row_set, self._dbc_hash)

    def setpoint(self, outgoing: Outgoing, cycle: int, out: list[Frame]) -> None:
        """SETPOINT_1, and what belongs to it: SETPOINT_2 if there is a second pose, COMPLY, BIAS,
        and JOINT_SETPOINT of each pose where the joints are told their angles.

        GRIPPER goes with them on change or when due.
        """
        setpoint, told, displacement, bias, gripper = outgoing
        extras = (
            (displacement is not None) * COMPLY_BELONGS
            | (bias is not None) * BIAS_BELONGS
            | (told is not None) * JOINT_SETPOINT_BELONGS
        )
        pose, configuration = setpoint.T6_1, setpoint.configuration_1
        out.append(self._first.frame(*values_of(setpoint, pose, configuration, cycle, extras)))
        if setpoint.T6_2 is not None:
            pose, configuration = setpoint.T6_2, setpoint.configuration_2
            out.append(self._second.frame(*values_of(setpoint, pose, configuration, cycle, extras)))
        if displacement is not None:
            out.append(self._comply.frame(*displacement, cycle & 0xFF))
        if told is not None:
            out.append(self._first_angles.frame(*told.first, cycle & 0xFF, ALL_JOINTS))
            if setpoint.T6_2 is not None:
                out.append(self._second_angles.frame(*told.second, cycle & 0xFF, ALL_JOINTS))
        if bias is not None:
            out.append(self._bias.frame(*bias, cycle & 0xFF))
        if gripper != self._sent_gripper or cycle % HEARTBEAT_EVERY == 0:
            self._sent_gripper = gripper
            out.append(self._gripper.frame(*gripper, cycle & 0xFF))

    def emergency_stop(self) -> Frame:
        """Torque off and brakes on everywhere."""
        return self._estop.frame(*ESTOP_VALUES)

    def command(self, command: Command) -> Frame:
        """An NMT command to all nodes."""
        return self.nmt.frame(command, 0, 0)

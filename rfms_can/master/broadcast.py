"""What the master sends in a cycle: SYNC, SETPOINT and what belongs to it, ROWS, and commands."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from rfms_can.master.force.specification import Compliance
from rfms_can.master.math_processor import MathProcessor
from rfms_can.setpoint.cartesian import CartesianSetpoint
from rfms_can.setpoint.frames import values_of
from rfms_can.wire.contract import BIAS_BELONGS, COMPLY_BELONGS, NO_SET
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import HEARTBEAT_EVERY, JOINTS
from rfms_can.wire.protection import Sender
from rfms_can.wire.records import Bias, Comply, Gripper, Nmt, Rows, Setpoint, Sync
from rfms_can.wire.vocabulary import Command, GripperCommand, NodeState

MakeSender = Callable[[type[NamedTuple], int | None], Sender[Any]]


class Broadcast:
    """Packs the master's frames and keeps what they must agree on.

    Args:
        math: makes the rows.
        sends: makes a sender whose counter restarts with the others.
        dbc_hash: what SYNC says of the wire.

    Attributes:
        math: the same.
        gripper: command and force (per cent) that go out next.
    """

    def __init__(self, math: MathProcessor, sends: MakeSender, dbc_hash: int) -> None:
        self.math = math
        self.gripper = (GripperCommand.HOLD, 0.0)
        self.nmt = sends(Nmt, None)
        self._dbc_hash = dbc_hash
        self._told: tuple[GripperCommand, float] | None = None
        self._sync = sends(Sync, None)
        self._gripper = sends(Gripper, None)
        self._first = sends(Setpoint, 1)
        self._second = sends(Setpoint, 2)
        self._comply = sends(Comply, None)
        self._bias = sends(Bias, None)
        self._rows = [sends(Rows, joint) for joint in JOINTS]
        self._sent_set = self._active_set = NO_SET
        self._queued: list[Frame] = []

    def sync(self, cycle: int, state: NodeState) -> Frame:
        """SYNC: names the last set of rows that has gone out whole."""
        return self._sync.frame(cycle, state, self._active_set, self._dbc_hash)

    @property
    def in_force(self) -> Compliance:
        """What complies in the set of rows that SYNC names."""
        return self.math.made(self._active_set)

    def setpoint(
        self,
        setpoint: CartesianSetpoint,
        cycle: int,
        out: list[Frame],
        displacement: Sequence[float] | None = None,
        bias: Sequence[float] | None = None,
    ) -> None:
        """SETPOINT_1, and what belongs to it: SETPOINT_2 if there is a second pose, COMPLY, BIAS.

        GRIPPER goes with them on change or when due.
        """
        extras = (displacement is not None) * COMPLY_BELONGS | (bias is not None) * BIAS_BELONGS
        pose, configuration = setpoint.T6_1, setpoint.configuration_1
        out.append(self._first.frame(*values_of(setpoint, pose, configuration, cycle, extras)))
        if setpoint.T6_2 is not None:
            pose, configuration = setpoint.T6_2, setpoint.configuration_2
            out.append(self._second.frame(*values_of(setpoint, pose, configuration, cycle, extras)))
        if displacement is not None:
            out.append(self._comply.frame(*displacement, cycle & 0xFF))
        if bias is not None:
            out.append(self._bias.frame(*bias, cycle & 0xFF))
        if self.gripper != self._told or cycle % HEARTBEAT_EVERY == 0:
            self._told = self.gripper
            out.append(self._gripper.frame(*self.gripper, cycle & 0xFF))

    def rows(self, q: Sequence[float], out: list[Frame]) -> None:
        """The next set of rows, at joint angles ``q`` (rad)."""
        self._sent_set, rows = self.math.rows(q)
        self._queued = [s.frame(*values) for s, values in zip(self._rows, rows, strict=True)]
        out.extend(self._queued)

    def row_gone_out(self, frame: Frame) -> bool:
        """A row was heard back; after the last of its set SYNC may name the set.

        Returns:
            Whether it belongs to the set sent last; a crowded bus may still hold an older one.
        """
        if frame not in self._queued:
            return False
        self._queued.remove(frame)
        if not self._queued:
            self._active_set = self._sent_set
        return True

    def command(self, command: Command) -> Frame:
        """A command for everybody."""
        return self.nmt.frame(command, 0, 0)

"""The gripper node: opens and closes the jaw through its own board (Table 6.1's seventh node).

It homes by opening to the end stop, which is its reference; then it drives the jaw with the force
the master commands until it rests against a stop or a part. It answers every cycle, like a joint.
"""

from typing import Final

from rfms_can.joint_nodes.field_node import FieldNode
from rfms_can.joint_nodes.ladder import Reaction
from rfms_can.joint_nodes.states import Event
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import GRIPPER
from rfms_can.wire.records import Dac, Gripper, Measure, Sync
from rfms_can.wire.vocabulary import FaultCode, GripperCommand, NodeState, Parameter

AT_REST_CYCLES: Final = 10
HOMING_PART: Final = 0.25
"""Part of the full force the jaw opens with while homing."""


class GripperNode(FieldNode):
    """Node 7.

    Attributes:
        opening: jaw opening, m; None before homing.
        resting: cycles the jaw has not moved by more than a count.
    """

    def __init__(self, wire: Wire, boot_id: int, watch_ns: int) -> None:
        super().__init__(GRIPPER, wire, boot_id, watch_ns)
        self.opening: float | None = None
        self.resting = 0
        self._command = GripperCommand.HOLD
        self._next = (GripperCommand.HOLD, 0.0)
        self._part = 0.0
        self._counts: int | None = None
        self._open_counts: int | None = None
        self._measured = True
        self._dac = self._sends(Dac, GRIPPER)
        self._hears(Measure, GRIPPER, self._on_measure)
        self._hears(Gripper, None, self._on_gripper)

    def _configured(self) -> bool:
        needed = (Parameter.PERIOD, Parameter.TORQUE_LIMIT)
        scales = (Parameter.TORQUE_PER_CODE, Parameter.COUNTS_PER_UNIT, Parameter.POSITION_MAX)
        return all(self.parameters.get(p, 0.0) > 0.0 for p in (*needed, *scales))

    def _begin_cycle(self, sync: Sync) -> None:
        if not self._measured:
            self._miss(FaultCode.MEASURE_MISSING)
        self._measured = self.bus_state not in (NodeState.HOMING, NodeState.OPERATIONAL)
        command, part = self._next
        if command is not self._command:
            self._command, self.resting = command, 0
        self._part = part

    def _on_gripper(self, gripper: Gripper) -> None:
        """A command acts from the next SYNC on."""
        self._next = (GripperCommand(gripper.command), gripper.force / 100.0)

    def _on_measure(self, measure: Measure) -> None:
        runs = self.bus_state in (NodeState.HOMING, NodeState.OPERATIONAL)
        if not runs or not self.config_hash:
            return
        if measure.cycle != self.cycle & 0xFF:
            self.ignored["stale MEASURE"] += 1
            return
        self._measured = True
        self._ladder.clear(FaultCode.MEASURE_MISSING)
        moved = self._counts is None or abs(measure.counts - self._counts) > 1
        self.resting = 0 if moved else self.resting + 1
        self._counts = measure.counts
        if self._open_counts is not None:
            travelled = (measure.counts - self._open_counts) / self.parameters[
                Parameter.COUNTS_PER_UNIT
            ]
            self.opening = self.parameters[Parameter.POSITION_MAX] + travelled
        self._drive()

    def _drive(self) -> None:
        """One DAC frame: nothing from a node that is off (its brake is on)."""
        if self.reaction is Reaction.OFF:
            return
        limit = self.parameters[Parameter.TORQUE_LIMIT]
        force = 0.0
        if self.state is NodeState.HOMING:
            force = HOMING_PART * limit
            if self.resting >= AT_REST_CYCLES:
                self._open_counts = self._counts
                self._change(Event.HOMED)
        elif self.state is NodeState.OPERATIONAL and self._command is not GripperCommand.HOLD:
            opens = self._command is GripperCommand.OPEN
            force = self._part * (limit if opens else -limit)
        code = round(force / self.parameters[Parameter.TORQUE_PER_CODE])
        self._out.append(self._dac.frame(max(-2048, min(2047, code)), 0, self.cycle & 0xFF))

    def _react(self, reaction: Reaction, fault: FaultCode, value: float) -> None:
        before = self.reaction
        super()._react(reaction, fault, value)
        if self.reaction is Reaction.OFF and before is not Reaction.OFF:
            self._out.append(self._dac.frame(0, 0, self.cycle & 0xFF))  # and silence from now on

    def _entered(self, state: NodeState) -> None:
        if state is NodeState.HOMING:
            self.resting = 0

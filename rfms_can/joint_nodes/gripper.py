"""The gripper node: opens and closes the jaw through its own board (Table 6.1's seventh node).

It homes by opening to the end stop, which is its reference, and at once where it knows that from
before, as after a reset: it does not let go of what it holds. Then it drives the jaw with the force
the master commands until it rests against a stop or a part. It answers every cycle, like a joint.
"""

from typing import Final

from rfms_can.joint_nodes.field_node import Cause, FieldNode, Parameters
from rfms_can.joint_nodes.ladder import Reaction
from rfms_can.joint_nodes.servo import DAC_MAX, DAC_MIN
from rfms_can.joint_nodes.states import Event
from rfms_can.wire.configuration import DEFAULTS, GRIPPER_PARAMETERS
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import GRIPPER
from rfms_can.wire.protection import Sender
from rfms_can.wire.records import Dac, Gripper, Measure, Sync
from rfms_can.wire.vocabulary import FaultCode, GripperCommand, NodeState, Parameter

AT_REST_CYCLES: Final = 10
HOMING_FRACTION: Final = 0.25
"""Fraction of the full force the jaw opens with while homing."""
_CYCLING: Final = frozenset((NodeState.HOMING, NodeState.OPERATIONAL))


class GripperInputs:
    """What has been received; it outlives a configuration, as the jaw and its command do.

    Attributes:
        command, fraction: what GRIPPER commanded last, and with which fraction of the full force.
        counts: encoder counts of the last sample; None before the first.
    """

    __slots__ = ("command", "counts", "fraction")

    def __init__(self) -> None:
        self.command = GripperCommand.HOLD
        self.fraction = 0.0
        self.counts: int | None = None


class GripperController:
    """Drives the jaw.

    Args:
        node: the bus life it belongs to.
        parameters: the node's configuration, whole.
        inputs: what has been received.
        dac: sender of DAC.

    Attributes:
        opening: jaw opening, m; None before homing.
        resting: cycles the jaw has not moved by more than a count.
    """

    def __init__(
        self, node: FieldNode, parameters: Parameters, inputs: GripperInputs, dac: Sender[Dac]
    ) -> None:
        self._node = node
        self._inputs = inputs
        self._dac = dac
        self._limit = parameters[Parameter.TORQUE_LIMIT]
        self._force_per_code = parameters[Parameter.TORQUE_PER_CODE]
        self._counts_per_metre = parameters[Parameter.COUNTS_PER_UNIT]
        self._stroke = parameters[Parameter.POSITION_MAX]
        self._homing_time = parameters[Parameter.HOMING_TIME]
        self._period = parameters[Parameter.PERIOD]
        sender = int(parameters[Parameter.SENSOR_SOURCE])
        self._source = Cause(sender, node.wire.id(Measure, GRIPPER))
        self.opening: float | None = None
        self.resting = 0
        self._command, self._fraction = inputs.command, inputs.fraction
        self._open_counts: int | None = None
        self._sample_due = False
        self._homing_cycles = 0

    @property
    def drives(self) -> bool:
        """Whether DAC goes out at MEASURE."""
        return self._node.bus_state in _CYCLING and self._node.reaction is not Reaction.OFF

    def enter(self, state: NodeState) -> None:
        """The node's state has changed."""
        if state is NodeState.HOMING:
            self.resting = self._homing_cycles = 0

    def begin_cycle(self, sync: Sync) -> None:
        """SYNC: count a sample that did not come; a command acts from now on."""
        node, inputs = self._node, self._inputs
        if self._sample_due:
            node.miss(FaultCode.MEASURE_MISSING, self._source)
        self._sample_due = node.bus_state in _CYCLING
        if inputs.command is not self._command:
            self._command, self.resting = inputs.command, 0
        self._fraction = inputs.fraction

    def lose_cycle(self) -> None:
        """No SYNC: the ladder alone acts."""

    def step(self, counts: int) -> None:
        """The cycle, at its MEASURE: where the jaw is, then the force, and one DAC frame."""
        node, inputs = self._node, self._inputs
        self._sample_due = False
        node.ladder.clear(FaultCode.MEASURE_MISSING)
        moved = inputs.counts is None or abs(counts - inputs.counts) > 1
        self.resting = 0 if moved else self.resting + 1
        inputs.counts = counts
        if self._open_counts is not None:
            self.opening = self._stroke + (counts - self._open_counts) / self._counts_per_metre
        if node.reaction is Reaction.OFF:
            return  # silent: the brake is on
        force = 0.0
        if node.state is NodeState.HOMING and self._open_counts is not None:
            node.change(Event.HOMED)
        elif node.state is NodeState.HOMING:
            force = HOMING_FRACTION * self._limit
            self._homing_cycles += 1
            took = self._homing_cycles * self._period
            if took > self._homing_time:  # the jaw never comes to rest at its stop
                cause = self._source._replace(bound=self._homing_time)
                node.trip(FaultCode.HOMING_FAILED, cause, took)
                return
            if self.resting >= AT_REST_CYCLES:
                self._open_counts = counts
                node.change(Event.HOMED)
        elif node.state is NodeState.OPERATIONAL and self._command is not GripperCommand.HOLD:
            opens = self._command is GripperCommand.OPEN
            force = self._fraction * (self._limit if opens else -self._limit)
        code = max(DAC_MIN, min(DAC_MAX, round(force / self._force_per_code)))
        node.send(self._dac.frame(code, 0, node.cycle & 0xFF))


class GripperNode(FieldNode):
    """Node 7.

    Args:
        wire, boot_id: see ``FieldNode``.

    Attributes:
        controller: what drives the jaw; None without a configuration.
    """

    controller: GripperController | None

    def __init__(self, wire: Wire, boot_id: int) -> None:
        known, make = GRIPPER_PARAMETERS, self._make_controller
        needed = known - DEFAULTS.keys()
        super().__init__(GRIPPER, wire, boot_id, needed, known, make, self._drop)
        self._inputs = GripperInputs()
        self._dac = self._sends(Dac, GRIPPER)
        self._hears(Measure, GRIPPER, self._on_measure)
        self._hears(Gripper, None, self._on_gripper)
        self._hears_itself(Dac)

    @property
    def opening(self) -> float | None:
        """Jaw opening, m; None before homing."""
        return None if self.controller is None else self.controller.opening

    @property
    def resting(self) -> int:
        """Cycles the jaw has not moved by more than a count; 0 without a configuration."""
        return 0 if self.controller is None else self.controller.resting

    def _make_controller(self, parameters: Parameters) -> GripperController:
        return GripperController(self, parameters, self._inputs, self._dac)

    def _drop(self) -> None:
        """Drop the force immediately: one DAC frame with zero, and no more after it."""
        self.send(self._dac.frame(0, 0, self.cycle & 0xFF))

    def _on_gripper(self, gripper: Gripper) -> None:
        """A command acts from the next SYNC on."""
        inputs = self._inputs
        inputs.command, inputs.fraction = GripperCommand(gripper.command), gripper.force / 100.0

    def _on_measure(self, measure: Measure) -> None:
        controller = self.controller
        if controller is None or self.bus_state not in _CYCLING:
            return
        if measure.cycle != self.cycle & 0xFF:
            self.ignored["stale MEASURE"] += 1
            return
        controller.step(measure.counts)

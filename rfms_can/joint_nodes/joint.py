"""A joint node: the bus life of one joint, and the frames its controller works with.

Each frame of a cycle is checked for its cycle and kept in the ``CycleInputs``; then the controller
is asked to do what can be done now (``controller.py``, ``JointController.step``).
"""

from collections.abc import Callable
from functools import partial

from rfms_can.joint_nodes.compliance import RowSets
from rfms_can.joint_nodes.controller import JointController
from rfms_can.joint_nodes.field_node import FieldNode, Parameters
from rfms_can.joint_nodes.inputs import ALL_ERRORS, CycleInputs
from rfms_can.joint_nodes.servo import ServoTerms
from rfms_can.wire.configuration import JOINT_PARAMETERS, PARAMETERS
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import (
    Bias,
    Comply,
    Dac,
    JointAngles,
    JointError,
    Measure,
    Reference,
    Rows,
    Setpoint,
)

TermsSink = Callable[[int, ServoTerms], None]
"""Takes the cycle and the terms of each torque that goes out."""


class JointNode(FieldNode):
    """Joint node 1 to 6.

    Args:
        joint: its number.
        wire, boot_id: see ``FieldNode``.

    Attributes:
        controller: what drives the joint; None without a configuration.
        inputs: what has been received for the cycle under way.
        rows: active and arriving rows.
    """

    controller: JointController | None

    def __init__(self, joint: int, wire: Wire, boot_id: int) -> None:
        known, make = frozenset(PARAMETERS), self._make_controller
        super().__init__(joint, wire, boot_id, JOINT_PARAMETERS, known, make, self._drop)
        self.inputs = CycleInputs()
        self.rows = RowSets(joint)
        self._index = joint - 1
        self._sink: TermsSink | None = None
        self._dac = self._sends(Dac, joint)
        self._error = self._sends(JointError, joint)
        self._hears(Measure, joint, self._on_measure)
        self._hears(Reference, joint, self._on_reference)
        self._hears(Rows, joint, self.rows.receive)
        self._hears(Setpoint, 1, self._on_setpoint_1)
        self._hears(Setpoint, 2, self._on_setpoint_2)
        self._hears(JointAngles, 1, self._on_joint_setpoint_1)
        self._hears(JointAngles, 2, self._on_joint_setpoint_2)
        self._hears(Comply, None, self._on_comply)
        self._hears(Bias, None, self._on_bias)
        for other in JOINTS:
            if other != joint:
                self._hears(JointError, other, partial(self._on_error, other - 1))
        for record in (Dac, JointError):
            self._hears_itself(record)

    # --- what others may look at --------------------------------------------------------------

    @property
    def theta(self) -> float:
        """Measured joint angle, rad; 0 without a configuration."""
        return 0.0 if self.controller is None else self.controller.sensing.theta

    @property
    def speed(self) -> float:
        """Measured joint speed, rad/s; 0 without a configuration."""
        return 0.0 if self.controller is None else self.controller.sensing.speed

    @property
    def torque(self) -> float:
        """Last commanded torque, Nm; 0 without a configuration."""
        return 0.0 if self.controller is None else self.controller.torque

    def record_terms(self, sink: TermsSink | None) -> None:
        """Give each torque's terms to ``sink`` from now on; None ends it."""
        self._sink = sink
        if self.controller is not None:
            self.controller.record_terms(sink)

    # --- the controller -----------------------------------------------------------------------

    def _make_controller(self, parameters: Parameters) -> JointController:
        self.rows.clear()  # what came before was for another configuration
        controller = JointController(
            self, parameters, self.inputs, self.rows, self._dac, self._error
        )
        controller.record_terms(self._sink)
        return controller

    def _drop(self) -> None:
        if self.controller is not None:
            self.controller.drop_torque()

    # --- frames of a cycle --------------------------------------------------------------------

    def _is_stale(self, cycle: int, what: str) -> bool:
        if cycle == self.cycle & 0xFF:
            return False
        self.ignored[f"stale {what}"] += 1
        return True

    def _on_setpoint_1(self, setpoint: Setpoint) -> None:
        if not self._is_stale(setpoint.cycle & 0xFF, "SETPOINT"):
            self.inputs.setpoint = setpoint
            if self.controller is not None:
                self.controller.step()

    def _on_setpoint_2(self, setpoint: Setpoint) -> None:
        if not self._is_stale(setpoint.cycle & 0xFF, "SETPOINT"):
            self.inputs.second_setpoint = setpoint
            if self.controller is not None:
                self.controller.step()

    def _on_joint_setpoint_1(self, setpoint: JointAngles) -> None:
        if not self._is_stale(setpoint.cycle, "JOINT_SETPOINT"):
            self.inputs.joint_setpoint = setpoint
            if self.controller is not None:
                self.controller.step()

    def _on_joint_setpoint_2(self, setpoint: JointAngles) -> None:
        if not self._is_stale(setpoint.cycle, "JOINT_SETPOINT"):
            self.inputs.second_joint_setpoint = setpoint
            if self.controller is not None:
                self.controller.step()

    def _on_comply(self, comply: Comply) -> None:
        if not self._is_stale(comply.cycle, "COMPLY"):
            self.inputs.displacement = comply[self._index]
            if self.controller is not None:
                self.controller.step()

    def _on_bias(self, bias: Bias) -> None:
        if not self._is_stale(bias.cycle, "BIAS"):
            self.inputs.bias = bias[self._index]
            if self.controller is not None:
                self.controller.step()

    def _on_measure(self, measure: Measure) -> None:
        controller = self.controller
        if controller is None:
            return
        if not controller.action.any_sample and self._is_stale(measure.cycle, "MEASURE"):
            return
        inputs = self.inputs
        inputs.measure = measure
        inputs.sampled_in = measure.cycle
        inputs.new_sample = True
        controller.step()

    def _on_reference(self, reference: Reference) -> None:
        controller, inputs = self.controller, self.inputs
        if controller is None or not controller.homes or inputs.measure is None:
            return
        if not self._is_stale(reference.cycle, "REFERENCE"):
            inputs.reference = reference
            controller.step()

    def _on_error(self, index: int, error: JointError) -> None:
        inputs = self.inputs
        if error.cycle != self.cycle & 0xFF:
            self.ignored["stale ERROR"] += 1
            return
        inputs.take_error(index, error.error, error.error_rate, error.acceleration)
        if inputs.heard == ALL_ERRORS and self.controller is not None:
            self.controller.step()

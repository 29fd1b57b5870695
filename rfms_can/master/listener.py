"""What the master hears: joint angles, errors, answers of a cycle, heartbeats, emergencies."""

from functools import partial
from typing import Any

from rfms_can.arm import Arm
from rfms_can.dynamics.model import make_dynamics
from rfms_can.master.answers import MEASURES, REFERENCES, Answers, bit
from rfms_can.master.arm_state import ArmState
from rfms_can.master.broadcast import Broadcast
from rfms_can.master.math_processor import MathProcessor
from rfms_can.master.phases import Phase
from rfms_can.master.settings import MasterSettings
from rfms_can.master.start_up.bring_up import BringUp
from rfms_can.master.start_up.node_parameters import parameters_for
from rfms_can.node.endpoint import Endpoint
from rfms_can.wire.contract import ESTOP_VALUES, Wire
from rfms_can.wire.frame import IDENTIFIERS, Frame
from rfms_can.wire.nodes import GRIPPER, JOINTS, MASTER, NODE_NAMES, PLANT
from rfms_can.wire.records import (
    ConfigAck,
    Dac,
    Emcy,
    Estop,
    Force,
    Heartbeat,
    JointError,
    Measure,
    Reference,
    Rows,
)
from rfms_can.wire.vocabulary import FaultCode, NodeState, Parameter


class Listener(Endpoint):
    """The hearing half of the master; what follows from it is the supervisor's.

    Attributes:
        phase: what the master is doing with the bus.
        cycle: cycle under way; restarts at 0 when the arm is enabled.
        errors: joint errors of the cycle, rad (6).
        torques: what the nodes have set the motors to, Nm (6).
        force: reading of the wrist sensor, N and N m (6); None before the first.
        gains: K_p of the six nodes, N m/rad.
        arm_state: where the arm is.
        bring_up: who is on the bus, and what it holds.
        broadcast: what the master sends.
        heard_back: own frames heard when they had gone out.
    """

    def __init__(self, arm: Arm, wire: Wire, boot_id: int, settings: MasterSettings) -> None:
        super().__init__(MASTER, wire, boot_id)
        parameters = parameters_for(arm, settings)
        self.arm = arm
        self.settings = settings
        self.phase = Phase.ROLL_CALL
        self.cycle = -1
        self.errors = [0.0] * len(JOINTS)
        self.arm_state = ArmState(parameters)
        self.torques = [0.0] * len(JOINTS)
        self.force: tuple[float, ...] | None = None
        self.gains = tuple(parameters[joint][Parameter.KP] for joint in JOINTS)
        self._codes = [
            (p[Parameter.TORQUE_PER_CODE], p[Parameter.TORQUE_PER_FORCE_CODE])
            for p in (parameters[joint] for joint in JOINTS)
        ]
        natural = parameters[1][Parameter.NATURAL_FREQUENCY]
        model = make_dynamics(arm, settings.dynamics, settings.calibration)
        math = MathProcessor(arm, model, settings.law, self.gains, natural)
        self.broadcast = Broadcast(math, self._sends, wire.dbc_hash)
        self.bring_up = BringUp(wire, parameters, settings.patience_s, self.broadcast.nmt)
        self._senders.extend(self.bring_up.senders)
        self._answers = Answers(sensor=settings.sensor)
        self.heard_back = 0
        for joint in JOINTS:
            self._hears(Measure, joint, partial(self._on_measure, joint, bit("MEASURE", joint)))
            self._hears(
                Reference, joint, partial(self._on_reference, joint, bit("REFERENCE", joint))
            )
            self._hears(JointError, joint, partial(self._on_error, joint, bit("ERROR", joint)))
            self._hears_back(Rows, joint, partial(self._on_rows_sent, bit("ROWS", joint)))
        self._hears(Measure, GRIPPER, self._on_jaw)
        self._hears(Force, None, self._on_force)
        for node in (*JOINTS, GRIPPER):
            self._hears(Dac, node, partial(self._on_dac, node, bit("DAC", node)))
            self._hears(ConfigAck, node, partial(self._on_ack, node))
        for node in (*JOINTS, GRIPPER, PLANT):
            self._hears(
                Heartbeat,
                node,
                partial(self._on_heartbeat, node, bit("HEARTBEAT", node)),
                ordered=False,  # a node that restarts is to be noticed at once
            )
            self._hears(Emcy, node, partial(self._on_emergency, node), ordered=False)
        self._hears_back(Heartbeat, MASTER, self._on_beat_sent)
        self._hears(Estop, None, self._on_estop)
        self._estop = self._sends(Estop)
        self._urgent = False

    def _hears_back(self, record: type[Any], node: int, act: Any) -> None:
        """Hear an own frame when it has gone out: the transmit confirmation."""
        self._handlers[self.wire.id(record, node)] = (_as_is, act)

    @property
    def accepts(self) -> frozenset[int]:
        """What it acts on, and all that no node of ours sends, to count it."""
        known = {codec.id for codec in self.wire.codecs.values()}
        return super().accepts | (IDENTIFIERS - known)

    # --- what follows -------------------------------------------------------------------------

    def _close(self) -> None:
        """The cycle under way is over."""
        raise NotImplementedError

    def _halt(self, reason: str) -> None:
        """Something is wrong: latch it and stop everybody."""
        raise NotImplementedError

    def _all_present(self) -> None:
        """Every node has announced itself."""
        raise NotImplementedError

    def _all_configured(self) -> None:
        """Every node holds its configuration."""
        raise NotImplementedError

    # --- a cycle's frames ---------------------------------------------------------------------

    def _answered(self, one: int, _: object = None) -> None:
        """A frame of this cycle has come; with the last one the cycle is over."""
        missing = self._answers.missing
        if missing:
            missing = self._answers.missing = missing & ~one
            if not missing:
                self._close()

    def _on_measure(self, joint: int, one: int, measure: Measure) -> None:
        if measure.cycle == self.cycle & 0xFF:
            self.arm_state.measure(joint, measure)
            self._sampled(one)
        else:
            self.ignored["stale MEASURE"] += 1

    def _on_reference(self, joint: int, one: int, reference: Reference) -> None:
        if reference.cycle == self.cycle & 0xFF:
            self.arm_state.reference(joint, reference)
            self._sampled(one)
        else:
            self.ignored["stale REFERENCE"] += 1

    def _sampled(self, one: int) -> None:
        """When the whole arm has been sampled, the next rows go out."""
        samples = MEASURES | REFERENCES if self.phase is Phase.HOME else MEASURES
        if self._answers.missing & samples == one:
            self.broadcast.rows(self.arm_state.q, self._out)
        self._answered(one)

    def _on_beat_sent(self, _: Frame) -> None:
        self.heard_back += 1
        self._answered(bit("HEARTBEAT", MASTER))

    def _on_rows_sent(self, one: int, frame: Frame) -> None:
        self.heard_back += 1
        if self.broadcast.row_gone_out(frame):
            self._answered(one)

    def _on_jaw(self, measure: Measure) -> None:
        if measure.cycle == self.cycle & 0xFF:
            self.arm_state.jaw_counts = measure.counts
            self._answered(bit("MEASURE", GRIPPER))

    def _on_error(self, joint: int, one: int, error: JointError) -> None:
        if error.cycle == self.cycle & 0xFF:
            self.errors[joint - 1] = error.error
            self._answered(one)
        else:
            self.ignored["stale ERROR"] += 1

    def _on_dac(self, node: int, one: int, dac: Dac) -> None:
        if dac.cycle == self.cycle & 0xFF:
            if node != GRIPPER:
                current, force = self._codes[node - 1]
                self.torques[node - 1] = current * dac.current_dac + force * dac.force_dac
            self._answered(one)
        else:
            self.ignored["stale DAC"] += 1

    def _on_force(self, force: Force) -> None:
        if force.cycle == self.cycle & 0xFF:
            self.force = force[:6]
            self._answered(bit("FORCE", PLANT))
        else:
            self.ignored["stale FORCE"] += 1

    def emergency_stop(self, reason: str) -> None:
        """Torque off and brakes on everywhere: ESTOP goes out at the next step, with no wait."""
        self._out.append(self._estop.frame(*ESTOP_VALUES))
        self._urgent = True
        self._halt(reason)

    def lose(self, reason: str) -> None:
        """Latch a fault that whoever runs the nodes' processes has seen."""
        self._halt(reason)

    # --- how the nodes are --------------------------------------------------------------------

    def _on_heartbeat(self, node: int, one: int, beat: Heartbeat) -> None:
        wrong = self.bring_up.roster.hear(node, beat)
        stopped = beat.state in (NodeState.QUICKSTOP, NodeState.FAULT)
        if wrong is None and stopped and self.phase is Phase.RUN:
            wrong = f"{NODE_NAMES[node]} is in {NodeState(beat.state).name}"
        if wrong is not None:
            self._halt(wrong)
        elif self.phase is Phase.ROLL_CALL and not self.bring_up.roster.absent():
            self._all_present()
        self._answered(one)

    def _on_ack(self, node: int, ack: ConfigAck) -> None:
        if self.phase is not Phase.CONFIGURE:
            return
        self._out.extend(self.bring_up.acknowledge(node, ack))
        if self.bring_up.problem:
            self._halt(self.bring_up.problem)
        elif self.bring_up.configured:
            self._all_configured()

    def _on_emergency(self, node: int, emergency: Emcy) -> None:
        fault = FaultCode(emergency.fault).name
        self._halt(f"{NODE_NAMES[node]}: {fault} ({emergency.value:g})")

    def _on_estop(self, estop: Estop) -> None:
        if estop == ESTOP_VALUES:
            self._halt("emergency stop on the bus")


def _as_is(frame: Frame) -> Frame:
    return frame

"""The supervisor: runs the bus through its phases, and each control cycle from SYNC to close.

Cycle k: SYNC and SETPOINT go out; MEASURE comes, and the math processor's rows go out; ERROR and
DAC come; when all have answered the set-point of cycle k+1 is made (pipelined, Fig. 6.6) and the
cycle is closed. What a program asks for takes effect when the next cycle is closed, so its motion
is the same on every bus and clock.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

from rfms_can.arm import Arm
from rfms_can.cartesian_setpoint import CartesianSetpoint
from rfms_can.endpoint import Endpoint
from rfms_can.errors import KinematicsError, ProgramError
from rfms_can.frame import Frame
from rfms_can.master.answers import MEASURES, REFERENCES, Answers, bit
from rfms_can.master.arm_state import ArmState
from rfms_can.master.bring_up import BringUp
from rfms_can.master.math_processor import MathProcessor
from rfms_can.master.motion import Motion
from rfms_can.master.node_parameters import all_parameters
from rfms_can.master.phases import BUS_STATES, CYCLING, Phase, PhaseEvent, next_phase
from rfms_can.master.statistics import RunStatistics
from rfms_can.messages import GripperRequest, Message
from rfms_can.node import NOTHING
from rfms_can.setpoint_frames import values_of
from rfms_can.wire import (
    ESTOP_VALUES,
    GRIPPER,
    HEARTBEAT_EVERY,
    JOINTS,
    MASTER,
    NODE_NAMES,
    PLANT,
    Wire,
)
from rfms_can.wire.records import (
    ConfigAck,
    Dac,
    Emcy,
    Estop,
    Gripper,
    Heartbeat,
    JointError,
    Measure,
    Nmt,
    Reference,
    Rows,
    Setpoint,
    Sync,
)
from rfms_can.wire.vocabulary import (
    Blend,
    Clock,
    Command,
    FaultCode,
    GripperCommand,
    NodeState,
)

BRAKING_CYCLES: Final = 12
"""Cycles the master waits for the brakes after STOP before it ends all the same."""


@dataclass(frozen=True, slots=True)
class MasterSettings:
    """How the master runs the bus.

    Attributes:
        rate_hz: control cycles per second.
        clock: who says when a cycle begins.
        friction: friction set the servos compensate.
        blend: matching polynomial of transitions.
        barrier_s: longest lockstep cycle, s.
        patience_s: how long nodes may take to appear and to answer a configuration, s.
    """

    rate_hz: float = 250.0
    clock: Clock = Clock.VIRTUAL
    friction: str = "thesis"
    blend: Blend = Blend.CONTINUOUS
    barrier_s: float = 2.0
    patience_s: float = 30.0

    @property
    def period_ns(self) -> int:
        """Control period, ns."""
        return round(1e9 / self.rate_hz)


class Supervisor(Endpoint):
    """Node 8: supervisor and math processor.

    Attributes:
        phase: what it is doing with the bus.
        cycle: cycle under way; restarts at 0 when the arm is enabled.
        closed: control cycles closed since the first SYNC: programs wait by it.
        fault: why the run was halted, or None; latched.
        motion: programs' moves and the trajectory generator.
        arm_state: where the arm is.
        statistics: numbers of the run.
    """

    def __init__(self, arm: Arm, wire: Wire, boot_id: int, settings: MasterSettings) -> None:
        super().__init__(MASTER, wire, boot_id)
        period_s = settings.period_ns * 1e-9
        parameters = all_parameters(arm, settings.friction, period_s, settings.barrier_s)
        self.arm = arm
        self.settings = settings
        self.phase = Phase.ROLL_CALL
        self.cycle = -1
        self.closed = 0
        self.fault: str | None = None
        self.arm_state = ArmState(parameters)
        self.motion = Motion(arm, period_s, settings.blend)
        self.statistics = RunStatistics(period_s)
        self.math = MathProcessor(arm)
        self._lockstep = settings.clock is Clock.LOCKSTEP
        self._cycle_ns = round(settings.barrier_s * 1e9) if self._lockstep else settings.period_ns
        self._deadline_ns: int | None = 0
        self._answers = Answers()
        self._errors = [0.0] * len(JOINTS)
        self._sent_set = self._active_set = self._echoes = 0
        self._setpoint: CartesianSetpoint | None = None
        self._start_asked = self._stop_asked = False
        self._ending = 0
        self._gripper_asked = (GripperCommand.HOLD, 0.0)
        self._gripper_told: tuple[GripperCommand, float] | None = None
        self._gripper_next = self._gripper_asked
        self._sync = self._sends(Sync)
        self._nmt = self._sends(Nmt)
        self._gripper = self._sends(Gripper)
        self._poses = (self._sends(Setpoint, 1), self._sends(Setpoint, 2))
        self._rows = [self._sends(Rows, joint) for joint in JOINTS]
        self._emcy = self._sends(Emcy, MASTER)
        self.bring_up = BringUp(wire, parameters, settings.patience_s, self._nmt)
        self._senders.extend(self.bring_up.senders)
        self._listen()

    def _listen(self) -> None:
        """Who is heard, and what is done with it."""
        for joint in JOINTS:
            self._hears(Measure, joint, partial(self._on_measure, joint, bit("MEASURE", joint)))
            self._hears(
                Reference, joint, partial(self._on_reference, joint, bit("REFERENCE", joint))
            )
            self._hears(JointError, joint, partial(self._on_error, joint, bit("ERROR", joint)))
            self._hears_back(Rows, joint, partial(self._on_rows_sent, bit("ROWS", joint)))
        self._hears(Measure, GRIPPER, self._on_jaw)
        for node in (*JOINTS, GRIPPER):
            self._hears(Dac, node, partial(self._on_dac, bit("DAC", node)))
            self._hears(ConfigAck, node, partial(self._on_ack, node))
        for node in (*JOINTS, GRIPPER, PLANT):
            self._hears(Heartbeat, node, partial(self._on_heartbeat, node, bit("HEARTBEAT", node)))
            self._hears(Emcy, node, partial(self._on_emergency, node))
        self._hears_back(Heartbeat, MASTER, partial(self._answered, bit("HEARTBEAT", MASTER)))
        self._hears(Estop, None, self._on_estop)

    def _hears_back(self, record: type[Any], node: int, act: Any) -> None:
        """Hear an own frame when it has gone out: the transmit confirmation."""
        self._handlers[self.wire.id(record, node)] = (_as_is, act)

    # --- what programs ask --------------------------------------------------------------------

    def start(self) -> None:
        """Enable the arm at the next closed cycle (phase READY)."""
        self._start_asked = True

    def stop(self) -> None:
        """Disable the arm at the next closed cycle, brakes on, for good."""
        self._stop_asked = True

    def handle(self, message: Message) -> int:
        """Do what a program asks; see ``Motion.handle``.

        Raises:
            ProgramError: the request is refused; nothing has changed.
        """
        if self.phase is not Phase.RUN:
            raise ProgramError(
                f"the arm is not enabled (phase {self.phase.name}); nothing can be asked of it"
            )
        if isinstance(message, GripperRequest):
            opens = GripperCommand.OPEN if message.opens else GripperCommand.CLOSE
            self._gripper_asked = (opens, round(message.part * 200.0) / 2.0)
            return 0
        return self.motion.handle(message)

    # --- time ---------------------------------------------------------------------------------

    def next_deadline_ns(self) -> int | None:
        """Next SYNC, or in lockstep the barrier; before cycles run, the next call for nodes."""
        return self._deadline_ns

    def on_time(self, now_ns: int) -> Sequence[Frame]:
        """Begin the next cycle, closing an incomplete one; or call for nodes again."""
        deadline_ns = self._deadline_ns
        if deadline_ns is None or now_ns < deadline_ns:
            return NOTHING
        self._now_ns = now_ns
        if self.phase in CYCLING:
            if self._answers.missing:
                self._close_incomplete()  # in lockstep this begins the next one
            if self.settings.clock is Clock.REALTIME:
                self.statistics.late(now_ns - deadline_ns)
            if not self._lockstep:
                self._begin_cycle(deadline_ns)
        else:
            self._deadline_ns = now_ns + self.bring_up.retry_ns
            self._out.extend(self.bring_up.call(now_ns))
            if self.bring_up.problem:
                self._halt(self.bring_up.problem)
        return self._flush()

    def _begin_cycle(self, now_ns: int) -> None:
        """SYNC, and with it all that the master knows of this cycle already."""
        if self._deadline_ns is None:
            return
        self._deadline_ns = now_ns + self._cycle_ns
        cycle = self.cycle = self.cycle + 1
        out, settings = self._out, self.settings
        state = BUS_STATES[self.phase]
        out.append(
            self._sync.frame(cycle, state, self._active_set, self.wire.dbc_hash, settings.clock)
        )
        self._answers.begin(self.phase, cycle)
        if self.phase is Phase.RUN:
            self._send_setpoint(cycle)
        if cycle % HEARTBEAT_EVERY == 0:
            self._beat(state, int(self.fault is not None))

    def _send_setpoint(self, cycle: int) -> None:
        """SETPOINT, and GRIPPER when it changes or its time has come."""
        setpoint, out = self._setpoint, self._out
        if setpoint is not None:
            first, second = self._poses
            pose, configuration = setpoint.T6_1, setpoint.configuration_1
            out.append(first.frame(*values_of(setpoint, pose, configuration, cycle)))
            if setpoint.T6_2 is not None:
                pose, configuration = setpoint.T6_2, setpoint.configuration_2
                out.append(second.frame(*values_of(setpoint, pose, configuration, cycle)))
        if self._gripper_next != self._gripper_told or cycle % HEARTBEAT_EVERY == 0:
            self._gripper_told = self._gripper_next
            out.append(self._gripper.frame(*self._gripper_next, cycle & 0xFF))

    # --- the end of a cycle -------------------------------------------------------------------

    def _answered(self, one: int, _: object = None) -> None:
        """A frame of this cycle has come; with the last one the cycle is over."""
        missing = self._answers.missing
        if missing:
            missing = self._answers.missing = missing & ~one
            if not missing:
                self._close()

    def _close_incomplete(self) -> None:
        """The cycle's time is over and somebody has not answered."""
        self.statistics.miss(self._answers.describe())
        lost = self._answers.unanswered(self.cycle)
        self._answers.missing = 0
        if lost and self.phase is not Phase.END:
            self._halt(lost)
        self._close()

    def _close(self) -> None:
        """All have answered, or their time is over: change phase, make the next set-point."""
        self.closed += 1
        step = _AT_CLOSE.get(self.phase)
        if step is not None:
            step(self)
        self._gripper_next = self._gripper_asked
        if self._lockstep:
            self._begin_cycle(self._now_ns)

    def _close_homing(self) -> None:
        if self.arm_state.referenced and self.bring_up.roster.all_in(NodeState.READY):
            self.phase = next_phase(self.phase, PhaseEvent.ALL_HOMED)

    def _close_ready(self) -> None:
        if self._stop_asked:
            self._end()
        elif self._start_asked:
            self._enable()

    def _close_running(self) -> None:
        self.statistics.cycles += 1
        if self._stop_asked:
            self._end()
            return
        self.statistics.errors(self._errors, self.motion.moves)
        self._make_setpoint()

    def _close_halted(self) -> None:
        if self._stop_asked:
            self._end()

    def _close_ending(self) -> None:
        self._ending += 1
        if all(self.arm_state.braked) or self._ending >= BRAKING_CYCLES:
            self._deadline_ns = None

    def _make_setpoint(self) -> None:
        setpoint, refusal = self.motion.next_setpoint()
        if refusal is not None:
            self._halt(f"set-point refused before it was sent: {refusal}")
            return
        self._setpoint = setpoint

    def _enable(self) -> None:
        """START: all counters begin anew, cycle 0 is next, and the arm holds where it is."""
        self._start_asked = False
        try:
            self.motion.enable(self.arm_state.q)
        except KinematicsError as error:
            self._halt(str(error))
            return
        self.phase = next_phase(self.phase, PhaseEvent.START)
        self._out.append(self._nmt.frame(Command.START, 0, 0))
        self._restart_counters()
        self.cycle = -1
        self._make_setpoint()

    def _end(self) -> None:
        """Torque off, brakes on: STOP from motion, RESET out of a controlled stop."""
        command = Command.RESET if self.phase is Phase.HALT else Command.STOP
        self._out.append(self._nmt.frame(command, 0, 0))
        self.phase = next_phase(self.phase, PhaseEvent.STOP)

    @property
    def ended(self) -> bool:
        """Whether the arm is disabled for good and braked, and nothing more will be sent."""
        return self.phase is Phase.END and self._deadline_ns is None

    def _halt(self, reason: str) -> None:
        """Latch a fault: everyone stops, nothing re-enables."""
        if self.phase is Phase.END:
            return
        if self.fault is None:
            self.fault = reason
        if self.phase is not Phase.HALT:
            cycling = self.phase in CYCLING
            self.phase = next_phase(self.phase, PhaseEvent.FAULT)
            self.motion.generator.disable()
            self._out.append(self._nmt.frame(Command.QUICKSTOP, 0, 0))
            if not cycling:
                self._deadline_ns = None

    # --- what comes in ------------------------------------------------------------------------

    def _on_measure(self, joint: int, one: int, measure: Measure) -> None:
        if measure.cycle != self.cycle & 0xFF:
            self.ignored["stale MEASURE"] += 1
            return
        self.arm_state.measure(joint, measure)
        self._measured(one)

    def _on_reference(self, joint: int, one: int, reference: Reference) -> None:
        self.arm_state.reference(joint, reference)
        self._measured(one)

    def _measured(self, one: int) -> None:
        """When the whole arm has been measured, the next rows go out."""
        sampled = MEASURES | REFERENCES if self.phase is Phase.HOME else MEASURES
        if self._answers.missing & sampled == one:
            self._send_rows()
        self._answered(one)

    def _send_rows(self) -> None:
        self._sent_set, rows = self.math.rows(self.arm_state.q)
        self._echoes = 0
        self._out.extend(
            sender.frame(*values) for sender, values in zip(self._rows, rows, strict=True)
        )

    def _on_rows_sent(self, one: int, _: Frame) -> None:
        self._echoes += 1
        if self._echoes == len(JOINTS):
            self._active_set = self._sent_set
        self._answered(one)

    def _on_jaw(self, measure: Measure) -> None:
        if measure.cycle == self.cycle & 0xFF:
            self.arm_state.jaw_counts = measure.counts
            self._answered(bit("MEASURE", GRIPPER))

    def _on_error(self, joint: int, one: int, error: JointError) -> None:
        if error.cycle == self.cycle & 0xFF:
            self._errors[joint - 1] = error.error
            self._answered(one)
        else:
            self.ignored["stale ERROR"] += 1

    def _on_dac(self, one: int, dac: Dac) -> None:
        if dac.cycle == self.cycle & 0xFF:
            self._answered(one)
        else:
            self.ignored["stale DAC"] += 1

    def _on_heartbeat(self, node: int, one: int, beat: Heartbeat) -> None:
        wrong = self.bring_up.roster.hear(node, beat)
        stopped = beat.state in (NodeState.QUICKSTOP, NodeState.FAULT)
        if wrong is None and stopped and self.phase is Phase.RUN:
            wrong = f"{NODE_NAMES[node]} is in {NodeState(beat.state).name}"
        if wrong is not None:
            self._halt(wrong)
        elif self.phase is Phase.ROLL_CALL and not self.bring_up.roster.absent():
            self.phase = next_phase(self.phase, PhaseEvent.ALL_PRESENT)
            self._out.extend(self.bring_up.configure(self._now_ns))
        self._answered(one)

    def _on_ack(self, node: int, ack: ConfigAck) -> None:
        if self.phase is not Phase.CONFIGURE:
            return
        self._out.extend(self.bring_up.acknowledge(node, ack))
        if self.bring_up.problem:
            self._halt(self.bring_up.problem)
        elif self.bring_up.configured:
            self.phase = next_phase(self.phase, PhaseEvent.ALL_CONFIGURED)
            self._out.append(self._nmt.frame(Command.HOME, 0, 0))
            self._begin_cycle(self._now_ns)

    def _on_emergency(self, node: int, emergency: Emcy) -> None:
        fault = FaultCode(emergency.fault).name
        self._halt(f"{NODE_NAMES[node]}: {fault} ({emergency.value:g})")

    def _on_estop(self, estop: Estop) -> None:
        if estop == ESTOP_VALUES:
            self._halt("emergency stop on the bus")


def _as_is(frame: Frame) -> Frame:
    return frame


_AT_CLOSE: Final = {
    Phase.HOME: Supervisor._close_homing,
    Phase.READY: Supervisor._close_ready,
    Phase.RUN: Supervisor._close_running,
    Phase.HALT: Supervisor._close_halted,
    Phase.END: Supervisor._close_ending,
}

"""The master on the bus: node 8, master and math processor of the thesis.

One cycle through the code: a SYNC (``cycle.ControlCycle.begin``), frames (here, to
``inputs.CycleInputs``), rows when the arm is sampled (``ControlCycle.send_rows``), and the end of
the cycle (``ControlCycle.close``).
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from rfms_can.arm import Arm
from rfms_can.compliance import LAWS
from rfms_can.dynamics.model import NONE, make_dynamics
from rfms_can.errors import FaultError, ProgramError
from rfms_can.master.answers import bit
from rfms_can.master.arm_state import ArmState
from rfms_can.master.broadcast import Broadcast
from rfms_can.master.cycle import ControlCycle, Parts
from rfms_can.master.force.control import ForceControl, ForceSettings
from rfms_can.master.inputs import CycleInputs
from rfms_can.master.motion import NOTED, Motion
from rfms_can.master.phases import BUS_STATES, NO_RESET, Phase, PhaseEvent, PhaseMachine
from rfms_can.master.requests import ProgramRequests
from rfms_can.master.rows.math_processor import MathProcessor
from rfms_can.master.rows.sets import RowSets
from rfms_can.master.settings import MasterSettings
from rfms_can.master.start_up.bring_up import BringUp
from rfms_can.master.start_up.node_parameters import Parameters, parameters_for
from rfms_can.master.start_up.suspects import Suspects
from rfms_can.master.statistics import RunStatistics
from rfms_can.master.stillness import Stillness
from rfms_can.master.timer import CycleTimer
from rfms_can.master.verification import Verification
from rfms_can.messages import Answer, Message, ResetRequest
from rfms_can.node.port_counts import PortTellingEndpoint
from rfms_can.node.protocol import NOTHING
from rfms_can.wire.contract import ESTOP_VALUES, Wire
from rfms_can.wire.emergency import in_words as emergency_in_words
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

_OWN_HEARTBEAT = bit("HEARTBEAT", MASTER)


class MasterNode(PortTellingEndpoint):
    """Builds the parts of the master, and hands them frames and time.

    Args:
        arm: the arm on the bus.
        wire: compiled codecs.
        boot_id: changes with every start.
        settings: how the bus is run.

    Attributes:
        arm, settings: the same.
        machine: the phase, and the latched fault.
        timer: when cycles begin.
        arm_state: where the arm is.
        inputs: what the cycle under way has brought.
        broadcast: packs SYNC, set-points and commands.
        rows: the sets of rows.
        bring_up: who is on the bus, and what it holds.
        suspects: what a silent node has sent instead.
        force_control: compliance, bias force and guarded moves.
        motion: programs' moves and the trajectory generator.
        statistics: numbers of the run.
        stillness: for how long arm and jaw have stood still.
        verification: whether the joints are where they were commanded to be.
        requests: of programs.
        cycle: begins and closes control cycles.
        heard_back: own frames heard when they had gone out.
    """

    def __init__(self, arm: Arm, wire: Wire, boot_id: int, settings: MasterSettings) -> None:
        super().__init__(MASTER, wire, boot_id)
        self.arm = arm
        self.settings = settings
        self.heard_back = 0
        parameters = parameters_for(arm, settings)
        period_s = settings.period_ns * 1e-9
        gains = tuple(parameters[joint][Parameter.KP] for joint in JOINTS)
        natural = parameters[JOINTS[0]][Parameter.NATURAL_FREQUENCY]

        self.machine = PhaseMachine()
        self.timer = CycleTimer(settings)
        self.arm_state = ArmState(parameters)
        self.inputs = CycleInputs(
            self.arm_state,
            _torque_scales(parameters),
            self.ignored,
            self._send_rows,
            self._close_cycle,
            sensor=settings.sensor,
        )
        model = make_dynamics(arm, settings.dynamics, settings.calibration)
        math = MathProcessor(arm, model, settings.law, gains, natural)
        self.broadcast = Broadcast(self._sends, wire.dbc_hash)
        self.rows = RowSets(math, self._sends, arm.park)
        self.bring_up = BringUp(wire, parameters, settings.patience_s, self.broadcast.nmt)
        self.suspects = Suspects(self.bring_up.roster, self.bad_frames)
        force_settings = ForceSettings(settings.law, settings.closed, settings.friction, gains)
        self.force_control = ForceControl(arm, force_settings, period_s)
        self.motion = Motion(
            *(arm, period_s, settings.blend, self.force_control.refusal),
            *(settings.replans, settings.effort),
        )
        self.statistics = RunStatistics(period_s)
        self.stillness = Stillness(arm)
        self.verification = Verification(
            parameters,
            modelled=settings.dynamics != NONE,
            parts_directions=LAWS[settings.law].parts_directions,
            largest=settings.following_error,
        )
        self.requests = ProgramRequests(
            self.machine,
            self.motion,
            self.force_control,
            self.stillness,
            self.rows,
            sensor=settings.sensor,
        )
        parts = Parts(
            machine=self.machine,
            timer=self.timer,
            inputs=self.inputs,
            broadcast=self.broadcast,
            rows=self.rows,
            bring_up=self.bring_up,
            requests=self.requests,
            motion=self.motion,
            force_control=self.force_control,
            statistics=self.statistics,
            stillness=self.stillness,
            verification=self.verification,
            suspects=self.suspects,
        )
        self.cycle = ControlCycle(parts, self._beat, self._restart_counters)

        self._senders.extend(self.bring_up.senders)
        self._estop = self._sends(Estop)
        self._hear_all()

    def _hear_all(self) -> None:
        """Register what is heard, and which part takes it."""
        inputs = self.inputs
        for joint in JOINTS:
            takes: tuple[tuple[type[Any], str, Callable[..., None]], ...] = (
                (Measure, "MEASURE", inputs.on_measure),
                (Reference, "REFERENCE", inputs.on_reference),
                (JointError, "ERROR", inputs.on_error),
            )
            for record, kind, take in takes:
                self._hears(record, joint, partial(take, joint, bit(kind, joint)))
            self._hears_back(Rows, joint, partial(self._on_rows_sent, bit("ROWS", joint)))
        self._hears(Measure, GRIPPER, inputs.on_jaw)
        self._hears(Force, None, inputs.on_force)
        for node in (*JOINTS, GRIPPER):
            self._hears(Dac, node, partial(inputs.on_dac, node, bit("DAC", node)))
            self._hears(ConfigAck, node, partial(self._on_ack, node))
        for node in (*JOINTS, GRIPPER, PLANT):
            answer = bit("HEARTBEAT", node)
            self._hears(Heartbeat, node, partial(self._on_heartbeat, node, answer))
            self._hears(Emcy, node, partial(self._on_emergency, node))
        self._hears_back(Heartbeat, MASTER, self._on_beat_sent)
        self._hears(Estop, None, self._on_estop)

    def _hears_back(self, record: type[Any], node: int, act: Callable[[Frame], None]) -> None:
        """Hear an own frame when it has gone out: the transmit confirmation."""
        self._handlers[self.wire.id(record, node)] = (_as_is, act)

    @property
    def accepts(self) -> frozenset[int]:
        """What it acts on, and all that no node of ours sends, to count it."""
        known = {codec.id for codec in self.wire.codecs.values()}
        return super().accepts | (IDENTIFIERS - known)

    # --- for those who run it -----------------------------------------------------------------

    @property
    def phase(self) -> Phase:
        """What the master is doing with the bus."""
        return self.machine.phase

    @property
    def fault(self) -> str | None:
        """Why the run was halted, or None; latched."""
        return self.machine.fault

    @property
    def emergency(self) -> str | None:
        """Reason of the emergency stop in force, or None; latched until a person lifts it."""
        return self.machine.emergency

    @property
    def closed(self) -> int:
        """Control cycles closed since the first SYNC."""
        return self.cycle.closed

    @property
    def ended(self) -> bool:
        """Whether the arm is disabled for good and braked, and nothing more will be sent."""
        return self.machine.phase is Phase.END and self.timer.stopped

    def start(self) -> None:
        """Enable the arm at the next closed cycle (phase READY)."""
        self.requests.start()

    def stop(self) -> None:
        """Disable the arm at the next closed cycle, brakes on, for good."""
        self.requests.stop()
        if not self.machine.cycling:  # no node drives yet
            self.machine.change(PhaseEvent.STOP)
            self.timer.stop()

    def handle(self, message: Message) -> Answer:
        """Do what a program asks; see :meth:`ProgramRequests.handle`.

        Raises:
            ProgramError: the request is refused; nothing has changed.
            FaultError: a reset while an emergency stop is in force.
        """
        if isinstance(message, ResetRequest):
            self.reset()
            return NOTED
        return self.requests.handle(message)

    def reset(self) -> None:
        """Leave a fault: the nodes are reset, homed where their reference is lost, and enabled.

        A cause that persists is a fault again, with its own reason. Moves were dropped by the
        fault; symbol tables stay, force requests do not.

        Raises:
            ProgramError: there is no fault to leave.
            FaultError: an emergency stop is in force.
        """
        machine = self.machine
        refusal = NO_RESET[machine.phase]
        if refusal is not None:
            raise ProgramError(f"reset in phase {machine.phase.name}: {refusal}")
        if machine.emergency is not None:
            raise FaultError(
                f"reset: an emergency stop is in force ({machine.emergency}): a person lifts it at "
                "the server's command line, rfms reset --lift-emergency-stop"
            )
        machine.reset()
        self.requests.start()
        if self.timer.stopped:  # no cycles run: there is nothing to wait for
            self.cycle.call_nodes(self._now_ns)

    def lift_emergency_stop(self) -> bool:
        """Lift the emergency stop for a person; the arm stays halted. Whether one was in force."""
        return self.machine.lift()

    def emergency_stop(self, reason: str) -> None:
        """Torque off and brakes on everywhere: ESTOP goes out at the next step, with no wait."""
        self._out.append(self._estop.frame(*ESTOP_VALUES))
        self.timer.send_now()
        self.cycle.halt(reason, self._out, emergency=True)

    def lose(self, reason: str) -> None:
        """Latch a fault that was seen beside the bus: the process of a node has ended."""
        self._halt(reason)

    # --- time ---------------------------------------------------------------------------------

    def next_deadline_ns(self) -> int | None:
        """Next SYNC, or in lockstep the barrier; before cycles run, the next call for nodes."""
        return self.timer.deadline_ns

    def on_time(self, now_ns: int) -> Sequence[Frame]:
        """Begin the next cycle, closing an incomplete one; or call for nodes again."""
        timer = self.timer
        if timer.take_urgent():
            return self._flush()
        deadline_ns = timer.due(now_ns)
        if deadline_ns is None:
            return NOTHING
        self._now_ns = now_ns
        if not self.machine.cycling:
            self._call_nodes(now_ns)
            return self._flush()
        complete = self.inputs.complete
        if not complete:
            self.cycle.close_incomplete(now_ns, self._out)  # in lockstep this begins the next one
        if timer.realtime:
            self.statistics.late(now_ns - deadline_ns)
        if complete or not timer.lockstep:
            self.cycle.begin(deadline_ns, now_ns, self._out)
        return self._flush()

    def _call_nodes(self, now_ns: int) -> None:
        frames = self.bring_up.call(now_ns)
        self.timer.retry(now_ns + self.bring_up.retry_ns)
        if self.machine.phase is Phase.ROLL_CALL:
            self._beat(BUS_STATES[Phase.ROLL_CALL])
        self._out.extend(frames)
        if self.bring_up.problem:
            self._halt(f"{self.bring_up.problem}{self.suspects.all_bad()}")

    # --- frames of a cycle; most go to the inputs ---------------------------------------------

    def _send_rows(self) -> None:
        self.cycle.send_rows(self._out)

    def _close_cycle(self) -> None:
        self.cycle.close(self._now_ns, self._out)

    def _on_beat_sent(self, _: Frame) -> None:
        self.heard_back += 1
        self.inputs.answered(_OWN_HEARTBEAT)

    def _on_rows_sent(self, answer: int, frame: Frame) -> None:
        self.heard_back += 1
        if self.rows.gone_out(frame):
            self.inputs.answered(answer)

    # --- how the nodes are --------------------------------------------------------------------

    def _on_heartbeat(self, node: int, answer: int, beat: Heartbeat) -> None:
        machine, roster = self.machine, self.bring_up.roster
        self._note_boot(node, beat.boot_id)
        if machine.phase is Phase.RESET:  # how it is is asked when it has been reset
            self.inputs.answered(answer)
            return
        wrong = roster.hear(node, beat)
        stopped = beat.state in (NodeState.QUICKSTOP, NodeState.FAULT)
        if wrong is None and stopped and machine.phase is Phase.RUN:
            wrong = f"{NODE_NAMES[node]} is in {NodeState(beat.state).name}"
        if wrong is not None:
            self._halt(wrong)
        elif machine.phase is Phase.ROLL_CALL and self.bring_up.all_present:
            machine.change(PhaseEvent.ALL_PRESENT)
            self._out.extend(self.bring_up.configure(self._now_ns))
            for joint in self.bring_up.unreferenced & set(JOINTS):
                self.arm_state.forget(joint)
            if self.bring_up.configured:  # a reset: all have kept what they were told
                self._begin_homing()
        self.inputs.answered(answer)

    def _on_ack(self, node: int, ack: ConfigAck) -> None:
        machine, bring_up = self.machine, self.bring_up
        if machine.phase is not Phase.CONFIGURE:
            return
        self._out.extend(bring_up.acknowledge(node, ack))
        if bring_up.problem:
            self._halt(bring_up.problem)
        elif bring_up.configured:
            self._begin_homing()

    def _begin_homing(self) -> None:
        self.cycle.begin_homing(self._now_ns, self._out)

    def _on_emergency(self, node: int, emergency: Emcy) -> None:
        """A fault halts the arm; what an earlier run or fault left behind ends with the reset.

        A second node of its number is there now, whenever a node tells of it.
        """
        before = self.machine.phase in (Phase.RESET, Phase.ROLL_CALL)
        if before and emergency.fault != FaultCode.DUPLICATE_NODE:
            return
        self._halt(f"{NODE_NAMES[node]}: {emergency_in_words(self.wire, node, emergency)}")

    def _on_estop(self, estop: Estop) -> None:
        if estop == ESTOP_VALUES:
            self.cycle.halt("emergency stop on the bus", self._out, emergency=True)

    def _halt(self, reason: str) -> None:
        self.cycle.halt(reason, self._out)


def _torque_scales(parameters: dict[int, Parameters]) -> list[tuple[float, float]]:
    """Motor torque per code of the current DAC and of the fine DAC, Nm (6, 2)."""
    of_joints = [parameters[joint] for joint in JOINTS]
    return [(p[Parameter.TORQUE_PER_CODE], p[Parameter.TORQUE_PER_FORCE_CODE]) for p in of_joints]


def _as_is(frame: Frame) -> Frame:
    return frame

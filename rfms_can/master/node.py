"""The master on the bus: node 8, master and math processor of the thesis.

One cycle through the code: a SYNC (``cycle.ControlCycle.begin``), frames (here, to
``inputs.CycleInputs``), rows when the arm is sampled (``ControlCycle.send_rows``), and the end of
the cycle (``ControlCycle.close``).
"""

from collections.abc import Callable, Collection, Sequence
from functools import partial
from typing import Any, Final

from rfms_can.arm import Arm
from rfms_can.compliance import LAWS
from rfms_can.dynamics.model import NONE, make_dynamics
from rfms_can.errors import FaultError, ProgramError
from rfms_can.master.answers import bit
from rfms_can.master.arm_state import ArmState
from rfms_can.master.blame import blame
from rfms_can.master.broadcast import Broadcast
from rfms_can.master.corruption import Corruption, Watched
from rfms_can.master.cycle import ControlCycle, Parts
from rfms_can.master.fault import Fault
from rfms_can.master.force.control import ForceControl, ForceSettings
from rfms_can.master.inputs import CycleInputs
from rfms_can.master.lateness import Lateness
from rfms_can.master.motion import NOTED, Motion
from rfms_can.master.own_frames import OwnFrames
from rfms_can.master.phases import BUS_STATES, NO_RESET, Phase, PhaseEvent, PhaseMachine
from rfms_can.master.requests import ProgramRequests
from rfms_can.master.rows.math_processor import MathProcessor
from rfms_can.master.rows.sets import RowSets
from rfms_can.master.settings import MasterSettings
from rfms_can.master.start_up.bring_up import BringUp, heartbeat_fault
from rfms_can.master.start_up.node_parameters import Parameters, parameters_for
from rfms_can.master.start_up.suspects import Suspects
from rfms_can.master.statistics import RunStatistics
from rfms_can.master.stillness import Stillness
from rfms_can.master.timer import CycleTimer
from rfms_can.master.traffic import Message as DueMessage
from rfms_can.master.traffic import Traffic
from rfms_can.master.verification import Verification
from rfms_can.messages import Answer, Message, ResetRequest
from rfms_can.messages.culprit import OPERATOR, Culprit
from rfms_can.node.port_counts import PortTellingEndpoint
from rfms_can.node.protocol import NOTHING
from rfms_can.wire.contract import ESTOP_VALUES, Wire
from rfms_can.wire.frame import IDENTIFIERS, Frame
from rfms_can.wire.nodes import (
    DBC_NAMES,
    GRIPPER,
    HEARTBEAT_EVERY,
    JOINTS,
    MASTER,
    NODE_NAMES,
    PLANT,
)
from rfms_can.wire.protection import Refusal
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
    Setpoint,
    Sync,
)
from rfms_can.wire.vocabulary import FaultCode, NodeState, Parameter

_OWN_HEARTBEAT = bit("HEARTBEAT", MASTER)
_UNSCHEDULED: Final = frozenset(("EMCY", "ESTOP", "NMT", "CONFIG", "CONFIG_ACK"))
"""Messages that do not come by the cycle."""
_ALONE: Final = frozenset((Phase.HALT, Phase.RESET, Phase.END))
"""Phases in which a second master changes nothing: this one does not drive."""


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
        own_frames: what it has sent, and has heard back when it had gone out.
        traffic: who takes too much of the bus.
        lateness: whether it is late itself.
        corruption: who sends bad frames again and again.
    """

    def __init__(self, arm: Arm, wire: Wire, boot_id: int, settings: MasterSettings) -> None:
        super().__init__(MASTER, wire, boot_id)
        self.arm = arm
        self.settings = settings
        self._listening = settings.listening_s > 0.0
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
        self._senders.extend(self.bring_up.senders)
        self.own_frames = OwnFrames(self._own_identifiers())
        self._hear_all()
        self._by_identifier = {r.decoder.codec.id: r for r in self._receivers}
        self.corruption = Corruption(self._watched())
        scheduled = not self.timer.lockstep
        self.traffic = Traffic(self._due(), settings.bus_time if scheduled else None)
        self.lateness = Lateness(settings.period_ns, scheduled=scheduled)
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
            own_frames=self.own_frames,
            traffic=self.traffic,
            lateness=self.lateness,
            corruption=self.corruption,
            setpoint_id=wire.id(Setpoint, 1),
        )
        self.cycle = ControlCycle(parts, self._beat, self._restart_counters)

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
        self._hears(Measure, GRIPPER, inputs.on_jaw)
        self._hears(Force, None, inputs.on_force)
        for node in (*JOINTS, GRIPPER):
            self._hears(Dac, node, partial(inputs.on_dac, node, bit("DAC", node)))
            self._hears(ConfigAck, node, partial(self._on_ack, node))
        for node in (*JOINTS, GRIPPER, PLANT):
            answer = bit("HEARTBEAT", node)
            self._hears(Heartbeat, node, partial(self._on_heartbeat, node, answer))
            self._hears(Emcy, node, partial(self._on_emergency, node))
        self._hears(Estop, None, self._on_estop)
        # own frames, when they have gone out: the transmit confirmation
        for identifier in self._own_identifiers():
            self._handlers[identifier] = (self._confirmed, _nothing_more)
        for joint in JOINTS:
            rows = partial(self._on_rows_sent, bit("ROWS", joint))
            self._handlers[self.wire.id(Rows, joint)] = (self._confirmed, rows)
        beat, sync = self.wire.id(Heartbeat, MASTER), self.wire.id(Sync)
        self._handlers[beat] = (self._confirmed, self._on_beat_sent)
        self._handlers[sync] = (self._confirmed, self._on_sync_sent)

    def _own_identifiers(self) -> frozenset[int]:
        """Of the messages that the master alone sends."""
        own = {sender.codec.id for sender in self._senders}
        return frozenset(own - {self.wire.id(Estop)})

    def _due(self) -> dict[int, DueMessage]:
        """The messages that come by the cycle, by identifier."""
        due: dict[int, DueMessage] = {}
        for name, codec in self.wire.codecs.items():
            kind = name.rstrip("0123456789").rstrip("_")
            if codec.id in self._handlers and kind not in _UNSCHEDULED:
                due[codec.id] = DueMessage(name, _sender_of(codec.senders), codec.length)
        return due

    def _watched(self) -> dict[int, Watched]:
        """The messages that a cycle waits for, by identifier."""
        answers: list[tuple[type[Any], str, Sequence[int], int]] = [
            (Measure, "MEASURE", (*JOINTS, GRIPPER), PLANT),
            (Reference, "REFERENCE", JOINTS, PLANT),
            (JointError, "ERROR", JOINTS, 0),
            (Dac, "DAC", (*JOINTS, GRIPPER), 0),
            (Heartbeat, "HEARTBEAT", (*JOINTS, GRIPPER, PLANT), 0),
        ]
        return {
            self.wire.id(record, node): Watched(
                f"{kind}_{node}",
                NODE_NAMES[sender or node],
                bit(kind, node),
                HEARTBEAT_EVERY if record is Heartbeat else 1,
            )
            for record, kind, nodes, sender in answers
            for node in nodes
        }

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
    def heard_back(self) -> int:
        """Own frames that have gone out, by their transmit confirmation."""
        return self.own_frames.confirmed

    @property
    def culprit(self) -> Culprit | None:
        """Who is to blame for the fault, or None."""
        return self.machine.culprit

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
        self._out.append(self.broadcast.emergency_stop())
        self.timer.send_now()
        self.cycle.halt(Fault(reason, Culprit(OPERATOR, "ESTOP")), self._out, emergency=True)

    def lose(self, reason: str, sender: str = "") -> None:
        """Latch a fault that was seen beside the bus: the process of a node has ended."""
        self._halt(Fault(reason, Culprit(sender)))

    # --- time ---------------------------------------------------------------------------------

    def next_deadline_ns(self) -> int | None:
        """Next SYNC, or in lockstep the barrier; before cycles run, the next call for nodes.

        Before that the instant from which its own SYNC is late too often.
        """
        deadline_ns, late_ns = self.timer.deadline_ns, self.lateness.deadline_ns
        if late_ns is None or deadline_ns is None or self.machine.phase is not Phase.RUN:
            return deadline_ns
        return min(deadline_ns, late_ns)

    def on_frame(self, frame: Frame, now_ns: int) -> Sequence[Frame]:
        """Receive a frame: count it, refuse it, or pass its values to its handler."""
        identifier = frame.id
        handler = self._handlers.get(identifier)
        if handler is None:
            self.foreign += 1
            self.traffic.hear_foreign(frame)
            return NOTHING
        self._now_ns = now_ns
        counts = self.traffic.counts
        if identifier in counts:
            counts[identifier] += 1
        take, act = handler
        values = take(frame)
        if values is not None:
            act(values)
        else:
            self._on_refused(frame)
        return self._flush() if self._out else NOTHING

    def _flush(self) -> Sequence[Frame]:
        """The frames collected to send; their confirmation is waited for."""
        for frame in self._out:
            self.own_frames.sent(frame)
        return super()._flush()

    def _on_refused(self, frame: Frame) -> None:
        """A frame was refused: not for its counter, but for what it carries."""
        receiver = self._by_identifier.get(frame.id)
        if receiver is not None:
            result = receiver.decoder.decode(frame)
            if isinstance(result, Refusal):
                self.corruption.refused(frame.id, result.value)

    def on_time(self, now_ns: int) -> Sequence[Frame]:
        """Begin the next cycle, closing an incomplete one; or call for nodes again."""
        timer = self.timer
        if timer.take_urgent():
            return self._flush()
        deadline_ns = timer.due(now_ns)
        if self.machine.phase is Phase.RUN:
            self._judge_lateness(deadline_ns, now_ns)
        if deadline_ns is None:
            return self._flush()
        self._now_ns = now_ns
        if not self.machine.cycling:
            if self._listening:  # to those who are there already, before anything is sent
                self._listening = False
                self.timer.retry(now_ns + round(self.settings.listening_s * 1e9))
            else:
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

    def _judge_lateness(self, deadline_ns: int | None, now_ns: int) -> None:
        number = self.cycle.number
        fault = self.lateness.judge(now_ns, number)
        if fault is None and deadline_ns is not None:
            fault = self.lateness.overslept(deadline_ns, now_ns, number)
        if fault is not None:
            self._halt(fault)

    def _call_nodes(self, now_ns: int) -> None:
        frames = self.bring_up.call(now_ns)
        self.timer.retry(now_ns + self.bring_up.retry_ns)
        if self.machine.phase is Phase.ROLL_CALL:
            self._beat(BUS_STATES[Phase.ROLL_CALL])
        self._out.extend(frames)
        fault = self.bring_up.fault(self.suspects.all_bad())
        if fault is not None:
            self._halt(fault)

    # --- frames of a cycle; most go to the inputs ---------------------------------------------

    def _send_rows(self) -> None:
        self.cycle.send_rows(self._out)

    def _close_cycle(self) -> None:
        self.cycle.close(self._now_ns, self._out)

    def _confirmed(self, frame: Frame) -> Frame | None:
        """An own frame that has gone out; None if it is another master's."""
        if self.own_frames.confirm(frame):
            return frame
        self._on_second_master(frame)
        return None

    def _on_second_master(self, frame: Frame) -> None:
        """Another master sends as this one does: neither may go on."""
        self.ignored["frame of a second master"] += 1
        if self.machine.phase in _ALONE:
            return
        name = next(name for name, codec in self.wire.codecs.items() if codec.id == frame.id)
        silent = self.bring_up.introducing
        words = (
            f"another master drives this bus, it sends {name}: stop it first, or take another bus"
            if silent
            else f"a second master is on the bus, it sends {name}: stop one of them"
        )
        culprit = Culprit(NODE_NAMES[MASTER], name, None, 1.0, 0.0)
        self.cycle.halt(Fault(f"master: {words}", culprit), self._out, silent=silent)

    def _on_sync_sent(self, _: Frame) -> None:
        self.lateness.confirm(self._now_ns)

    def _on_beat_sent(self, _: Frame) -> None:
        self.inputs.answered(_OWN_HEARTBEAT)

    def _on_rows_sent(self, answer: int, frame: Frame) -> None:
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
            self._halt(heartbeat_fault(roster, node, wrong))
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
        fault = bring_up.fault()
        if fault is not None:
            self._halt(fault)
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
        self._halt(blame(self.wire, self.inputs, node, emergency, self.cycle.number))

    def _on_estop(self, estop: Estop) -> None:
        if estop == ESTOP_VALUES:
            fault = Fault("emergency stop on the bus", Culprit(OPERATOR, "ESTOP"))
            self.cycle.halt(fault, self._out, emergency=True)

    def _halt(self, fault: Fault) -> None:
        self.cycle.halt(fault, self._out)


def _torque_scales(parameters: dict[int, Parameters]) -> list[tuple[float, float]]:
    """Motor torque per code of the current DAC and of the fine DAC, Nm (6, 2)."""
    of_joints = [parameters[joint] for joint in JOINTS]
    return [(p[Parameter.TORQUE_PER_CODE], p[Parameter.TORQUE_PER_FORCE_CODE]) for p in of_joints]


def _nothing_more(_: Frame) -> None:
    """That it has gone out is all that is asked of most frames."""


def _sender_of(senders: Collection[str]) -> str:
    """Name of a message's sender: of those that may send samples, the plant."""
    numbers = [number for number, name in DBC_NAMES.items() if name in senders]
    return NODE_NAMES[PLANT if PLANT in numbers else numbers[0]]

"""The control cycle, from SYNC to the set-point of the next one.

Cycle k: SYNC and SETPOINT go out; MEASURE comes, and the math processor's rows go out; ERROR and
DAC come; when all have answered the set-point of cycle k+1 is made (pipelined, Fig. 6.6) and the
cycle is closed.
"""

from collections.abc import Callable
from typing import Final, NamedTuple

from msgspec import structs

from rfms_can.master.answers import TORQUES, Lost
from rfms_can.master.broadcast import Broadcast, Outgoing
from rfms_can.master.corruption import Corruption
from rfms_can.master.fault import Fault
from rfms_can.master.force.control import ForceControl
from rfms_can.master.inputs import CycleInputs
from rfms_can.master.lateness import Lateness
from rfms_can.master.motion import Motion
from rfms_can.master.own_frames import OwnFrames
from rfms_can.master.phases import BUS_STATES, CYCLING, Phase, PhaseEvent, PhaseMachine
from rfms_can.master.requests import ProgramRequests
from rfms_can.master.rows.sets import RowSets
from rfms_can.master.start_up.bring_up import BringUp
from rfms_can.master.start_up.suspects import Suspects
from rfms_can.master.statistics import RunStatistics
from rfms_can.master.stillness import STILL_CYCLES, Stillness
from rfms_can.master.timer import CycleTimer
from rfms_can.master.traffic import Traffic
from rfms_can.master.verification import Verification
from rfms_can.messages.culprit import FOREIGN, PROGRAM, Culprit
from rfms_can.tables import complete
from rfms_can.wire.contract import LAST_CYCLE
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import GRIPPER, HEARTBEAT_EVERY
from rfms_can.wire.vocabulary import Command, NodeState

BRAKING_CYCLES: Final = 12
"""Cycles the master waits for the brakes after STOP before it ends all the same."""
SETTLING_CYCLES: Final = 125
"""Cycles after which a halted arm that still moves is not waited for any more."""
JUDGED: Final = frozenset((Phase.HOME, Phase.READY, Phase.RUN))
"""Phases in which what nodes send too often, or corrupt, halts the arm; in others it is halted."""
SILENCE_COUNTS: Final = 4
"""What a cycle without answers counts for then: in lockstep each takes as long as the barrier."""


class SentSetpoint(NamedTuple):
    """A set-point that was sent.

    Attributes:
        tick: the generator's, one after that at which it was made.
        cycle: whose SETPOINT it is.
        sent_ns: when it was handed to the bus.
    """

    tick: int
    cycle: int
    sent_ns: int


class Parts(NamedTuple):
    """What a control cycle works on.

    Attributes:
        machine: the phase, and the latched fault.
        timer: when cycles begin.
        inputs: what the cycle under way has brought.
        broadcast: packs what goes out.
        rows: the sets of rows.
        bring_up: who is on the bus.
        requests: of programs.
        motion: the trajectory.
        force_control: compliance, bias force and guarded moves.
        statistics: numbers of the run.
        stillness: for how long arm and jaw have stood still.
        verification: whether the joints are where they were commanded to be.
        suspects: what a silent node has sent instead.
        own_frames: what has gone out.
        traffic: who takes too much of the bus.
        lateness: whether the master itself is late.
        corruption: who sends bad frames again and again.
        setpoint_id: identifier of SETPOINT_1.
    """

    machine: PhaseMachine
    timer: CycleTimer
    inputs: CycleInputs
    broadcast: Broadcast
    rows: RowSets
    bring_up: BringUp
    requests: ProgramRequests
    motion: Motion
    force_control: ForceControl
    statistics: RunStatistics
    stillness: Stillness
    verification: Verification
    suspects: Suspects
    own_frames: OwnFrames
    traffic: Traffic
    lateness: Lateness
    corruption: Corruption
    setpoint_id: int


class ControlCycle:
    """Begins and closes cycles; frames to send are appended to ``out``.

    Args:
        parts: what it works on.
        beat: sends the master's heartbeat: its state on the bus, its error register.
        restart_counters: lets the counters of all frames begin at 0.

    Attributes:
        number: cycle under way, as SYNC counts: from ``first`` on when the arm is enabled, and on
            from 0 after the largest that SYNC carries.
        first: number of the first cycle of an enabled arm.
        closed: cycles closed since the first SYNC: programs wait by it.
        sent: the set-point sent last.
        halted: cycles closed since the last fault.
    """

    def __init__(
        self,
        parts: Parts,
        beat: Callable[[NodeState, int], None],
        restart_counters: Callable[[], None],
    ) -> None:
        self.number = -1
        self.first = 0
        self.closed = 0
        self.sent = SentSetpoint(0, -1, 0)
        self.halted = 0
        self._machine = parts.machine
        self._timer = parts.timer
        self._inputs = parts.inputs
        self._broadcast = parts.broadcast
        self._rows = parts.rows
        self._bring_up = parts.bring_up
        self._requests = parts.requests
        self._motion = parts.motion
        self._force = parts.force_control
        self._statistics = parts.statistics
        self._stillness = parts.stillness
        self._verification = parts.verification
        self._suspects = parts.suspects
        self._own_frames = parts.own_frames
        self._traffic = parts.traffic
        self._lateness = parts.lateness
        self._corruption = parts.corruption
        self._setpoint_id = parts.setpoint_id
        self._beat = beat
        self._restart_counters = restart_counters
        self._next: Outgoing | None = None  # made when a cycle is closed
        self._now_ns = 0  # when the last cycle was closed
        self._began_ns = 0  # when the cycle under way was due
        self._unanswered = 0  # bits of what did not come in the last cycle, if it was incomplete
        self._homing = 0  # cycles since HOME
        self._ending = 0  # cycles since the arm was disabled

    def begin(self, began_ns: int, now_ns: int, out: list[Frame]) -> None:
        """SYNC, and with it all that the master knows of this cycle already.

        Args:
            began_ns: when it begins by the schedule.
            now_ns: when it is sent.
            out: takes the frames.
        """
        machine, timer = self._machine, self._timer
        if timer.stopped or not machine.cycling:
            return
        timer.begin(began_ns)
        self._judge_traffic(began_ns, out)
        cycle = self.number = self.number + 1 & LAST_CYCLE
        phase = machine.phase
        self._corruption.begin()
        state = BUS_STATES[phase]
        out.append(self._broadcast.sync(cycle, state, self._rows.in_force.number))
        self._inputs.begin(phase, cycle)
        if phase is Phase.RUN:
            self._lateness.begin(began_ns)
        if phase is Phase.RUN and self._next is not None:
            self._broadcast.setpoint(self._next, cycle, out)
            self.sent = SentSetpoint(self._motion.generator.tick_count, cycle, now_ns)
        if cycle % HEARTBEAT_EVERY == 0:
            self._beat(state, int(machine.fault is not None))

    def send_rows(self, out: list[Frame]) -> None:
        """The whole arm has been sampled: the next set of rows goes out."""
        force = self._force
        self._rows.send(self._inputs.arm_state.q, force.compliance, force.load, out)

    def close(self, now_ns: int, out: list[Frame]) -> None:
        """All have answered, or their time is over: make the next set-point, or change phase.

        In lockstep the next cycle begins at once.
        """
        inputs, requests, phase = self._inputs, self._requests, self._machine.phase
        self.closed += 1
        self.halted += 1
        self._stillness.watch(inputs.arm_state)
        if phase is Phase.RUN:
            self._statistics.cycles += 1
        if phase is Phase.RUN and not requests.stop_requested:
            motion, force, q = self._motion, self._force, inputs.arm_state.q
            model, in_force = self._rows.newest, self._rows.in_force.compliance
            self._statistics.errors(inputs.errors, motion.following.moves)
            guarded = motion.guarded
            if not guarded:
                force.guards.end()
            force.sense(inputs.take_reading(), inputs.torques, motion.commanded, q, model, guarded)
            errors = motion.following.errors_of_asked(inputs.errors)
            reached = force.close(motion.force_request, q, errors, model, in_force)
            if reached:
                motion.end_guarded(reached)
            violation = self._verify() or self._overcomplied()
            if violation:
                self.halt(violation, out)
            else:
                self._make_setpoint()
        self._now_ns = now_ns
        _TRANSITIONS[phase](self, out)  # below: how each phase may end
        if self._timer.close():
            self.begin(now_ns, now_ns, out)

    def close_incomplete(self, now_ns: int, out: list[Frame]) -> None:
        """The time of the cycle is over, and an answer is missing."""
        self._unanswered = unanswered = self._inputs.missing
        missing, lost = self._inputs.give_up(self.number)
        self._statistics.miss(missing)
        phase = self._machine.phase
        if phase is Phase.END:
            self._ending += SILENCE_COUNTS
        elif lost and phase is not Phase.RESET:  # who is missing is seen when all are called
            behind = self._corruption.behind(lost.frame, lost.cycles, self.closed, self.number)
            self.halt(behind or self._silence_of(lost, phase), out)
        elif phase in JUDGED:
            corrupt = self._corruption.end_incomplete(self.closed, unanswered, self.number)
            if corrupt is not None:
                self.halt(corrupt, out)
        self.close(now_ns, out)

    def _silence_of(self, lost: Lost, phase: Phase) -> Fault:
        """Who has been silent for too long, with what has come from it instead."""
        words, culprit = lost.fault
        besides = self._suspects.of(lost.node, enabled=phase is Phase.RUN)
        return Fault(f"{words}{besides}", culprit)

    def halt(
        self,
        fault: Fault,
        out: list[Frame],
        *,
        emergency: bool = False,
        silent: bool = False,
        instead: Frame | None = None,
    ) -> None:
        """Latch a fault: every node stops, and stays stopped; see ``PhaseMachine.latch``.

        Args:
            fault: why.
            out: takes the command.
            emergency: whether it is an emergency stop.
            silent: send nothing, for the nodes are another master's.
            instead: what is sent instead of QUICKSTOP, a controlled stop.
        """
        cycling = self._machine.cycling
        words, culprit = fault
        if culprit.cycle is None and cycling:
            culprit = structs.replace(culprit, cycle=self.number)
        known = culprit if culprit.sender else None
        if self._machine.latch(words, known, emergency=emergency):
            self.halted = 0
            self._motion.generator.disable(words)
            if not silent:
                out.append(instead or self._broadcast.command(Command.QUICKSTOP))
            if not cycling:
                self._timer.stop()

    @property
    def settled(self) -> bool:
        """Whether a halted arm has come to rest since the fault, or is not waited for any more."""
        rests = self._stillness.arm and self.halted >= STILL_CYCLES
        return self._timer.stopped or rests or self.halted >= SETTLING_CYCLES

    def begin_homing(self, now_ns: int, out: list[Frame]) -> None:
        """All nodes are configured: those without a reference look for it, the others are homed."""
        self._machine.change(PhaseEvent.ALL_CONFIGURED)
        self._homing = 0
        out.append(self._broadcast.command(Command.HOME))
        self.begin(now_ns, now_ns, out)

    def call_nodes(self, at_ns: int) -> None:
        """The way out of a fault: all nodes are reset, and called as at the start."""
        self._machine.change(PhaseEvent.RESTED)
        self._bring_up.restart()
        self._timer.retry(at_ns)

    @property
    def in_progress(self) -> int:
        """The cycle under way; between the close of one and the next SYNC the one that is next."""
        return self.number + self._inputs.complete & LAST_CYCLE

    # --- steps of a cycle ---------------------------------------------------------------------

    def _judge_traffic(self, began_ns: int, out: list[Frame]) -> None:
        """A cycle is over by its SYNC: who has taken too much of it?

        A bus that no longer carries the joints' torques carries no controlled stop: the plant would
        brake joint after joint while the others drive. Then torque goes off everywhere.
        """
        duration_ns, self._began_ns = began_ns - self._began_ns, began_ns
        unanswered, self._unanswered = self._unanswered, 0
        fault = self._traffic.end_cycle(self.number, duration_ns)
        if fault is not None and self._machine.phase in JUDGED:
            full = fault.culprit.sender == FOREIGN and bool(unanswered & TORQUES)
            stop = self._broadcast.emergency_stop() if full else None
            self.halt(fault, out, instead=stop)

    def _overcomplied(self) -> Fault | None:
        """Whether compliance has let the arm go too far."""
        words = self._force.comply.limit_violation()
        return None if words is None else Fault(words, Culprit(PROGRAM, "COMPLY", self.number))

    def _verify(self) -> Fault | None:
        """Whether the joints are where this cycle's set-point has them; which is not, and why."""
        outgoing = self._next
        if outgoing is None:
            return None
        inputs, motion, law = self._inputs, self._motion, self._rows.in_force.law
        verification = self._verification
        if not motion.following.moves:
            verification.rested()
        return verification.check(
            motion.commanded.theta,
            outgoing.displacement,
            inputs.arm_state.q,
            inputs.errors,
            inputs.sampled & inputs.told,
            None if law is None else law.errors,
            cycle=self.number,
            altered=self._own_frames.altered[self._setpoint_id],
        )

    def _make_setpoint(self) -> None:
        """The set-point of the next cycle, and what goes with it."""
        motion, force = self._motion, self._force
        setpoint = motion.next_setpoint()
        displacement = motion.following.displaced(force.follow(motion.commanded.theta))
        gripper = self._requests.gripper
        self._next = Outgoing(setpoint, motion.commanded.told, displacement, force.bias, gripper)

    # --- transitions at the end of a cycle ----------------------------------------------------

    def _end_homing(self, out: list[Frame]) -> None:
        """HOME ends when master and nodes know where all joints are; all have told a hash then."""
        self._homing += 1
        if self._inputs.arm_state.referenced and self._bring_up.roster.all_in(NodeState.READY):
            self._machine.change(PhaseEvent.ALL_HOMED)
            wrong = self._bring_up.hold_to_configuration()
            if wrong is not None:
                self.halt(wrong, out)
        elif self._homing > self._bring_up.homing_cycles:
            self.halt(self._bring_up.homing_overdue(self._inputs.arm_state), out)
        else:
            self._stop_on_request(out)

    def _start_or_stop(self, out: list[Frame]) -> None:
        if self._requests.take_start() and not self._requests.stop_requested:
            self._enable(out)
        else:
            self._stop_on_request(out)

    def _stop_on_request(self, out: list[Frame]) -> None:
        """Torque off, brakes on: STOP from motion, RESET out of a controlled stop."""
        if self._requests.stop_requested:
            halted = self._machine.phase is Phase.HALT
            out.append(self._broadcast.command(Command.RESET if halted else Command.STOP))
            self._machine.change(PhaseEvent.STOP)

    def _reset_at_rest(self, out: list[Frame]) -> None:
        """RESET lets go of the joints: they must stand still."""
        if self._requests.stop_requested:
            out.append(self._broadcast.command(Command.RESET))
            self._machine.change(PhaseEvent.STOP)
        elif self.settled:
            self.call_nodes(self._now_ns)

    def _await_brakes(self, _out: list[Frame]) -> None:
        """The run ends when the brakes hold, or when they do not for too long."""
        self._ending += 1
        if all(self._inputs.arm_state.braked) or self._ending >= BRAKING_CYCLES:
            self._timer.stop()

    def _enable(self, out: list[Frame]) -> None:
        """START: counters of frames restart at 0, cycles at ``first``; the arm holds."""
        state = self._inputs.arm_state
        self._motion.enable(state.q)
        self._force.reset()
        self._verification.reset()
        self._lateness.forget()
        self._corruption.forget()
        self._traffic.forget()
        if GRIPPER in self._bring_up.unreferenced:
            state.open_counts = state.jaw_counts  # homing has left it there
            self._requests.release_jaw()
        self._machine.change(PhaseEvent.START)
        out.append(self._broadcast.command(Command.START))
        self._restart_counters()
        self.number = self.first - 1
        self._make_setpoint()


_TRANSITIONS: Final = complete(
    {
        Phase.HOME: ControlCycle._end_homing,
        Phase.READY: ControlCycle._start_or_stop,
        Phase.RUN: ControlCycle._stop_on_request,
        Phase.HALT: ControlCycle._stop_on_request,
        Phase.RESET: ControlCycle._reset_at_rest,
        Phase.END: ControlCycle._await_brakes,
    },
    CYCLING,
)
"""How each phase that has cycles may end when one is closed; faults end it at any time."""

"""The supervisor: runs the bus through its phases, and each control cycle from SYNC to close.

Cycle k: SYNC and SETPOINT go out; MEASURE comes, and the math processor's rows go out; ERROR and
DAC come; when all have answered the set-point of cycle k+1 is made (pipelined, Fig. 6.6) and the
cycle is closed. What a program asks for takes effect when the next cycle is closed, so its motion
is the same on every bus and clock.
"""

from collections.abc import Sequence
from typing import Final, NamedTuple

from rfms_can.arm import Arm
from rfms_can.errors import KinematicsError, ProgramError
from rfms_can.frame import Frame
from rfms_can.master.listener import Listener
from rfms_can.master.motion import NOTED, Motion
from rfms_can.master.phases import BUS_STATES, CYCLING, Phase, PhaseEvent, next_phase
from rfms_can.master.settings import Clock, MasterSettings
from rfms_can.master.statistics import RunStatistics
from rfms_can.master.stillness import Stillness
from rfms_can.messages import Answer, GripperRequest, Message
from rfms_can.node import NOTHING
from rfms_can.setpoint.cartesian import CartesianSetpoint
from rfms_can.wire import HEARTBEAT_EVERY, Wire
from rfms_can.wire.vocabulary import Command, GripperCommand, NodeState

BRAKING_CYCLES: Final = 12
"""Cycles the master waits for the brakes after STOP before it ends all the same."""
SILENCE_COUNTS: Final = 4
"""What a cycle without answers counts for then: in lockstep each takes as long as the barrier."""


class Carried(NamedTuple):
    """A set-point that was sent.

    Attributes:
        tick: the generator's, one after that at which it was made.
        cycle: whose SETPOINT it is.
        sent_ns: when it was handed to the bus.
    """

    tick: int
    cycle: int
    sent_ns: int


class Supervisor(Listener):
    """Node 8: supervisor and math processor.

    Attributes:
        closed: control cycles closed since the first SYNC: programs wait by it.
        fault: why the run was halted, or None; latched.
        motion: programs' moves and the trajectory generator.
        statistics: numbers of the run.
        stillness: for how long arm and jaw have stood still.
        paced: lockstep cycles are no shorter than the period; for a bus that idles.
        carried: the set-point sent last.
    """

    def __init__(self, arm: Arm, wire: Wire, boot_id: int, settings: MasterSettings) -> None:
        super().__init__(arm, wire, boot_id, settings)
        period_s = settings.period_ns * 1e-9
        self.closed = 0
        self.fault: str | None = None
        self.motion = Motion(arm, period_s, settings.blend)
        self.statistics = RunStatistics(period_s)
        self.stillness = Stillness(arm)
        self.paced = settings.paced
        self.carried = Carried(0, -1, 0)
        self._lockstep = settings.clock is Clock.LOCKSTEP
        self._deadline_ns: int | None = 0
        self._setpoint: CartesianSetpoint | None = None
        self._start_asked = self._stop_asked = False
        self._gripper_asked = self.broadcast.gripper
        self._ending = 0
        self._began_ns = 0

    # --- what programs ask --------------------------------------------------------------------

    def start(self) -> None:
        """Enable the arm at the next closed cycle (phase READY)."""
        self._start_asked = True

    def stop(self) -> None:
        """Disable the arm at the next closed cycle, brakes on, for good."""
        self._stop_asked = True
        if self.phase not in CYCLING:  # no node drives yet
            self.phase, self._deadline_ns = next_phase(self.phase, PhaseEvent.STOP), None

    def handle(self, message: Message) -> Answer:
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
            self.stillness.jaw_commanded()
            return NOTED
        answer = self.motion.handle(message)
        if answer.sequence:
            self.stillness.arm_commanded()
        return answer

    # --- time ---------------------------------------------------------------------------------

    def next_deadline_ns(self) -> int | None:
        """Next SYNC, or in lockstep the barrier; before cycles run, the next call for nodes."""
        return 0 if self._urgent else self._deadline_ns

    def on_time(self, now_ns: int) -> Sequence[Frame]:
        """Begin the next cycle, closing an incomplete one; or call for nodes again."""
        deadline_ns = self._deadline_ns
        if self._urgent:
            self._urgent = False
            return self._flush()
        if deadline_ns is None or now_ns < deadline_ns:
            return NOTHING
        self._now_ns = now_ns
        if self.phase in CYCLING:
            complete = not self._answers.missing
            if not complete:
                self._close_incomplete()  # in lockstep this begins the next one
            if self.settings.clock is Clock.REALTIME:
                self.statistics.late(now_ns - deadline_ns)
            if complete or not self._lockstep:
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
        self._began_ns = now_ns
        self._deadline_ns = now_ns + self.settings.cycle_limit_ns
        cycle = self.cycle = self.cycle + 1
        state = BUS_STATES[self.phase]
        self._out.append(self.broadcast.sync(cycle, state))
        self._answers.begin(self.phase, cycle)
        if self.phase is Phase.RUN and self._setpoint is not None:
            self.broadcast.setpoint(self._setpoint, cycle, self._out)
            self.carried = Carried(self.motion.generator.tick_count, cycle, self._now_ns)
        if cycle % HEARTBEAT_EVERY == 0:
            self._beat(state, int(self.fault is not None))

    # --- the end of a cycle -------------------------------------------------------------------

    def _close_incomplete(self) -> None:
        """The cycle's time is over and somebody has not answered."""
        self.statistics.miss(self._answers.describe())
        lost = self._answers.unanswered(self.cycle)
        self._answers.missing = 0
        if self.phase is Phase.END:
            self._ending += SILENCE_COUNTS
        elif lost:
            self._halt(lost)
        self._close()

    def _close(self) -> None:
        """All have answered, or their time is over: change phase, make the next set-point."""
        self.closed += 1
        self.stillness.watch(self.arm_state)
        _AT_CLOSE[self.phase](self)
        self.broadcast.gripper = self._gripper_asked
        if not self._lockstep or self._deadline_ns is None:
            return
        if self.paced:
            self._deadline_ns = self._began_ns + self.settings.period_ns
        else:
            self._begin_cycle(self._now_ns)

    def _close_homing(self) -> None:
        if self.arm_state.referenced and self.bring_up.roster.all_in(NodeState.READY):
            self.phase = next_phase(self.phase, PhaseEvent.ALL_HOMED)
        elif self._stop_asked:
            self._end()

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
        self.statistics.errors(self.errors, self.motion.moves)
        self._make_setpoint()

    def _close_halted(self) -> None:
        if self._stop_asked:
            self._end()

    def _close_ending(self) -> None:
        self._ending += 1
        if all(self.arm_state.braked) or self._ending >= BRAKING_CYCLES:
            self._deadline_ns = None

    def _make_setpoint(self) -> None:
        """The set-point of the next cycle; one the arm cannot take is not sent."""
        try:
            setpoint, refusal = self.motion.next_setpoint()
        except KinematicsError as error:  # stopped where nothing can be held
            self._halt(str(error))
            return
        if refusal is None:
            self._setpoint = setpoint
        else:
            self._halt(f"set-point refused before it was sent: {refusal}")

    # --- phases -------------------------------------------------------------------------------

    def _all_present(self) -> None:
        self.phase = next_phase(self.phase, PhaseEvent.ALL_PRESENT)
        self._out.extend(self.bring_up.configure(self._now_ns))

    def _all_configured(self) -> None:
        self.phase = next_phase(self.phase, PhaseEvent.ALL_CONFIGURED)
        self._out.append(self.broadcast.command(Command.HOME))
        self._begin_cycle(self._now_ns)

    def _enable(self) -> None:
        """START: all counters begin anew, cycle 0 is next, and the arm holds where it is."""
        self._start_asked = False
        try:
            self.motion.enable(self.arm_state.q)
        except KinematicsError as error:
            self._halt(str(error))
            return
        self.arm_state.open_counts = self.arm_state.jaw_counts  # homing has left it there
        self.phase = next_phase(self.phase, PhaseEvent.START)
        self._out.append(self.broadcast.command(Command.START))
        self._restart_counters()
        self.cycle = -1
        self._make_setpoint()

    def _end(self) -> None:
        """Torque off, brakes on: STOP from motion, RESET out of a controlled stop."""
        command = Command.RESET if self.phase is Phase.HALT else Command.STOP
        self._out.append(self.broadcast.command(command))
        self.phase = next_phase(self.phase, PhaseEvent.STOP)

    @property
    def in_progress(self) -> int:
        """The cycle under way; between the close of one and the next SYNC the one that is next."""
        return self.cycle if self._answers.missing else self.cycle + 1

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
            self._out.append(self.broadcast.command(Command.QUICKSTOP))
            if not cycling:
                self._deadline_ns = None


_AT_CLOSE: Final = {
    Phase.HOME: Supervisor._close_homing,
    Phase.READY: Supervisor._close_ready,
    Phase.RUN: Supervisor._close_running,
    Phase.HALT: Supervisor._close_halted,
    Phase.END: Supervisor._close_ending,
}

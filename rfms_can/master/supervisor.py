"""The supervisor: does what programs ask, and runs the bus through its phases.

What a program asks for takes effect when the next cycle is closed, so its motion is the same on
every bus and clock.
"""

from typing import Final

from rfms_can.arm import Arm
from rfms_can.errors import KinematicsError, ProgramError
from rfms_can.kinematics import direct
from rfms_can.master.cycle import ControlCycle
from rfms_can.master.motion import NOTED
from rfms_can.master.phases import CYCLING, Phase, PhaseEvent, next_phase
from rfms_can.master.settings import MasterSettings
from rfms_can.messages import Answer, GripperRequest, Message, TareRequest
from rfms_can.wire.contract import Wire
from rfms_can.wire.vocabulary import Command, GripperCommand, NodeState

BRAKING_CYCLES: Final = 12
"""Cycles the master waits for the brakes after STOP before it ends all the same."""
SILENCE_COUNTS: Final = 4
"""What a cycle without answers counts for then: in lockstep each takes as long as the barrier."""


class Supervisor(ControlCycle):
    """Node 8: supervisor and math processor.

    Attributes:
        fault: why the run was halted, or None; latched.
    """

    def __init__(self, arm: Arm, wire: Wire, boot_id: int, settings: MasterSettings) -> None:
        super().__init__(arm, wire, boot_id, settings)
        self.fault: str | None = None
        self._start_asked = self._stop_asked = False
        self._gripper_asked = self.broadcast.gripper
        self._ending = 0

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
        if isinstance(message, TareRequest):
            self._tare()
            return NOTED
        answer = self.motion.handle(message)
        if answer.sequence:
            self.stillness.arm_commanded()
        return answer

    def _tare(self) -> None:
        """Take the sensor's next readings for its bias."""
        if not self.settings.sensor:
            raise ProgramError("tare: the arm has no wrist sensor; run it with --sensor good")
        if not self.motion.at_rest or not self.stillness.arm:
            raise ProgramError("tare: the arm moves; wait until it rests, touching nothing")
        complying = self.broadcast.in_force.selection.word
        if complying:
            raise ProgramError(
                f"tare: the arm complies in {complying} and may press on something; lock it, and "
                "move away first"
            )
        self.force_control.felt.tare()

    # --- the end of a cycle -------------------------------------------------------------------

    def _missed(self, lost: str | None) -> None:
        if self.phase is Phase.END:
            self._ending += SILENCE_COUNTS
        elif lost:
            self._halt(lost)

    def _at_close(self) -> None:
        _AT_CLOSE[self.phase](self)
        self.broadcast.gripper = self._gripper_asked

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
        self._control_force()
        if self.phase is Phase.RUN:
            self._make_setpoint()

    def _close_halted(self) -> None:
        if self._stop_asked:
            self._end()

    def _close_ending(self) -> None:
        self._ending += 1
        if all(self.arm_state.braked) or self._ending >= BRAKING_CYCLES:
            self._deadline_ns = None

    def _control_force(self) -> None:
        """What the cycle has brought for compliance, bias force and guarded moves."""
        motion, force, q = self.motion, self.force_control, self.arm_state.q
        dynamics, felt = self.broadcast.math.dynamics, force.felt
        if self.force is not None:
            felt.read(self.force, dynamics.load, direct(self.arm, q))
            self.force = None
        elif motion.guarded and not felt.sensed:  # a reading that was lost is not made up for
            commanded = motion.commanded
            felt.guess(
                self.torques,
                commanded.rate,
                commanded.acceleration,
                dynamics.J,
                dynamics.M,
                dynamics.g,
            )
        if not motion.guarded:
            force.guards.end()
        if force.close(motion.asked, q, self.errors, self.broadcast.in_force):
            motion.end_guarded()
        astray = force.comply.astray()
        if astray:
            self._halt(astray)

    def _make_setpoint(self) -> None:
        """The set-point of the next cycle; one the arm cannot take is not sent."""
        try:
            setpoint, refusal = self.motion.next_setpoint()
            self._displacement = self.force_control.follow(self.motion.commanded.theta)
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
        self.force_control.reset()
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

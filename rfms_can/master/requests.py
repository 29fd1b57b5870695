"""Requests of programs: checked when they come, done when the next cycle is closed.

So a motion is the same on every bus and clock.
"""

from rfms_can.errors import ProgramError
from rfms_can.master.force.control import ForceControl
from rfms_can.master.motion import NOTED, Motion
from rfms_can.master.phases import Phase, PhaseMachine
from rfms_can.master.rows.sets import RowSets
from rfms_can.master.stillness import Stillness
from rfms_can.messages import Answer, GripperRequest, Message, TareRequest
from rfms_can.wire.vocabulary import GripperCommand


class ProgramRequests:
    """Takes the requests of programs, and keeps those that the end of the cycle acts on.

    Args:
        machine: says whether the arm is enabled.
        motion: takes moves and what they refer to.
        force_control: takes a tare.
        stillness: is told that something will move.
        rows: say what complies.
        sensor: whether there is a wrist sensor.

    Attributes:
        stop_requested: the arm is to be disabled, brakes on, for good.
        gripper: command and force (per cent).
    """

    __slots__ = (
        "_force",
        "_machine",
        "_motion",
        "_rows",
        "_sensor",
        "_start_requested",
        "_stillness",
        "gripper",
        "stop_requested",
    )

    def __init__(
        self,
        machine: PhaseMachine,
        motion: Motion,
        force_control: ForceControl,
        stillness: Stillness,
        rows: RowSets,
        *,
        sensor: bool,
    ) -> None:
        self._machine = machine
        self._motion = motion
        self._force = force_control
        self._stillness = stillness
        self._rows = rows
        self._sensor = sensor
        self._start_requested = self.stop_requested = False
        self.gripper = (GripperCommand.HOLD, 0.0)

    def start(self) -> None:
        """The arm is to be enabled, once it is READY."""
        self._start_requested = True

    def take_start(self) -> bool:
        """Whether the arm is to be enabled now; once."""
        requested, self._start_requested = self._start_requested, False
        return requested

    def release_jaw(self) -> None:
        """The jaw was homed, so it is open: what it was told before does not close it now."""
        self.gripper = (GripperCommand.HOLD, 0.0)

    def stop(self) -> None:
        """The arm is to be disabled, brakes on, for good."""
        self.stop_requested = True

    def handle(self, message: Message) -> Answer:
        """Do what a program asks; see ``Motion.handle``.

        Raises:
            ProgramError: the request is refused; nothing has changed.
        """
        phase = self._machine.phase
        if phase is not Phase.RUN:
            raise ProgramError(f"the arm is not enabled (phase {phase.name}); it takes no requests")
        if isinstance(message, GripperRequest):
            opens = GripperCommand.OPEN if message.opens else GripperCommand.CLOSE
            self.gripper = (opens, round(message.part * 200.0) / 2.0)
            self._stillness.jaw_commanded()
            return NOTED
        if isinstance(message, TareRequest):
            self._tare()
            return NOTED
        answer = self._motion.handle(message)
        if answer.sequence:
            self._stillness.arm_commanded()
        return answer

    def _tare(self) -> None:
        """Take the sensor's next readings for its bias."""
        if not self._sensor:
            raise ProgramError("tare: the arm has no wrist sensor; run it with --sensor good")
        if not self._motion.at_rest or not self._stillness.arm:
            raise ProgramError("tare: the arm moves; wait until it rests, touching nothing")
        complying = self._rows.in_force.compliance.selection.word
        if complying:
            raise ProgramError(
                f"tare: the arm complies in {complying} and may press on something; lock it, and "
                "move away first"
            )
        self._force.wrench_estimate.tare()

"""The program API: the robot coordinator's interface to the arm (thesis V.5, VI.3.1).

A program is a function of an :class:`Arm`::

    def program(arm):
        tool = arm.transform("tool", Transform.translation(0.0, 0.0, 0.1))
        part = arm.transform("part", Transform.translation(0.3, 0.1, 0.0))
        at_part = arm.position("at part", arm.t6 @ tool == part)
        slow = arm.mode("slow", segment_time=1.0, acceleration_time=0.2, interpolation="cartesian")
        arm.wait(arm.move(at_part, slow))
        arm.gripper.close()

It is the same program in the master's process (``rfms run``) and over the link (``connect``). A
request takes effect at the next cycle; in virtual time and lockstep time stands still while the
program runs between two waits. Every request raises ``FaultError`` once a fault has halted the arm,
over the link also ``LeaseError`` and ``LinkError``.
"""

import time
from collections.abc import Sequence
from typing import Unpack

from rfms_can.coordinator import definitions
from rfms_can.coordinator.definitions import IDENTITY, LOOK_S, REST_AFTER_S, TARE_S
from rfms_can.coordinator.equation import Equation, Expression
from rfms_can.coordinator.gripper import Gripper
from rfms_can.coordinator.link import Link
from rfms_can.coordinator.mode_settings import ModeSettings
from rfms_can.coordinator.moves import Moves
from rfms_can.coordinator.stopping import finish, wait_for
from rfms_can.coordinator.view import ArmView
from rfms_can.errors import ProgramError
from rfms_can.messages import (
    AnyFunction,
    Enabled,
    MoveOutcome,
    PauseRequest,
    ResetRequest,
    ResumeRequest,
    StopRequest,
    TareRequest,
)
from rfms_can.messages.world import Predict, What
from rfms_can.transform import Transform


class Arm(ArmView):
    """The arm of a user program.

    Attributes:
        t6: the arm itself, in position equations.
        gripper: of the arm.
    """

    def __init__(self, link: Link, moves: Moves | None = None) -> None:
        super().__init__(link, moves)
        self._link = link
        self.gripper = Gripper(link)

    # --- the world model ----------------------------------------------------------------------

    def transform(self, name: str, value: Transform) -> Expression:
        """Define a transform of kind value, or define it again.

        A move takes the value that the transform has when it begins: one that is redefined acts in
        all moves that have not begun, and these are planned again.

        Raises:
            TransformError: it is not a transform, or the server refuses it.
            MoveError: an accepted move could no longer be made with it; nothing has changed.
        """
        self._moves.redefined(self._link.request(definitions.value(name, value)))
        return Expression(name)

    def reference(
        self,
        name: str,
        value: Transform,
        predict: Predict = "hold",
        rest_after: float = REST_AFTER_S,
    ) -> Expression:
        """Define a transform of kind reference: read in every cycle, also by the current move.

        Args:
            name: its name in the world model.
            value: initial value, until the first observation.
            predict: between observations ``"hold"`` the last, or extrapolate by its ``"velocity"``.
            rest_after: time in which the extrapolation comes to rest once observations stay out,
                0.2 to 5 s; longer where the acceleration of the mode demands it.

        Raises:
            TransformError: it is not a transform, or the server refuses it.
        """
        self._link.request(self._reference(name, value, predict, rest_after))
        return Expression(name)

    def functional(
        self, name: str, function: AnyFunction, base: Transform = IDENTITY
    ) -> Expression:
        """Define a transform of kind functional: ``base`` times a function the server computes.

        Args:
            name: its name in the world model.
            function: ``Linear``, ``Circular``, ``Weave`` or ``Table`` of the motion parameters
                h or t (thesis III.3.4); one that is redefined acts in all moves that have not
                begun.
            base: transform left of the function.

        Raises:
            TransformError: it is not a function, or the server refuses it.
            MoveError: an accepted move could no longer be made with it; nothing has changed.
        """
        self._moves.redefined(self._link.request(definitions.functional(name, function, base)))
        return Expression(name)

    def observe(
        self,
        reference: str | Expression,
        value: Transform,
        at: float | None = None,
        twist: Sequence[float] | None = None,
    ) -> None:
        """Send an observation of a reference transform to the server.

        The current motion is corrected, within the acceleration its mode allows.

        Args:
            reference: its name, or the expression returned by its definition.
            value: observed value.
            at: the server's time of the observation, s (``arm.time`` less its age); None: now.
            twist: velocity of its origin, m/s, and its angular velocity, rad/s, in the frame the
                value is given in (6); estimated from the observations if not given.

        Raises:
            TransformError: it is not a reference of this program, or the observation is in the
                future or too old.
        """
        self._link.request(self._observation(reference, value, at, twist))

    def grant(
        self, sensor: str, references: Sequence[str | Expression], within: float = 0.0
    ) -> None:
        """Let a sensor observe references, in a session of its own, and nothing else.

        The grant takes the place of an earlier one, and ends with this program's session.

        Args:
            sensor: the name it connects with (``connect_sensor``).
            references: their names; none revokes the grant.
            within: how long to wait until it is connected, s of wall time; 0: not.

        Raises:
            ProgramError: a name or the time is out of bounds, the sensor does not come in time, or
                the arm is in this program's own process.
        """
        request = definitions.grant(sensor, references)
        until = time.monotonic() + definitions.patience(sensor, within)
        self._link.request(request)
        while within and self.status.sensors.get(sensor) != "live":
            if time.monotonic() >= until:
                raise definitions.absent(sensor, within, self.status.sensors)
            time.sleep(LOOK_S)
            self._link.request(request)

    def position(
        self,
        name: str,
        equation: Equation,
        *,
        tool: Expression | None = None,
        compliance: Expression | None = None,
        config: str | None = None,
    ) -> str:
        """Define a position by an equation with ``t6`` in it once (3.6), or define it again.

        One that is redefined acts in all moves that have not begun, and these are planned again.

        Args:
            name: its name.
            equation: e.g. ``arm.t6 @ tool == part @ above``.
            tool: its frame moves along straight lines; all transforms right of T6 if not given.
            compliance: compliance frame; the tool's if not given.
            config: e.g. ``"left up noflip"``; the arm's own when enabled if not given.

        Raises:
            EquationError: it cannot be solved for T6.
            MoveError: an accepted move could no longer be made to it; nothing has changed.
        """
        message = definitions.position(name, equation, tool, compliance, config)
        self._moves.redefined(self._link.request(message))
        return name

    def joint_position(self, name: str, angles: Sequence[float]) -> str:
        """Define a position by joint angles (thesis III.1), or define it again.

        A move to it ends at these angles, on these turns; a straight line that would end on
        another turn is refused. It is defined again, and removed, as any other position is. Its
        tool and its compliance frame are those of T6.

        Args:
            name: its name.
            angles: of the joints 1 to 6, rad, as in ``arm.joints``.

        Raises:
            JointPositionError: not six angles, or one is outside the range of its joint.
            EquationError: it is one too many.
            MoveError: an accepted move could no longer be made to it; nothing has changed.
        """
        self._moves.redefined(self._link.request(definitions.joint_position(name, angles)))
        return name

    def mode(self, name: str, **settings: Unpack[ModeSettings]) -> str:
        """Define the motion parameters of a segment, or define them again.

        A mode that is redefined acts in all moves that have not begun, and these are planned again.

        Args:
            name: its name.
            **settings: :class:`ModeSettings`: ``acceleration_time``, and ``segment_time`` or
                speeds.

        Raises:
            ModeError: settings contradict one another, or a number is out of bounds.
            MoveError: an accepted move could no longer be made with it; nothing has changed.
        """
        self._moves.redefined(self._link.request(definitions.mode(name, settings)))
        return name

    def remove(self, name: str | Expression, what: What | None = None) -> None:
        """Remove a transform, a position or a mode that nothing uses any more.

        Args:
            name: its name, or the expression returned by the definition of a transform.
            what: ``"transform"``, ``"position"`` or ``"mode"``: needed where several of them have
                this name.

        Raises:
            ProgramError: there is none, or it is used: a transform by a position, a position or a
                mode by a move that is not over, a reference by the move the arm has made last.
        """
        request = definitions.remove(name, what)
        self._link.request(request)
        self._removed(request)

    # --- motion -------------------------------------------------------------------------------

    def move(self, position: str, mode: str) -> int:
        """Queue a move to a position; returns its sequence number immediately.

        Raises:
            MoveError: the move violates a rule, or the arm cannot make it.
        """
        return self._moves.took(self._link.request(definitions.move(position, mode)))

    def stop(self) -> None:
        """Bring the arm to rest on its path, drop the queued moves, and wait for rest.

        The moves it ends have the outcome ``stopped``: to wait for one of them by its number, now
        or later, is a ``StoppedError``; ``wait()`` without a number is not.
        """
        self._link.request(StopRequest())
        self.wait()

    def reset(self) -> None:
        """Leave a fault: reset the nodes, home what has lost its reference, enable; and wait.

        The moves the fault ended stay ended. Transforms, positions and modes stay; the arm is rigid
        and the gripper as it was, unless it had to be homed: then it is open.

        Raises:
            FaultError: the cause persists, or an emergency stop is in force, which only a person
                lifts, at the command line.
            ProgramError: there is no fault to leave.
        """
        self._link.request(ResetRequest())
        self._moves.tell()
        self._link.wait(Enabled())

    def pause(self) -> None:
        """Bring the arm to rest on its path and keep the moves; returns immediately."""
        self._link.request(PauseRequest())

    def resume(self) -> None:
        """Continue after a pause."""
        self._link.request(ResumeRequest())

    def feed(self, rate: float) -> None:
        """Run all segments slower on the same path.

        Args:
            rate: fraction of the modes' speed, 0.05 to 1.

        Raises:
            ProgramError: it is out of bounds.
        """
        self._link.request(definitions.feed(rate))

    def comply(self, word: str, *values: float) -> None:
        """Comply in some directions of the compliance frame from the next move on (thesis V.5).

        Args:
            word: some of ``fx fy fz rx ry rz``, each once, e.g. ``"fx fy rx ry"``.
            *values: the bias force or moment along each, N or N m.

        Raises:
            SelectionError: an unknown or repeated direction, or not one value for each.
        """
        self._link.request(definitions.comply(word, values))

    def lock(self, word: str) -> None:
        """Stop complying in some directions, from the next move on.

        The arm keeps its compliant displacement until a rigid move takes it to its goal.

        Raises:
            SelectionError: an unknown or repeated direction, or one that does not comply.
        """
        self._link.request(definitions.lock(word))

    def tare(self) -> None:
        """Measure the bias of the wrist sensor, at rest and without contact; waits for the result.

        Raises:
            ProgramError: there is no sensor, the arm complies, or it does not come to rest.
        """
        try:
            self._link.request(TareRequest())
        except ProgramError:  # the arm may still be coming to rest
            wait_for(self._link)
            self._link.request(TareRequest())
        self.sleep(TARE_S)

    def release(self) -> None:
        """Open the gripper; the name is RCCL's."""
        self.gripper.open()

    # --- time ---------------------------------------------------------------------------------

    def wait(self, sequence: int | None = None) -> None:
        """Wait until a move is over, or, without a number, until the arm is at rest.

        A move is over when the arm is at rest at its goal, or has begun the next move; a move that
        was stopped or dropped, when the arm is at rest. Returns only if it was made, or ended by
        its guard; without a number also if the program has stopped its moves itself.

        Raises:
            StoppedError: the move was stopped, or dropped from the queue.
            LeaseError: the lease was lost, and the arm brought to rest.
            FaultError: a fault has halted the arm, or has ended the move.
            ProgramError: no move has that number; or the arm is paused, or does not come to rest.
        """
        finish(self._link, self._moves, sequence)

    def outcome(self, sequence: int) -> MoveOutcome:
        """How a move ended, and why; ``how`` is ``Outcome.UNDER_WAY`` while it is not over.

        Raises:
            ProgramError: no move has that number, or it was too long ago.
        """
        number = self._moves.number(sequence)
        return self._link.outcomes(number, number)[0]

    def sleep(self, seconds: float) -> None:
        """Wait for a time on the arm's clock, in whole control periods.

        Raises:
            ProgramError: the time is negative or not a number.
        """
        self._link.wait(self._after(seconds))

"""The program API: a robot coordinator's view of the arm (thesis V.5, VI.3.1).

A program is a function that is given an :class:`Arm`::

    def program(arm):
        tool = arm.transform("tool", Transform.translation(0.0, 0.0, 0.1))
        part = arm.transform("part", Transform.translation(0.3, 0.1, 0.0))
        at_part = arm.position("at part", arm.t6 @ tool == part)
        slow = arm.mode("slow", segment_time=1.0, acceleration_time=0.2, interpolation="cartesian")
        arm.wait(arm.move(at_part, slow))
        arm.gripper.close()

It is the same program in the master's process (``rfms run``) and over the link (``connect``). A
request takes effect at the next cycle; in virtual time and lockstep time waits while the program
runs between two waits. Whatever asks something of the arm raises ``FaultError`` once a fault has
halted it, over the link also ``LeaseError`` and ``LinkError``.
"""

from collections.abc import Sequence
from typing import Unpack

from rfms_can.coordinator import definitions
from rfms_can.coordinator.definitions import IDENTITY, TARE_S, Predict
from rfms_can.coordinator.equation import Equation, Expression
from rfms_can.coordinator.gripper import Gripper
from rfms_can.coordinator.link import Link
from rfms_can.coordinator.mode_settings import ModeSettings
from rfms_can.coordinator.stopping import wait_for
from rfms_can.coordinator.view import ArmView
from rfms_can.errors import ProgramError
from rfms_can.messages import (
    AnyFunction,
    PauseRequest,
    ResumeRequest,
    StopRequest,
    TareRequest,
)
from rfms_can.transform import Transform


class Arm(ArmView):
    """What a user program moves.

    Attributes:
        t6: the arm itself, in position equations.
        gripper: opens and closes.
    """

    def __init__(self, link: Link) -> None:
        super().__init__(link)
        self._link = link
        self.gripper = Gripper(link)

    # --- the world model ----------------------------------------------------------------------

    def transform(self, name: str, value: Transform) -> Expression:
        """Define a transform of kind value; positions defined later take what it is then.

        Raises:
            TransformError: it is no transform, or the server refuses it.
        """
        self._link.request(definitions.value(name, value))
        return Expression(name)

    def reference(self, name: str, value: Transform, predict: Predict = "hold") -> Expression:
        """Define a transform of kind reference: read anew each cycle, also by moves under way.

        Args:
            name: its name in the world model.
            value: what it is until it is observed.
            predict: between observations ``"hold"`` the last, or go on with its ``"velocity"``.

        Raises:
            TransformError: it is no transform, or the server refuses it.
        """
        self._link.request(self._reference(name, value, predict))
        return Expression(name)

    def functional(
        self, name: str, function: AnyFunction, base: Transform = IDENTITY
    ) -> Expression:
        """Define a transform of kind functional: ``base`` times a function the server computes.

        Args:
            name: its name in the world model.
            function: ``Linear``, ``Circular``, ``Weave`` or ``Table`` of the motion parameters
                h or t (thesis III.3.4); moves asked for later take it.
            base: what stands left of the function.

        Raises:
            TransformError: it is no function, or the server refuses it.
        """
        self._link.request(definitions.functional(name, function, base))
        return Expression(name)

    def observe(
        self,
        reference: str | Expression,
        value: Transform,
        at: float | None = None,
        twist: Sequence[float] | None = None,
    ) -> None:
        """Tell the server where the object of a reference transform was seen.

        The motion under way changes for it, within the acceleration its mode allows.

        Args:
            reference: its name, or the expression its definition gave.
            value: where it was seen.
            at: when: the server's time, s (``arm.time`` less the observation's age); None: now.
            twist: velocity of its origin, m/s, and its angular velocity, rad/s, in the frame the
                value is given in (6); estimated from the observations if not given.

        Raises:
            TransformError: it is no reference of this program, or the observation lies in the
                future or is too old.
        """
        self._link.request(self._observation(reference, value, at, twist))

    def position(
        self,
        name: str,
        equation: Equation,
        *,
        tool: Expression | None = None,
        compliance: Expression | None = None,
        config: str | None = None,
    ) -> str:
        """Define a position by an equation with ``t6`` in it once (3.6).

        Args:
            name: its name; a position is defined once.
            equation: e.g. ``arm.t6 @ tool == part @ above``.
            tool: whose frame runs along straight lines; all that stands right of T6 if not given.
            compliance: in whose frame the arm complies; the tool's if not given.
            config: e.g. ``"left up noflip"``; the arm's own when enabled if not given.

        Raises:
            EquationError: it cannot be solved for T6.
        """
        self._link.request(definitions.position(name, equation, tool, compliance, config))
        return name

    def mode(self, name: str, **settings: Unpack[ModeSettings]) -> str:
        """Define how a segment is moved; a mode is defined once.

        Args:
            name: its name.
            **settings: :class:`ModeSettings`: ``acceleration_time``, and ``segment_time`` or
                speeds.

        Raises:
            ModeError: it contradicts itself, or a number is out of bounds.
        """
        self._link.request(definitions.mode(name, settings))
        return name

    # --- motion -------------------------------------------------------------------------------

    def move(self, position: str, mode: str) -> int:
        """Move to a position; returns the move's sequence number at once.

        Raises:
            MoveError: the move breaks a rule, or the arm cannot make it.
        """
        return self._moves.took(self._link.request(definitions.move(position, mode)))

    def stop(self) -> None:
        """Bring the arm to rest on its path, forget the moves that wait, and wait for rest."""
        self._link.request(StopRequest())
        self.wait()

    def pause(self) -> None:
        """Bring the arm to rest on its path and keep the moves; returns at once."""
        self._link.request(PauseRequest())

    def resume(self) -> None:
        """Go on after a pause."""
        self._link.request(ResumeRequest())

    def feed(self, rate: float) -> None:
        """Run all segments slower on the same path.

        Args:
            rate: part of the speed the modes ask for, 0.05 to 1.

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
            SelectionError: a word that is no direction or comes twice, or not a value for each.
        """
        self._link.request(definitions.comply(word, values))

    def lock(self, word: str) -> None:
        """Comply no more in some directions, from the next move on.

        The arm stays where it was let go until a rigid move takes it from there to its goal.

        Raises:
            SelectionError: a word that is no direction or comes twice, or does not comply.
        """
        self._link.request(definitions.lock(word))

    def tare(self) -> None:
        """Take what the wrist sensor reads at rest, touching nothing, for its bias; waits for it.

        Raises:
            ProgramError: there is no sensor, or the arm complies, or never rests.
        """
        try:
            self._link.request(TareRequest())
        except ProgramError:  # it is about to rest
            wait_for(self._link)
            self._link.request(TareRequest())
        self.sleep(TARE_S)

    def release(self) -> None:
        """Open the gripper, as RCCL's programs say it."""
        self.gripper.open()

    # --- time ---------------------------------------------------------------------------------

    def wait(self, sequence: int | None = None) -> None:
        """Wait until a move is complete, or, without a number, until the arm is at rest.

        A move is complete when the arm is at rest at its goal, or has handed over to the next;
        one that :meth:`stop` has dropped, when the arm is at rest.

        Raises:
            ProgramError: no move has that number; or the arm is paused, or shakes for ever.
        """
        wait_for(self._link, self._moves.over(sequence))

    def sleep(self, seconds: float) -> None:
        """Let the arm go on for a time of its own clock, in whole control periods.

        Raises:
            ProgramError: the time is negative or none.
        """
        self._link.wait(self._after(seconds))

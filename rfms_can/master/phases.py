"""The phases of the master: one literal table, the machine that walks it and latches the fault.

How it couples to the other machines: SYNC carries ``BUS_STATES[phase]``, and nodes compare it with
their own state; NMT commands that go with a change of phase are sent by the control cycle; the
trajectory generator is enabled just before RUN and disabled by a fault.
"""

from collections import deque
from enum import Enum, auto
from typing import Final

from rfms_can.errors import RfmsError
from rfms_can.messages.culprit import Culprit
from rfms_can.tables import complete
from rfms_can.wire.vocabulary import NodeState


class Phase(Enum):
    """What the master is doing with the bus."""

    ROLL_CALL = auto()
    """Waiting until every node has announced itself."""
    CONFIGURE = auto()
    """Sending each node its parameters."""
    HOME = auto()
    """Joints look for their index pulses."""
    READY = auto()
    """Referenced and braked."""
    RUN = auto()
    """Enabled: set-points flow."""
    HALT = auto()
    """A fault: controlled stop, then hold."""
    RESET = auto()
    """Asked to leave a fault: the arm comes to rest, and the nodes are called again."""
    END = auto()
    """Disabled for good."""


class PhaseEvent(Enum):
    """What ends a phase."""

    ALL_PRESENT = auto()
    ALL_CONFIGURED = auto()
    ALL_HOMED = auto()
    START = auto()
    STOP = auto()
    FAULT = auto()
    RESET = auto()
    RESTED = auto()


PHASES: Final[dict[Phase, dict[PhaseEvent, Phase]]] = complete(
    {
        Phase.ROLL_CALL: {
            PhaseEvent.ALL_PRESENT: Phase.CONFIGURE,
            PhaseEvent.FAULT: Phase.HALT,
            PhaseEvent.STOP: Phase.END,
        },
        Phase.CONFIGURE: {
            PhaseEvent.ALL_CONFIGURED: Phase.HOME,
            PhaseEvent.FAULT: Phase.HALT,
            PhaseEvent.STOP: Phase.END,
        },
        Phase.HOME: {
            PhaseEvent.ALL_HOMED: Phase.READY,
            PhaseEvent.FAULT: Phase.HALT,
            PhaseEvent.STOP: Phase.END,
        },
        Phase.READY: {
            PhaseEvent.START: Phase.RUN,
            PhaseEvent.FAULT: Phase.HALT,
            PhaseEvent.STOP: Phase.END,
        },
        Phase.RUN: {
            PhaseEvent.STOP: Phase.END,
            PhaseEvent.FAULT: Phase.HALT,
        },
        Phase.HALT: {
            PhaseEvent.FAULT: Phase.HALT,
            PhaseEvent.STOP: Phase.END,
            PhaseEvent.RESET: Phase.RESET,
        },
        Phase.RESET: {
            PhaseEvent.RESTED: Phase.ROLL_CALL,
            PhaseEvent.FAULT: Phase.HALT,
            PhaseEvent.STOP: Phase.END,
        },
        Phase.END: {
            PhaseEvent.FAULT: Phase.END,
            PhaseEvent.STOP: Phase.END,
        },
    },
    Phase,
)

BUS_STATES: Final[dict[Phase, NodeState]] = complete(
    {
        Phase.ROLL_CALL: NodeState.PREOP,
        Phase.CONFIGURE: NodeState.PREOP,
        Phase.HOME: NodeState.HOMING,
        Phase.READY: NodeState.READY,
        Phase.RUN: NodeState.OPERATIONAL,
        Phase.HALT: NodeState.QUICKSTOP,
        Phase.RESET: NodeState.QUICKSTOP,
        Phase.END: NodeState.READY,
    },
    Phase,
)
"""What SYNC says of each phase."""

CYCLING: Final = frozenset((Phase.HOME, Phase.READY, Phase.RUN, Phase.HALT, Phase.RESET, Phase.END))
"""Phases in which control cycles run."""


NO_RESET: Final[dict[Phase, str | None]] = complete(
    {
        Phase.ROLL_CALL: "the arm is being brought up: wait until it is enabled",
        Phase.CONFIGURE: "the arm is being brought up: wait until it is enabled",
        Phase.HOME: "the arm is being brought up: wait until it is enabled",
        Phase.READY: "the arm is being brought up: wait until it is enabled",
        Phase.RUN: "the arm is enabled, there is no fault to leave: go on",
        Phase.HALT: None,
        Phase.RESET: "one is under way: wait until the arm is enabled",
        Phase.END: "the run is over: start another one",
    },
    Phase,
)
"""Why there is nothing to reset in a phase; None where there is."""
FAULTS_KEPT: Final = 100
"""Reasons of past faults that are remembered."""


class PhaseError(RfmsError):
    """Our own code requested a phase change that the table does not have."""


def next_phase(phase: Phase, event: PhaseEvent) -> Phase:
    """Phase after ``event``.

    Raises:
        PhaseError: the table has none: a bug.
    """
    try:
        return PHASES[phase][event]
    except KeyError:
        raise PhaseError(f"master: {event.name} in phase {phase.name} has no transition") from None


class PhaseMachine:
    """The phase, and the latched fault: the only place where either is changed.

    Attributes:
        reset_faults: reasons of the faults that were left by a reset, oldest first, the last
            ``FAULTS_KEPT`` of them.
    """

    __slots__ = ("_culprit", "_emergency", "_fault", "_phase", "reset_faults")

    def __init__(self) -> None:
        self._phase = Phase.ROLL_CALL
        self._fault: str | None = None
        self._culprit: Culprit | None = None
        self._emergency: str | None = None
        self.reset_faults: deque[str] = deque(maxlen=FAULTS_KEPT)

    @property
    def phase(self) -> Phase:
        """What the master is doing with the bus."""
        return self._phase

    @property
    def fault(self) -> str | None:
        """Reason of the first fault, or None; latched until a reset."""
        return self._fault

    @property
    def culprit(self) -> Culprit | None:
        """Who is to blame for that fault; None without one, or where no one is known."""
        return self._culprit

    @property
    def emergency(self) -> str | None:
        """Reason of the emergency stop in force, or None; latched until a person lifts it."""
        return self._emergency

    @property
    def cycling(self) -> bool:
        """Whether control cycles run."""
        return self._phase in CYCLING

    def change(self, event: PhaseEvent) -> None:
        """Go where the table says.

        Raises:
            PhaseError: the table has no such transition, or a fault was to be raised without its
                reason: a bug.
        """
        if event in (PhaseEvent.FAULT, PhaseEvent.RESET):
            raise PhaseError(f"master: {event.name} goes with the latch: call latch() or reset()")
        self._phase = next_phase(self._phase, event)

    def reset(self) -> None:
        """Leave a fault, which is remembered; the way to RUN begins.

        Raises:
            PhaseError: there is none, or an emergency stop is in force: a bug.
        """
        if self._fault is None or self._emergency is not None:
            raise PhaseError(
                f"master: reset with fault {self._fault!r}, emergency stop {self._emergency!r}"
            )
        self._phase = next_phase(self._phase, PhaseEvent.RESET)
        self.reset_faults.append(self._fault)
        self._fault = self._culprit = None

    def lift(self) -> bool:
        """Lift the emergency stop; the fault stays latched. Whether one was in force."""
        lifted, self._emergency = self._emergency is not None, None
        return lifted

    def latch(
        self, reason: str, culprit: Culprit | None = None, *, emergency: bool = False
    ) -> bool:
        """Latch a fault; the first reason stays. At the end of a run there is nothing to stop.

        Args:
            reason: why, in one line.
            culprit: who is to blame.
            emergency: whether it is an emergency stop, which no reset leaves until it is lifted.

        Returns:
            Whether the phase has become HALT just now, so that the nodes have to be told.
        """
        phase = self._phase
        if phase is Phase.END:
            return False
        if self._fault is None:
            self._fault, self._culprit = reason, culprit
        if emergency and self._emergency is None:
            self._emergency = reason
        self._phase = next_phase(phase, PhaseEvent.FAULT)
        return phase is not Phase.HALT

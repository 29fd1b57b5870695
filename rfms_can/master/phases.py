"""The phases of the master: one literal table; the state of each phase on the bus beside it."""

from enum import Enum, auto
from typing import Final

from rfms_can.errors import RfmsError
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


PHASES: Final[dict[Phase, dict[PhaseEvent, Phase]]] = {
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
    },
    Phase.END: {
        PhaseEvent.FAULT: Phase.END,
        PhaseEvent.STOP: Phase.END,
    },
}

BUS_STATES: Final[dict[Phase, NodeState]] = {
    Phase.ROLL_CALL: NodeState.PREOP,
    Phase.CONFIGURE: NodeState.PREOP,
    Phase.HOME: NodeState.HOMING,
    Phase.READY: NodeState.READY,
    Phase.RUN: NodeState.OPERATIONAL,
    Phase.HALT: NodeState.QUICKSTOP,
    Phase.END: NodeState.READY,
}
"""What SYNC says of each phase."""

CYCLING: Final = frozenset((Phase.HOME, Phase.READY, Phase.RUN, Phase.HALT, Phase.END))
"""Phases in which control cycles run."""


class PhaseError(RfmsError):
    """Our own code asked for a phase change the table does not have."""


def next_phase(phase: Phase, event: PhaseEvent) -> Phase:
    """Phase after ``event``.

    Raises:
        PhaseError: the table has none: a bug.
    """
    try:
        return PHASES[phase][event]
    except KeyError:
        raise PhaseError(f"master: {event.name} in phase {phase.name} has no transition") from None

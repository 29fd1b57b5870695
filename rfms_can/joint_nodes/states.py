"""The states of a node and how it changes them: one literal table (CiA 301/402 terms).

Nothing re-enables by itself: QUICKSTOP and FAULT are left by RESET alone, and RESET leads to
PREOP, from where the arm must be homed (a node that still knows its reference is homed at once)
and started again.
"""

from enum import Enum, auto
from typing import Final

from rfms_can.errors import RfmsError
from rfms_can.wire.vocabulary import Command, NodeState


class Event(Enum):
    """What makes a node change its state."""

    BOOT = auto()
    HOME = auto()
    HOMED = auto()
    START = auto()
    STOP = auto()
    QUICKSTOP = auto()
    FAULT = auto()
    RESET = auto()
    DUPLICATE = auto()
    """Another node sends under its identifiers."""


COMMAND_EVENTS: Final = {
    Command.HOME: Event.HOME,
    Command.START: Event.START,
    Command.STOP: Event.STOP,
    Command.QUICKSTOP: Event.QUICKSTOP,
    Command.RESET: Event.RESET,
}

TRANSITIONS: Final[dict[NodeState, dict[Event, NodeState]]] = {
    NodeState.INIT: {
        Event.BOOT: NodeState.PREOP,
    },
    NodeState.PREOP: {
        Event.HOME: NodeState.HOMING,
        Event.STOP: NodeState.PREOP,
        Event.RESET: NodeState.PREOP,
        Event.FAULT: NodeState.FAULT,
        Event.DUPLICATE: NodeState.PREOP,
    },
    NodeState.HOMING: {
        Event.HOMED: NodeState.READY,
        Event.STOP: NodeState.PREOP,
        Event.QUICKSTOP: NodeState.PREOP,
        Event.RESET: NodeState.PREOP,
        Event.FAULT: NodeState.FAULT,
        Event.DUPLICATE: NodeState.PREOP,
    },
    NodeState.READY: {
        Event.HOME: NodeState.HOMING,
        Event.START: NodeState.OPERATIONAL,
        Event.STOP: NodeState.READY,
        Event.QUICKSTOP: NodeState.READY,
        Event.RESET: NodeState.PREOP,
        Event.FAULT: NodeState.FAULT,
        Event.DUPLICATE: NodeState.PREOP,
    },
    NodeState.OPERATIONAL: {
        Event.STOP: NodeState.READY,
        Event.QUICKSTOP: NodeState.QUICKSTOP,
        Event.FAULT: NodeState.FAULT,
        Event.DUPLICATE: NodeState.QUICKSTOP,
    },
    NodeState.QUICKSTOP: {
        Event.QUICKSTOP: NodeState.QUICKSTOP,
        Event.RESET: NodeState.PREOP,
        Event.FAULT: NodeState.FAULT,
        Event.DUPLICATE: NodeState.QUICKSTOP,
    },
    NodeState.FAULT: {
        Event.QUICKSTOP: NodeState.FAULT,
        Event.FAULT: NodeState.FAULT,
        Event.RESET: NodeState.PREOP,
        Event.DUPLICATE: NodeState.FAULT,
    },
}


class TransitionError(RfmsError):
    """Our own code asked for a transition the table does not have."""


def successor(state: NodeState, event: Event) -> NodeState | None:
    """State after ``event``, or None where the table has no such transition."""
    return TRANSITIONS[state].get(event)


def enter(state: NodeState, event: Event, role: str) -> NodeState:
    """State after ``event`` for our own transitions.

    Raises:
        TransitionError: the table has none: a bug.
    """
    following = successor(state, event)
    if following is None:
        raise TransitionError(f"{role}: {event.name} in state {state.name} has no transition")
    return following

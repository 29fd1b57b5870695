"""How moves end: one enumeration, and one table of what it means to a program that waits.

A further outcome is a member, its entry in ``OUTCOMES``, and the place that ends a move so
(``MoveOutcomes.ends`` or ``MoveOutcomes.abandon`` of the master).
"""

from enum import Enum
from typing import Annotated, Final, NamedTuple

import msgspec

from rfms_can.errors import FaultError, LeaseError, RfmsError, StoppedError, TrackingError
from rfms_can.messages.base import Message
from rfms_can.tables import complete

MAX_ASKED: Final = 256
"""Moves that one query may ask about."""


class Outcome(Enum):
    """How a move is over, or that it is not."""

    UNDER_WAY = "under way"
    """Not over: it waits, is being made, or the arm is coming to rest after a stop."""
    MADE = "made"
    """At rest at its goal, or handed over to the next move."""
    GUARDED = "guarded"
    """Its guard tripped: a force or a distance was reached, as the move allowed for."""
    STOPPED = "stopped"
    """Stopped or dropped by a request: ``stop()``, or the arm was given back in motion."""
    SHORT = "stopped short"
    """The arm could not follow: a reference, or the force on it, led where it cannot go."""
    LAPSED = "lapsed"
    """Stopped or dropped because the lease of its program was not renewed in time."""
    FAULTED = "faulted"
    """Ended by a fault, which has halted the arm."""


class OutcomeRule(NamedTuple):
    """What an outcome means to a program.

    Attributes:
        over: whether the move is over.
        error: what ``wait(number)`` raises; None where the move ended as it was meant to.
        requested: whether the program has asked for it: ``wait()`` for rest is then no error.
    """

    over: bool
    error: type[RfmsError] | None
    requested: bool = False


OUTCOMES: Final = complete(
    {
        Outcome.UNDER_WAY: OutcomeRule(over=False, error=None),
        Outcome.MADE: OutcomeRule(over=True, error=None),
        Outcome.GUARDED: OutcomeRule(over=True, error=None),
        Outcome.STOPPED: OutcomeRule(over=True, error=StoppedError, requested=True),
        Outcome.SHORT: OutcomeRule(over=True, error=TrackingError),
        Outcome.LAPSED: OutcomeRule(over=True, error=LeaseError),
        Outcome.FAULTED: OutcomeRule(over=True, error=FaultError),
    },
    Outcome,
)


class MoveOutcome(msgspec.Struct, frozen=True):
    """How one move ended.

    Attributes:
        sequence: its number.
        how: its outcome.
        reason: who or what ended it, one line; empty if it was made or is under way.
    """

    sequence: int
    how: Outcome
    reason: str = ""

    @property
    def over(self) -> bool:
        """Whether the move is over."""
        return OUTCOMES[self.how].over


class OutcomeQuery(Message, frozen=True, tag="OUTCOME"):
    """Query how moves ended; needs no lease. At most 256 moves at a time.

    Attributes:
        first: number of the first move.
        last: number of the last move.
    """

    first: Annotated[int, msgspec.Meta(ge=1)]
    last: Annotated[int, msgspec.Meta(ge=1)]

"""When a stop is over."""

from typing import Final

from rfms_can.messages import AtRest, CycleReached, Status

STOPPING_S: Final = 20.0
"""Time after which an arm that was stopped is not waited for any more, s: it shakes, and is braked
as it is."""


def stopped(status: Status) -> tuple[AtRest, CycleReached]:
    """Conditions of which one ends a stop that begins now: the arm rests, or never will."""
    return AtRest(), CycleReached(status.cycle + round(STOPPING_S / status.period))

"""When a stop is over, and a program whose moves are: an arm that shakes comes to no rest."""

from typing import Final

from rfms_can.coordinator.link import AsyncLink, Link
from rfms_can.errors import ProgramError
from rfms_can.messages import AtRest, CycleReached, Status

STOPPING_S: Final = 20.0
"""Time after which an arm that has nothing to do is not waited for any more, s: it shakes."""


def stopped(status: Status) -> tuple[AtRest, CycleReached]:
    """Conditions of which one ends a stop that begins now: the arm rests, or never will."""
    return AtRest(), CycleReached(status.cycle + round(STOPPING_S / status.period))


def wait_for_rest(link: Link) -> None:
    """Wait for all moves that have been asked for, and until the arm rests.

    Raises:
        ProgramError: its moves are over, and it shakes.
    """
    rests = False
    while not rests:
        before = link.status()
        link.wait(*stopped(before))
        rests = _rests(before, link.status())


async def wait_for_rest_async(link: AsyncLink) -> None:
    """``wait_for_rest`` for coroutines."""
    rests = False
    while not rests:
        before = link.status()
        await link.wait(*stopped(before))
        rests = _rests(before, link.status())


def _rests(before: Status, now: Status) -> bool:
    """Whether the arm rests at last.

    Raises:
        ProgramError: it had nothing to do but that for all the time between.
    """
    had_moves = before.waiting > 0 or before.completed < before.sequence
    if not now.at_rest and not had_moves:
        raise ProgramError(
            f"the arm has not come to rest within {STOPPING_S:g} s after its last move: it follows "
            "what moves, or shakes; is the mass in its mode what the hand holds?"
        )
    return now.at_rest

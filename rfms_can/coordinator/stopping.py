"""Waiting without end: what an arm that is paused or shakes never does is told after a while."""

from typing import Final

from rfms_can.coordinator.link import AsyncLink, Link
from rfms_can.errors import ProgramError
from rfms_can.messages import AnyCondition, AtRest, CycleReached, Status

STOPPING_S: Final = 20.0
"""Time after which an arm that has nothing to do is not waited for any more, s."""
_REST: Final = AtRest()


def stopped(status: Status) -> tuple[AtRest, CycleReached]:
    """Conditions of which one ends a stop that begins now: the arm rests, or never will."""
    return _REST, _later(status)


def wait_for(link: Link, condition: AnyCondition = _REST) -> None:
    """Wait until a condition holds; at rest all moves that have been asked for are over.

    Raises:
        ProgramError: it never will: the arm is paused, or has nothing to do and shakes.
    """
    waits = True
    while waits:
        before = link.status()
        link.wait(condition, _later(before))
        waits = _waits(before, link.status())


async def wait_for_rest(link: AsyncLink) -> None:
    """``wait_for`` for the end of a program of coroutines, where no part is left to move the arm.

    Raises:
        ProgramError: see ``wait_for``.
    """
    waits = True
    while waits:
        before = link.status()
        await link.wait(*stopped(before))
        waits = _waits(before, link.status())


def _later(status: Status) -> CycleReached:
    return CycleReached(status.cycle + round(STOPPING_S / status.period))


def _waits(before: Status, now: Status) -> bool:
    """Whether to go on waiting: the condition does not hold yet, and may.

    Raises:
        ProgramError: it cannot.
    """
    if now.cycle < _later(before).cycle:
        return False
    had_moves = before.waiting > 0 or before.completed < before.sequence
    if had_moves and before.feed == now.feed == 0.0:
        raise ProgramError(
            "the arm is paused, and nobody else resumes it: resume() before you wait"
        )
    if not now.at_rest and not had_moves:
        raise ProgramError(
            f"the arm has not come to rest within {STOPPING_S:g} s after its last move: it follows "
            "what moves, or shakes; is the mass in its mode what the hand holds?"
        )
    return True

"""Waiting for moves: how long, where the arm is paused or does not rest, and how they ended."""

from typing import Final

from rfms_can.coordinator.link import AsyncLink, Link
from rfms_can.coordinator.moves import Moves
from rfms_can.errors import ProgramError
from rfms_can.messages import AnyCondition, AtRest, CycleReached, Status

STOPPING_S: Final = 20.0
"""Longest wait for an idle arm to come to rest, s."""
_REST: Final = AtRest()


def stopped(status: Status) -> tuple[AtRest, CycleReached]:
    """Conditions that end a stop that begins now: the arm rests, or the timeout has passed."""
    return _REST, _later(status)


def wait_for(link: Link, condition: AnyCondition = _REST) -> None:
    """Wait until a condition holds; at rest all requested moves are complete.

    Raises:
        ProgramError: it will not hold: the arm is paused, or does not come to rest.
    """
    waits = True
    while waits:
        before = link.status()
        link.wait(condition, _later(before))
        waits = _waits(before, link.status())


async def wait_for_rest(link: AsyncLink) -> None:
    """``wait_for`` for the end of a program of coroutines, when no part can move the arm.

    Raises:
        ProgramError: see ``wait_for``.
    """
    waits = True
    while waits:
        before = link.status()
        await link.wait(*stopped(before))
        waits = _waits(before, link.status())


def finish(link: Link, moves: Moves, sequence: int | None = None) -> None:
    """Wait until a move is over, or for rest, and raise what happened if it was not made.

    Args:
        link: to the server.
        moves: of the program.
        sequence: number of the move; None: until the arm rests.

    Raises:
        ProgramError: see ``wait_for``; ``StoppedError``: the move was stopped.
        LeaseError: the move ended because the lease had lapsed.
        FaultError: a fault ended it.
    """
    wait_for(link, moves.over(sequence))
    asked = moves.asked(sequence)
    if asked is not None:
        moves.judge(link.outcomes(*asked), at_rest=sequence is None)


async def judge(link: AsyncLink, moves: Moves, sequence: int | None = None) -> None:
    """Raise what happened to moves that are over, for a program of coroutines; see ``finish``."""
    asked = moves.asked(sequence)
    if asked is not None:
        moves.judge(await link.outcomes(*asked), at_rest=sequence is None)


def _later(status: Status) -> CycleReached:
    return CycleReached(status.cycle + round(STOPPING_S / status.period))


def _waits(before: Status, now: Status) -> bool:
    """Whether to wait on: the condition does not hold yet, but may.

    Raises:
        ProgramError: it cannot.
    """
    if now.cycle < _later(before).cycle:
        return False
    had_moves = before.waiting > 0 or before.completed < before.sequence
    if had_moves and before.feed == now.feed == 0.0:
        raise ProgramError(
            "the arm is paused, and no other part can resume it: resume() before you wait"
        )
    if not now.at_rest and not had_moves:
        raise ProgramError(
            f"the arm has not come to rest within {STOPPING_S:g} s after its last move: it follows "
            "a moving reference, or oscillates; is the mass of its mode that of the payload?"
        )
    return True

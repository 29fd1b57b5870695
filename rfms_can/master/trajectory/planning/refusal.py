"""Why a move is refused, and what would do instead: tried before it is offered.

What is offered is planned as the program would ask for it: with the very settings of the mode that
``remedy`` has, rounded as they are there, after the same segment and at the same tick.
"""

from collections.abc import Callable, Mapping
from typing import Any, Final

from rfms_can.errors import KinematicsError, MoveError
from rfms_can.master.trajectory.planning.effort import Effort, TooLongError
from rfms_can.master.trajectory.planning.remedy import RefusedError, Remedy

ELSEWHERE: Final = "place position or path elsewhere"
UNTRIED: Final = (
    "what would do was not looked for, since in real time the next cycle does not wait: ask for it "
    "on another clock"
)
IN_A_ROW: Final = 3
"""Offers that are taken one after the other, each for what the one before is refused for."""

Change = Mapping[str, Any]
"""Of a mode, by the names of its settings; ``wait`` is the move to wait for."""
Attempt = Callable[[Change], object]
"""Plans the refused move with a change; raises as planning does."""
Error = MoveError | KinematicsError


def refusal(error: Error, others: list[Remedy], attempt: Attempt, effort: Effort) -> Error:
    """The refusal ``error`` with what would do instead: what it offers, or the first alternative.

    Args:
        error: of the move as it was asked for.
        others: what may be tried where nothing that it offers does.
        attempt: plans the move otherwise.
        effort: that planning may take; where it is spent no more is tried.
    """
    if isinstance(error, TooLongError):
        return error
    kind = MoveError if isinstance(error, RefusedError) else type(error)
    fault, offer = _followed(error, attempt, {})
    offer = offer or _first(others, attempt) or Remedy(UNTRIED if effort.spent else ELSEWHERE, {})
    better = kind(f"{fault}: {offer.words}")
    better.remedy = offer.change
    return better


def _followed(error: Error, attempt: Attempt, change: Change) -> tuple[str, Remedy | None]:
    """What is wrong, in words, and what of the offers that are made for it does.

    Where none does, the first is taken all the same, and what it is refused for looked at.

    Args:
        error: what is wrong.
        attempt: plans the move otherwise.
        change: with which it is wrong.
    """
    fault = first = _fault(error)
    name = first.partition(": ")[0] + ": "
    for _ in range(IN_A_ROW):
        if not isinstance(error, RefusedError) or not error.offers:
            break
        offers = [each._replace(change={**change, **each.change}) for each in error.offers]
        failures = [_failure(attempt, offer.change) for offer in offers]
        good = [offer for offer, no in zip(offers, failures, strict=True) if no is None]
        if good:
            words = ", or ".join(offer.words for offer in good)
            return fault, good[0]._replace(words=words)
        change, error = offers[0].change, failures[0] or error
        fault = f"{first}; with {_listed(change)}, {_fault(error).removeprefix(name)}"
    return fault, None


def _first(others: list[Remedy], attempt: Attempt) -> Remedy | None:
    """The first of some alternatives that does, or does with what its own refusal offers."""
    failures: list[tuple[Remedy, Error]] = []
    for other in others:
        failure = _failure(attempt, other.change)
        if failure is None:
            return other
        failures.append((other, failure))
    for other, failure in failures:
        _, offer = _followed(failure, attempt, other.change)
        if offer is not None:
            more = {name: offer.change[name] for name in offer.change if name not in other.change}
            return Remedy(f"{other.words}, with {_listed(more)}", offer.change)
    return None


def _failure(attempt: Attempt, change: Change) -> Error | None:
    """Why the move is refused with a change; None if it is not."""
    try:
        attempt(change)
    except (MoveError, KinematicsError) as error:
        return error
    return None


def _fault(error: Error) -> str:
    return error.fault if isinstance(error, RefusedError) else str(error)


def _listed(change: Change) -> str:
    return ", ".join(f"{name}={value!r}" for name, value in change.items())

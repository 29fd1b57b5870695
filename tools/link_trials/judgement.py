"""A trial's row, and what in it is not as it must be."""

from collections.abc import Iterable, Sequence
from enum import Enum
from typing import Final, NamedTuple

import msgspec

from rfms_can.messages import Outcome
from rfms_can.messages.outcomes import OUTCOMES
from rfms_can.tables import complete

KILLED: Final = -9
MADE: Final = Outcome.MADE.value
LOSS_HEARD: Final = frozenset(("LeaseError", "LinkError"))
"""Errors that tell a client it has lost the arm."""


class Event(Enum):
    """What happens to a client in motion."""

    KILL = "killed"
    FREEZE = "frozen"
    CUT = "connection lost"
    TAKEN = "frozen, lease taken by another"
    GIVEN = "interrupted, lease given back"


class EventRule(NamedTuple):
    """What an event means for its trial.

    Attributes:
        goes_on: whether the client goes on afterwards, and has to hear the truth.
        over_tcp: whether the client is connected through the relay.
        heard: the error it must hear in any case; None: it depends on what the server did.
    """

    goes_on: bool = True
    over_tcp: bool = False
    heard: str | None = None


EVENTS: Final = complete(
    {
        Event.KILL: EventRule(goes_on=False),
        Event.FREEZE: EventRule(),
        Event.CUT: EventRule(over_tcp=True),
        Event.TAKEN: EventRule(heard="LeaseError"),
        Event.GIVEN: EventRule(heard="KeyboardInterrupt"),
    },
    Event,
)


class Row(msgspec.Struct, frozen=True):
    """What a trial has shown.

    Attributes:
        seed: of the trial.
        event: what happened to the client.
        program: what it was doing.
        lasted_s: how long it was frozen or cut off, s; 0 if it was not.
        in_motion: whether the arm moved when it happened.
        lost: whether the server took the lease from the client.
        exit: the client's exit code; None if it did not end.
        heard: class of the error its program ended with, or None.
        claims: outcomes the client took for true, by the number of the move.
        truth: the server's outcomes of its moves.
        rest_s: wall time from the event to the arm's rest, s; None if it did not rest.
        served: how the next client's move ended.
        fault: of the arm, or None.
    """

    seed: int
    event: Event
    program: str
    lasted_s: float
    in_motion: bool
    lost: bool
    exit: int | None
    heard: str | None
    claims: dict[str, str]
    truth: dict[str, str]
    rest_s: float | None
    served: str
    fault: str | None


def violations(row: Row) -> list[str]:
    """What in a trial is not the truth, or left arm or server unfit; empty if all is well."""
    found = []
    if row.fault is not None:
        found.append(f"the arm is halted: {row.fault}")
    if row.rest_s is None:
        found.append("the arm did not come to rest")
    if row.served != MADE:
        found.append(f"the next client's move: {row.served}")
    if EVENTS[row.event].goes_on:
        found += _untruths(row)
    elif row.exit != KILLED:
        found.append(f"killed, with exit code {row.exit}")
    return found


def _untruths(row: Row) -> list[str]:
    """What a client that went on was told, or not told, against what the server did."""
    if row.exit is None:
        return ["the client never ended"]
    found = [
        f"move {number}: the client took it for {claim}, it was {row.truth.get(number)}"
        for number, claim in row.claims.items()
        if row.truth.get(number) != claim
    ]
    failed = [number for number, how in row.truth.items() if OUTCOMES[Outcome(how)].error]
    wanted = EVENTS[row.event].heard
    if wanted is not None and row.heard != wanted:
        found.append(f"heard {row.heard}, not {wanted}")
    if row.lost and row.heard not in LOSS_HEARD:
        found.append(f"lost the lease and heard {row.heard}")
    if (failed or row.lost) and row.exit == 0:
        found.append(f"exit code 0 although moves {', '.join(failed) or 'none'} were not made")
    if row.exit == 0 and not row.truth:
        found.append("exit code 0 without a move")
    if row.heard is None and row.exit != 0:
        found.append(f"exit code {row.exit} without an error")
    return found


def summary(rows: Sequence[Row]) -> Iterable[tuple[str, ...]]:
    """A line for each event; the columns are those of docs/link-campaign.md."""
    for event in Event:
        own = [row for row in rows if row.event is event]
        if not own:
            continue
        rests = [row.rest_s for row in own if row.rest_s is not None]
        heard: dict[str, int] = {}
        for row in own:
            word = "nothing: it was killed" if row.exit == KILLED else row.heard or "no error: made"
            heard[word] = heard.get(word, 0) + 1
        yield (
            event.value,
            str(len(own)),
            str(sum(row.in_motion for row in own)),
            str(sum(row.lost for row in own)),
            ", ".join(f"{count} {word}" for word, count in sorted(heard.items())),
            f"{max(rests, default=0.0):.1f}",
            str(sum(row.served == MADE for row in own)),
            str(sum(bool(violations(row)) for row in own)),
        )

"""Faults of frames on the simulated bus: lost, copied, late, out of order, corrupt, of wrong kind.

The sender's own transmit confirmation is left alone, as CAN leaves it: what is wrong is wrong at
the receivers, or in a gateway before them.
"""

from collections.abc import Callable
from typing import Any, Final

from rfms_can.bus.disturbance import EVERYONE, Disturbance, Disturber
from rfms_can.faults.context import Context
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import NODE_NAMES
from rfms_can.wire.records import Setpoint, Sync

BURST: Final = 5
"""Frames in a row that a burst takes: two more than the bound of a burst."""
FOR_EVER: Final = 1 << 30
DEAF_CYCLES: Final = 5
LATE: Final = 0.9
"""Part of a period by which a late frame is late: it comes before its follower."""
BEHIND: Final = 1.3
"""Periods by which a frame comes behind its follower."""
OFTEN: Final = 3
"""Of the frames of an identifier every third is corrupt: at least three in ten."""

Make = Callable[[Context], Disturber]
Verdict = Callable[[Frame], Disturbance]

_NUMBERED: Final[dict[type[Any], int | None]] = {Sync: None, Setpoint: 1}
"""Messages that are not numbered by the joint they are for."""


def identifier(context: Context, record: type[Any]) -> int:
    """Of a message of the joint at fault, or of the one there is."""
    return context.wire.id(record, _NUMBERED.get(record, context.node))


def of_message(record: type[Any], verdict: Verdict, count: int = 1, every: int = 1) -> Make:
    """Disturb frames of a message.

    Args:
        record: of the message.
        verdict: what is done to each of them.
        count: how many are disturbed.
        every: of how many frames one is.
    """

    def make(context: Context) -> Disturber:
        wanted, seen = identifier(context, record), 0

        def disturb(_: int, frame: Frame, _sender: str) -> Disturbance | None:
            nonlocal seen
            if frame.id != wanted:
                return None
            number, rest = divmod(seen, every)
            seen += 1
            if rest or number >= count:
                return None
            context.touch()
            return verdict(frame)

        return disturb

    return make


def lost(_: Frame) -> Disturbance:
    """No receiver gets it."""
    return Disturbance(lost_at=EVERYONE)


def copied(_: Frame) -> Disturbance:
    """It comes twice."""
    return Disturbance(copies=1)


def corrupt(frame: Frame) -> Disturbance:
    """A bit of its last byte is another one."""
    return Disturbance(data=bytes((*frame.data[:-1], frame.data[-1] ^ 0x10)))


def short(frame: Frame) -> Disturbance:
    """It ends early."""
    return Disturbance(data=frame.data[:7])


def long(frame: Frame) -> Disturbance:
    """It is four bytes longer."""
    return Disturbance(data=frame.data + bytes(4))


def classic(frame: Frame) -> Disturbance:
    """It comes as a frame of classic CAN."""
    return Disturbance(data=frame.data[:8], fd=False)


def late(periods: float, record: type[Any]) -> Make:
    """One frame of a message comes some periods late."""

    def make(context: Context) -> Disturber:
        delay_ns = round(periods * context.period_ns)
        return of_message(record, lambda _: Disturbance(delay_ns=delay_ns))(context)

    return make


def deaf(node: int | None = None, cycles: int = DEAF_CYCLES) -> Make:
    """A node, that at fault if none is named, gets no frame for some cycles: its receive queue
    overflows."""

    def make(context: Context) -> Disturber:
        name = NODE_NAMES[context.node if node is None else node]
        until_ns = context.now_ns() + cycles * context.period_ns

        def disturb(now_ns: int, _: Frame, sender: str) -> Disturbance | None:
            if now_ns >= until_ns or sender == name:
                return None
            context.touch()
            return Disturbance(lost_at=frozenset((name,)))

        return disturb

    return make

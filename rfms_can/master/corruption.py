"""Frames that are refused again and again, though never three times in a row.

A single bad frame is discarded and its cycle goes on without it (R0); three bad ones among the
last ten that were due show a node, or a gateway, that is broken.
"""

from collections import deque
from typing import Final, NamedTuple

from rfms_can.master.fault import Fault
from rfms_can.messages.culprit import Culprit

MOST: Final = 3
"""Bad frames of one message among its last ``WINDOW``, at which the arm is halted."""
SUSPICIOUS: Final = 2
"""Bad samples among the last ``WINDOW`` from which on their joint's silence is laid to them."""
WINDOW: Final = 10
"""Frames of a message that were due last."""


class Watched(NamedTuple):
    """A message that is waited for.

    Attributes:
        name: of the message.
        sender: name of its sender.
        answer: its bit among the answers of a cycle.
        every: cycles from one to the next.
    """

    name: str
    sender: str
    answer: int
    every: int


class Corruption:
    """Counts bad frames in the place of which no good one has come.

    Args:
        watched: the messages, by identifier.
    """

    __slots__ = ("_bad", "_now", "_watched")

    def __init__(self, watched: dict[int, Watched]) -> None:
        self._watched: Final = watched
        self._bad: dict[int, deque[int]] = {}  # when the last ones were due, by identifier
        self._now: dict[int, str] = {}  # refused in this cycle, and why

    def begin(self) -> None:
        """A cycle begins."""
        if self._now:
            self._now.clear()

    def forget(self) -> None:
        """The arm is enabled: what came before does not count."""
        self._bad.clear()
        self._now.clear()

    def refused(self, identifier: int, why: str) -> None:
        """A frame was refused for what it carries."""
        if identifier in self._watched:
            self._now[identifier] = why

    def end_incomplete(self, closed: int, missing: int, cycle: int) -> Fault | None:
        """A cycle has ended without all answers; who has sent too many bad ones, or None.

        Args:
            closed: cycles closed so far.
            missing: bits of the answers that have not come.
            cycle: number of this one.
        """
        for identifier, why in self._now.items():
            message = self._watched[identifier]
            if not message.answer & missing:
                continue
            due = closed // message.every
            bad = self._bad.setdefault(identifier, deque(maxlen=MOST))
            bad.append(due)
            if len(bad) == MOST and due - bad[0] < WINDOW:
                name, sender = message.name, message.sender
                return Fault(
                    f"{sender}: {MOST} of the last {WINDOW} {name} were refused ({why}): is its "
                    f"bus, or a gateway before it, disturbed?",
                    Culprit(sender, name, cycle, float(MOST), float(MOST)),
                )
        return None

    def behind(self, frame: str, silent: int, closed: int, cycle: int) -> Fault | None:
        """What lies behind the silence of a joint: bad samples of its board, or None.

        A joint answers no cycle without MEASURE; where one is missing as a transition begins it
        cannot follow any more.

        Args:
            frame: what does not come, e.g. ``ERROR_4``.
            silent: cycles for which it has not.
            closed: cycles closed so far.
            cycle: number of this one.
        """
        kind, _, joint = frame.partition("_")
        for identifier, bad in self._bad.items():
            name, sender, _, _ = self._watched[identifier]
            if kind != "ERROR" or name != f"MEASURE_{joint}":
                continue
            count = sum(closed - due < WINDOW for due in bad)
            if count >= SUSPICIOUS and closed - bad[-1] <= silent:
                return Fault(
                    f"{sender}: {count} of the last {WINDOW} {name} were refused, and joint "
                    f"{joint} has not answered since (no {frame} for {silent} cycles)",
                    Culprit(sender, name, cycle, float(count), float(MOST)),
                )
        return None

"""What is on the bus beside what is due: babbling nodes, and strangers that take the bus away.

The master hears every frame of a cycle. Each message is due once in a cycle, or less often; a node
that sends one more than twice as often babbles. What no node of this bus sends is harmless until
the bus is full: then the stranger is to blame.
"""

from collections.abc import Callable, Mapping
from typing import Final, NamedTuple

from rfms_can.master.fault import Fault
from rfms_can.messages.culprit import FOREIGN, Culprit
from rfms_can.wire.frame import Frame

MOST_IN_A_CYCLE: Final = 2
"""Frames of one message in a cycle: twice what is due."""
BABBLING_CYCLES: Final = 2
"""Cycles in a row with more, after which its sender babbles: a single one may be a repetition."""
FULL: Final = 0.95
"""Load of the bus in a cycle from which it is full."""
FULL_CYCLES: Final = 2
"""Full cycles in a row with strangers' frames, after which these are to blame."""
MOST_OF_IT: Final = 0.5
"""Part of a cycle that strangers may take, at most, if it is full: beyond, one cycle is enough."""

BusTime = Callable[[Frame], int]
"""How long a frame takes on the bus, ns."""


class Message(NamedTuple):
    """A message that is due.

    Attributes:
        name: of the message.
        sender: name of its sender.
        length: of its frames, bytes.
    """

    name: str
    sender: str
    length: int


class Traffic:
    """Counts the frames of each cycle.

    Args:
        messages: those that are due, by identifier.
        bus_time: how long a frame takes; None where the bus has no such time.

    Attributes:
        counts: frames of each of them in the cycle under way; who hears one adds it.
    """

    __slots__ = (
        "_babbling",
        "_bus_time",
        "_foreign",
        "_full",
        "_messages",
        "counts",
    )

    def __init__(self, messages: Mapping[int, Message], bus_time: BusTime | None = None) -> None:
        self._messages = messages
        self._bus_time = bus_time
        self.counts = dict.fromkeys(messages, 0)
        self._foreign: dict[int, int] = {}  # bus time in this cycle, ns, by identifier
        self._babbling: dict[int, int] = {}  # cycles in a row, by identifier
        self._full = 0  # cycles in a row

    def hear_foreign(self, frame: Frame) -> None:
        """A frame has come that no node of this bus sends."""
        if self._bus_time is not None:
            taken = self._foreign.get(frame.id, 0)
            self._foreign[frame.id] = taken + self._bus_time(frame)

    def forget(self) -> None:
        """Begin again: what came before is judged by no bound."""
        self.counts = dict.fromkeys(self._messages, 0)
        self._foreign.clear()
        self._babbling.clear()
        self._full = 0

    def end_cycle(self, cycle: int, duration_ns: int) -> Fault | None:
        """A cycle is over; who has taken too much of it, or None.

        Args:
            cycle: its number.
            duration_ns: from its SYNC to the next.
        """
        counts = self.counts
        fault = None
        if self._babbling or max(counts.values()) > MOST_IN_A_CYCLE:
            fault = self._babble(cycle)
        if self._foreign:
            fault = fault or self._crowding(cycle, duration_ns)
            self._foreign.clear()
        else:
            self._full = 0
        self.counts = dict.fromkeys(counts, 0)
        return fault

    def _time_of(self, identifier: int, count: int) -> int:
        """Bus time of so many frames of a message, ns: with stuff bits as if it were all zeros."""
        if self._bus_time is None:
            return 0
        return count * self._bus_time(Frame(identifier, bytes(self._messages[identifier].length)))

    def _babble(self, cycle: int) -> Fault | None:
        many = {i: n for i, n in self.counts.items() if n > MOST_IN_A_CYCLE}
        self._babbling = {i: self._babbling.get(i, 0) + 1 for i in many}
        long = [i for i, cycles in self._babbling.items() if cycles >= BABBLING_CYCLES]
        if not long:
            return None
        worst = max(long, key=lambda i: many[i])
        name, sender, _ = self._messages[worst]
        return Fault(
            f"{sender} babbles: {many[worst]} {name} in a cycle (bound {MOST_IN_A_CYCLE}, "
            f"{BABBLING_CYCLES} cycles): stop it, or look for a second one of its number",
            Culprit(sender, name, cycle, float(many[worst]), float(MOST_IN_A_CYCLE)),
        )

    def _crowding(self, cycle: int, duration_ns: int) -> Fault | None:
        foreign = sum(self._foreign.values())
        ours = sum(self._time_of(i, n) for i, n in self.counts.items() if n)
        load = min((foreign + ours) / duration_ns, 1.0) if duration_ns > 0 else 0.0
        self._full = self._full + 1 if load > FULL else 0
        if self._full < (1 if foreign > MOST_OF_IT * duration_ns else FULL_CYCLES):
            return None
        worst = max(self._foreign, key=lambda i: self._foreign[i])
        part = self._foreign[worst] / duration_ns
        return Fault(
            f"foreign frames fill the bus: identifier {worst:#05x} takes {part:.0%} of a cycle, "
            f"the load is {load:.0%} (bound {FULL:.0%}): no node of this bus sends it",
            Culprit(FOREIGN, f"{worst:#05x}", cycle, load, FULL),
        )

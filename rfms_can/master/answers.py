"""What a control cycle waits for, and what has come: one bit for each frame.

A cycle is over when everything has been heard, the master's own ROWS included (heard back when
they have gone out, so that SYNC never names a set that is still in a queue).
"""

from typing import Final, NamedTuple

from rfms_can.master.fault import Fault
from rfms_can.master.phases import CYCLING, Phase
from rfms_can.messages.culprit import Culprit
from rfms_can.tables import complete
from rfms_can.wire.nodes import GRIPPER, HEARTBEAT_EVERY, JOINTS, MASTER, NODE_NAMES, PLANT

SILENCE_BOUND: Final = 3
"""Consecutive cycles without an answer after which its node counts as lost (faults 11 and 13)."""

_KINDS: Final = ("MEASURE", "REFERENCE", "ERROR", "DAC", "ROWS", "HEARTBEAT", "FORCE")
_NODES: Final = 10
_SENDERS: Final = {"MEASURE": PLANT, "REFERENCE": PLANT, "ROWS": MASTER, "FORCE": PLANT}
"""Who sends what is numbered by the node it is for."""


def bit(kind: str, node: int) -> int:
    """The bit of one frame, e.g. ``bit("DAC", 3)``."""
    return 1 << (_KINDS.index(kind) * _NODES + node)


def _bits(kind: str, nodes: tuple[int, ...]) -> int:
    return sum(bit(kind, node) for node in nodes)


_SERVOS: Final = (*JOINTS, GRIPPER)
MEASURES: Final = _bits("MEASURE", JOINTS)
REFERENCES: Final = _bits("REFERENCE", JOINTS)
_BOARDS: Final = MEASURES | bit("MEASURE", GRIPPER) | _bits("ROWS", JOINTS)
_BEATS: Final = _bits("HEARTBEAT", (*_SERVOS, MASTER, PLANT))

EXPECTED: Final[dict[Phase, int]] = complete(
    {
        Phase.HOME: _BOARDS | REFERENCES | _bits("DAC", _SERVOS),
        Phase.READY: _BOARDS,
        Phase.RUN: _BOARDS | _bits("ERROR", JOINTS) | _bits("DAC", _SERVOS),
        Phase.HALT: _BOARDS,
        Phase.RESET: _BOARDS,
        Phase.END: _BOARDS,
    },
    CYCLING,
)
"""Frames of a cycle in each phase; heartbeats come on top when they are due."""


_ERRORS: Final = _bits("ERROR", JOINTS)
TORQUES: Final = _bits("DAC", JOINTS)
"""What the plant drives the joints by."""


class Lost(NamedTuple):
    """Who has been silent for too long.

    Attributes:
        node: number of the node that is to blame.
        frame: name of what does not come, or is not answered.
        cycles: for how many cycles.
    """

    node: int
    frame: str
    cycles: int

    @property
    def words(self) -> str:
        """The same in words."""
        name = NODE_NAMES[self.node]
        if self.frame == _UNANSWERED:
            return (
                f"{name}: {self.frame} is answered by no joint: no ERROR of any of them for "
                f"{self.cycles} cycles, though MEASURE comes"
            )
        return f"{name}: no {self.frame} for {self.cycles} cycles"

    @property
    def fault(self) -> Fault:
        """The same, as what the arm is halted for."""
        culprit = Culprit(
            NODE_NAMES[self.node], self.frame, None, float(self.cycles), float(SILENCE_BOUND)
        )
        return Fault(self.words, culprit)


_UNANSWERED: Final = "SETPOINT_1"
"""What has not gone out, or means nothing to them, where all joints lack an answer at once."""


class Answers:
    """Frames the cycle under way still waits for.

    Args:
        sensor: whether the plant tells the wrist force as well.

    Attributes:
        missing: bits not heard yet; 0 when the cycle is complete.
    """

    __slots__ = ("_sensor", "_streaks", "missing")

    def __init__(self, *, sensor: bool = False) -> None:
        self.missing = 0
        self._sensor = bit("FORCE", PLANT) if sensor else 0
        self._streaks: dict[int, tuple[int, int]] = {}

    def begin(self, phase: Phase, cycle: int) -> None:
        """A new cycle: everything is missing."""
        beats = 0 if cycle % HEARTBEAT_EVERY else _BEATS
        self.missing = EXPECTED[phase] | beats | self._sensor

    def unanswered(self, cycle: int) -> Lost | None:
        """The cycle ended incomplete: who has been silent for too long, or None.

        A joint answers with ERROR once it has its set-point and its MEASURE. Where all six lack it
        at once, and MEASURE comes, they have one cause: the set-point.
        """
        lost = None
        for position in range(self.missing.bit_length()):
            one = 1 << position
            if not self.missing & one:
                continue
            every = HEARTBEAT_EVERY if one & _BEATS else 1
            last, count = self._streaks.get(one, (cycle, 0))
            count = count + 1 if last == cycle - every else 1
            self._streaks[one] = (cycle, count)
            if count >= SILENCE_BOUND and lost is None:
                kind, node = divmod(position, _NODES)
                sender = _SENDERS.get(_KINDS[kind], node)
                lost = Lost(sender, f"{_KINDS[kind]}_{node}", count * every)
        if lost is not None and lost.frame.startswith("ERROR") and self._all_lack_errors():
            return Lost(MASTER, _UNANSWERED, lost.cycles)
        return lost

    def _all_lack_errors(self) -> bool:
        """Whether no joint has told its error, in this cycle and in those before it."""
        if self.missing & _ERRORS != _ERRORS:
            return False
        return min(self._streaks[bit("ERROR", n)][1] for n in JOINTS) >= SILENCE_BOUND - 1

    def describe(self) -> str:
        """Names of what is missing."""
        names = []
        for position in range(self.missing.bit_length()):
            if self.missing & 1 << position:
                kind, node = divmod(position, _NODES)
                names.append(f"{_KINDS[kind]}_{node}")
        return ", ".join(names)

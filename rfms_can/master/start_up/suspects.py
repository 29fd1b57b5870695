"""What the master has heard from a node besides what it waits for: bad frames, another state."""

from collections.abc import Callable
from typing import Final

from rfms_can.master.start_up.roster import EXPECTED, SERVOS, Roster
from rfms_can.wire.nodes import NODE_NAMES
from rfms_can.wire.protection import Refusal
from rfms_can.wire.vocabulary import NodeState, name_of

BadFrames = Callable[[int], "dict[Refusal, int]"]
"""Frames that were refused under the identifiers of a node, by reason."""
_DRIVES: Final = NodeState.OPERATIONAL


class Suspects:
    """Tells of a silent node what it sent instead.

    Args:
        roster: the last heartbeat of every node.
        bad_frames: counts what was refused of a node.
    """

    __slots__ = ("_bad_frames", "_roster")

    def __init__(self, roster: Roster, bad_frames: BadFrames) -> None:
        self._roster = roster
        self._bad_frames = bad_frames

    def bad(self, node: int) -> str:
        """``; 13 bad frames came from joint 3 (13 x wrong CRC)``, or nothing."""
        reasons = self._bad_frames(node)
        count = sum(reasons.values())
        if not count:
            return ""
        frames = "1 bad frame" if count == 1 else f"{count} bad frames"
        why = ", ".join(f"{n} x {reason.value}" for reason, n in reasons.items())
        return f"; {frames} came from {NODE_NAMES[node]} ({why})"

    def all_bad(self) -> str:
        """The same of every node that sent any."""
        return "".join(self.bad(node) for node in EXPECTED)

    def of(self, node: int, *, enabled: bool) -> str:
        """What is known of a node that does not answer.

        Args:
            node: its number.
            enabled: whether START has enabled it.
        """
        beat = self._roster.beats.get(node)
        state = ""
        if enabled and beat is not None and node in SERVOS and beat.state != _DRIVES:
            state = f"; its HEARTBEAT tells {name_of(NodeState, beat.state)}"
        return state + self.bad(node)

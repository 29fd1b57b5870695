"""Who is to blame for a halt, and by what: the structure that words are made from."""

import msgspec

FOREIGN = "foreign"
"""Sender of frames that no node of this bus sends."""
OPERATOR = "operator"
"""Who asks for an emergency stop at the server, or on the bus."""
PROGRAM = "program"
"""Whose request has led to it."""


class Culprit(msgspec.Struct, frozen=True):
    """Who is to blame for a halt.

    Attributes:
        sender: name of the node, e.g. ``joint 3``; ``foreign`` for a sender that is none of this
            bus, ``operator`` of an emergency stop, ``program`` of what a program asked for.
        frame: name of the message that was missing or wrong, or its identifier; empty if it is
            about none.
        cycle: number of the control cycle; None before cycles run.
        value: the number that has broken the bound; None where it is about none.
        bound: the bound, in the unit of the value; None where there is none.
    """

    sender: str
    frame: str = ""
    cycle: int | None = None
    value: float | None = None
    bound: float | None = None

    @property
    def words(self) -> str:
        """E.g. ``joint 4 (ERROR_4, 3, bound 3, cycle 812)``."""
        parts = [self.frame] if self.frame else []
        if self.value is not None:
            parts.append(f"{self.value:g}")
        if self.bound is not None:
            parts.append(f"bound {self.bound:g}")
        if self.cycle is not None:
            parts.append(f"cycle {self.cycle}")
        return f"{self.sender} ({', '.join(parts)})" if parts else self.sender

"""A second master, and frames that are bad again and again (docs/node-detectors.md, The bus)."""

MOST_AHEAD = 4
BAD_IN_A_ROW = 3
WITHIN_CYCLES = 10


class BusWatch:
    """What a joint that is driven holds against its bus."""

    def __init__(self) -> None:
        self.led = False  # SYNC has come since HOME or START
        self.obeyed = False  # RESET was taken since the last HEARTBEAT of a master
        self.bad: dict[int, list[int]] = {}  # by identifier: cycles of the last refusals

    def begin(self) -> None:
        """HOME and START."""
        self.led = False
        self.forget_bad()

    def forget_bad(self) -> None:
        """HOME, START, RESET."""
        self.bad = {}

    def is_foreign(self, cycle: int, last: int, missed: int) -> bool:
        """Whether SYNC of a cycle is a second master's; ``missed``: SYNCs in a row."""
        if not self.led:
            return False
        ahead = (cycle - last) % 2**32
        return MOST_AHEAD + missed < ahead < 2**32 - MOST_AHEAD

    def is_bad_again(self, can_id: int, cycle: int) -> bool:
        """A frame was refused, for another reason than its counter."""
        of_it = [*self.bad.get(can_id, []), cycle][-BAD_IN_A_ROW:]
        self.bad[can_id] = of_it
        return len(of_it) == BAD_IN_A_ROW and (cycle - of_it[0]) % 2**32 < WITHIN_CYCLES

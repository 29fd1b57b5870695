"""docs/node.md: which counters are taken."""


class PlainReceiver:
    """docs/node.md, "Protection": the rule of the counters."""

    def __init__(self) -> None:
        self.last: int | None = None
        self.provisional = False
        self.stray, self.row, self.needed = 0, 0, 3
        self.taken_since_stray = False

    def take(self, c: int) -> bool:
        """Whether a frame with counter ``c`` is taken."""
        if self.last is None:
            self.provisional, self.last = True, c
            self.taken_since_stray = True
            return True
        step = (c - self.last) % 256
        taken = 1 <= step <= 16 or (self.provisional and step > 0)
        if not taken:
            in_row = self.row > 0 and not self.taken_since_stray
            self.row = self.row + 1 if in_row and 1 <= (c - self.stray) % 256 <= 16 else 1
            self.stray, self.taken_since_stray = c, False
            if self.row == self.needed:
                taken, self.row, self.needed = True, 0, 2 * self.needed
        if taken:
            self.last, self.provisional, self.taken_since_stray = c, False, True
        return taken

"""What a set of rows is made for: the directions that comply, and their frame."""

from typing import Final, NamedTuple

from rfms_can.compliance.selection import Selection
from rfms_can.transform import Transform

RIGID: Final = Selection()
"""Nothing complies."""
LAST_NUMBER: Final = 255


class Compliance(NamedTuple):
    """What complies now, and where.

    Attributes:
        number: counts the changes; 0 before the first, then 1 to 255 and over again.
        selection: directions that comply.
        frame: the compliance frame in T6.
    """

    number: int = 0
    selection: Selection = RIGID
    frame: Transform = Transform.identity()

    def changed(self, selection: Selection, frame: Transform) -> "Compliance":
        """The next one."""
        return Compliance(self.number % LAST_NUMBER + 1, selection, frame)

    @property
    def bits(self) -> int:
        """The selection as the wire has it."""
        return sum(1 << i for i, selected in enumerate(self.selection) if selected)

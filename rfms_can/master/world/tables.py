"""Symbol tables (thesis VI.4.3): bounded, and with errors that list what there is."""

from itertools import islice
from typing import Final, Generic, TypeVar

from rfms_can.errors import ProgramError

Entry = TypeVar("Entry")

MAX_TRANSFORMS: Final = 2**17
"""Transforms a program may name at a time: more than the picks of a day, at one every second. Every
client that may move the arm may fill the tables: these three take 0.2 GB when they are full."""

MAX_LIVE: Final = 1024
"""References among them, and likewise functions: a table of 512 rows takes some 0.5 MB, and the
references that move on by themselves are looked at in every cycle."""

MAX_POSITIONS: Final = 2**17
"""Positions."""

MAX_MODES: Final = 2**13
"""Modes."""

LISTED: Final = 20
"""Names an error lists; a longer list does not help."""


class SymbolTable(dict[str, Entry], Generic[Entry]):
    """Entries by name, in the order they were defined.

    Args:
        kind: what they are, for errors.
        size: most of them.
        error: class of what is raised when the table is full.
    """

    def __init__(self, kind: str, size: int, error: type[ProgramError]) -> None:
        super().__init__()
        self._kind: Final = kind
        self._size: Final = size
        self._error: Final = error

    def check_room(self, name: str) -> None:
        """Raise unless one more may be entered."""
        if len(self) >= self._size:
            raise self._error(
                f"{self._kind} {name!r} is one too many: {self._size} are defined, and no more may "
                f"be; define one of them again, or remove what nothing uses"
            )

    def known(self, name: str) -> Entry:
        """An entry by name; the error of this table lists those that exist."""
        if name not in self:
            raise self._error(f"{self._kind} {name!r} is not defined; {self.listing()}")
        return self[name]

    def look_up(self, name: str) -> Entry:
        """An entry by name; ``ProgramError`` lists those that exist."""
        if name not in self:
            raise ProgramError(f"{self._kind} {name!r} is not defined; {self.listing()}")
        return self[name]

    def listing(self) -> str:
        """What there is, for an error."""
        known = ", ".join(islice(self, LISTED)) or "none"
        more = f" and {len(self) - LISTED} more" if len(self) > LISTED else ""
        return f"there are: {known}{more}"

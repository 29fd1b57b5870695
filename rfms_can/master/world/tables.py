"""Symbol tables (thesis VI.4.3): bounded, and with errors that list what there is."""

from typing import Final, Generic, TypeVar

from rfms_can.errors import ProgramError

Entry = TypeVar("Entry")

MAX_TRANSFORMS: Final = 1024
"""Transforms a program may name. Every client that may move the arm may fill the tables, and they
are only emptied with the server: a program that names more is not naming but counting."""

MAX_POSITIONS: Final = 1024
"""Positions; a pallet of 30 by 30 fits."""

MAX_MODES: Final = 256
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
                f"be; use the names there are"
            )

    def look_up(self, name: str) -> Entry:
        """An entry by name; ``ProgramError`` lists those that exist."""
        if name not in self:
            raise ProgramError(f"{self._kind} {name!r} is not defined; {self.listing()}")
        return self[name]

    def listing(self) -> str:
        """What there is, for an error."""
        names = list(self)
        known = ", ".join(names[:LISTED]) or "none"
        more = f" and {len(names) - LISTED} more" if len(names) > LISTED else ""
        return f"there are: {known}{more}"

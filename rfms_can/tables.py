"""Literal tables that are checked as they are made: each member has its entry, or import fails.

A branch ``if law is ControlLaw.X`` takes a new member silently the ``else`` way. A table that went
through ``complete`` cannot: the module that holds it does not import until the entry is there.
"""

from collections.abc import Iterable
from enum import Enum
from typing import TypeVar

from rfms_can.errors import TableError

K = TypeVar("K")
V = TypeVar("V")


def complete(table: dict[K, V], keys: Iterable[K]) -> dict[K, V]:
    """The table itself, if it has an entry for each key and no other.

    Args:
        table: what was written down.
        keys: what it must have an entry for: an enumeration, or words, or pairs of members.

    Raises:
        TableError: an entry is missing, or stands under a key that does not exist.
    """
    wanted = list(keys)
    missing = [key for key in wanted if key not in table]
    if missing:
        raise TableError(f"table without an entry for {_names(missing)}: add it where it is made")
    unknown = [key for key in table if key not in wanted]
    if unknown:
        raise TableError(f"table with an entry for {_names(unknown)}, which does not exist")
    return table


def _names(keys: Iterable[object]) -> str:
    return ", ".join(_name(key) for key in keys)


def _name(key: object) -> str:
    if isinstance(key, Enum):
        return f"{type(key).__name__}.{key.name}"
    if isinstance(key, tuple):
        return f"({_names(key)})"
    return repr(key)

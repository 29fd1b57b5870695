"""Literal tables over an enumeration: a member without an entry is an error at import."""

from collections.abc import Container, Iterable
from enum import Enum

from rfms_can.errors import RfmsError


class IncompleteTableError(RfmsError):
    """A table of our own lacks entries: a bug, raised when its module is imported."""


def require_complete(name: str, table: Container[object], members: Iterable[Enum]) -> None:
    """Check that a table has an entry for every member of an enumeration.

    Raises:
        IncompleteTableError: names the table and the members it lacks.
    """
    missing = [member.name for member in members if member not in table]
    if missing:
        raise IncompleteTableError(f"{name} has no entry for {', '.join(missing)}")

"""Where a hub lives: a directory of its owner with a socket in it (``rendezvous.py``)."""

from pathlib import Path
from typing import IO, Final

from rfms_can.errors import BusError
from rfms_can.link.rendezvous import NAME, Rendezvous, living

HUB_NAME: Final = NAME
SOCKET_FILE: Final = "socket"
_WHAT: Final = "hub"


def hub_directory(name: str) -> Path:
    """The directory of a hub, which need not exist.

    Raises:
        BusError: a name that is none.
    """
    return Rendezvous(_WHAT, name, BusError).directory


def claim(name: str) -> tuple[Path, IO[bytes]]:
    """Make the name ours: the path to bind, free of stale sockets, and the lock to keep open.

    Raises:
        BusError: a hub of that name is alive, or the directory belongs to somebody else.
    """
    place = Rendezvous(_WHAT, name, BusError)
    lock = place.claim()
    path = place.directory / SOCKET_FILE
    path.unlink(missing_ok=True)
    return path, lock


def release(path: Path, lock: IO[bytes]) -> None:
    """Take the socket away and free the lock; its file stays, for who may be opening it now."""
    path.unlink(missing_ok=True)
    lock.close()


def live_hubs() -> list[str]:
    """Names of this user's hubs that are running."""
    return living(_WHAT)

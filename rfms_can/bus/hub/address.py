"""Address of a hub: a socket in a private directory of its owner (``rendezvous.py``)."""

from pathlib import Path
from typing import IO, Final

from rfms_can.errors import BusError
from rfms_can.link.rendezvous import NAME, Rendezvous, running_names

HUB_NAME: Final = NAME
SOCKET_FILE: Final = "socket"
_WHAT: Final = "hub"


def hub_directory(name: str) -> Path:
    """The directory of a hub, which need not exist.

    Raises:
        BusError: the name is invalid.
    """
    return Rendezvous(_WHAT, name, BusError).directory


def claim(name: str) -> tuple[Path, IO[bytes]]:
    """Claim the name: the path to bind, free of stale sockets, and the lock to keep open.

    Raises:
        BusError: a hub of that name is running, or the directory belongs to another user.
    """
    place = Rendezvous(_WHAT, name, BusError)
    lock = place.claim()
    path = place.directory / SOCKET_FILE
    path.unlink(missing_ok=True)
    return path, lock


def release(path: Path, lock: IO[bytes]) -> None:
    """Remove the socket and release the lock; its file stays, another process may be opening it."""
    path.unlink(missing_ok=True)
    lock.close()


def live_hubs() -> list[str]:
    """Names of this user's hubs that are running."""
    return running_names(_WHAT)

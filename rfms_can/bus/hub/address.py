"""Where a hub lives: a directory of its owner, a socket in it, and a lock that says it is alive.

``$XDG_RUNTIME_DIR`` (or the temporary directory) ``/rfms-hub-<name>-<uid>/`` has permission 0700,
so only the owner's processes reach the socket. The lock is held as long as the hub runs and goes
with its process, however that ends: a socket without a locked lock is stale.
"""

import fcntl
import os
import re
import stat
import tempfile
from pathlib import Path
from typing import IO, Final

from rfms_can.errors import BusError

HUB_NAME: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,39}")
SOCKET_FILE: Final = "socket"
LOCK_FILE: Final = "lock"
_PREFIX: Final = "rfms-hub-"


def hub_directory(name: str) -> Path:
    """The directory of a hub, which need not exist.

    Raises:
        BusError: a name that is none.
    """
    if not HUB_NAME.fullmatch(name):
        raise BusError(
            f"hub name {name!r}: 1 to 40 letters, digits, '_', '.' or '-', a letter or digit first"
        )
    return _base() / f"{_PREFIX}{name}-{os.getuid()}"


def claim(name: str) -> tuple[Path, IO[bytes]]:
    """Make the name ours: the path to bind, free of stale sockets, and the lock to keep open.

    Raises:
        BusError: a hub of that name is alive, or the directory belongs to somebody else.
    """
    directory = hub_directory(name)
    try:
        directory.mkdir(mode=0o700, parents=True, exist_ok=True)
        _check_ours(directory)
        lock = (directory / LOCK_FILE).open("a+b")
    except OSError as error:
        raise BusError(f"hub {name!r}: {directory} cannot be used: {error.strerror}") from error
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        lock.seek(0)
        owner = lock.read(20).decode("ascii", "replace") or "unknown"
        lock.close()
        raise BusError(
            f"hub {name!r} is running already (process {owner}): stop it or take another name"
        ) from error
    lock.truncate(0)
    lock.write(str(os.getpid()).encode())
    lock.flush()
    path = directory / SOCKET_FILE
    path.unlink(missing_ok=True)
    return path, lock


def release(path: Path, lock: IO[bytes]) -> None:
    """Take the socket away and free the lock; its file stays, for who may be opening it now."""
    path.unlink(missing_ok=True)
    lock.close()


def live_hubs() -> list[str]:
    """Names of this user's hubs that are running."""
    suffix = f"-{os.getuid()}"
    names = []
    for directory in sorted(_base().glob(f"{_PREFIX}*{suffix}")):
        if _is_locked(directory / LOCK_FILE):
            names.append(directory.name.removeprefix(_PREFIX).removesuffix(suffix))
    return names


def _base() -> Path:
    return Path(os.environ.get("XDG_RUNTIME_DIR") or tempfile.gettempdir())


def _check_ours(directory: Path) -> None:
    status = directory.lstat()
    if not stat.S_ISDIR(status.st_mode) or status.st_uid != os.getuid():
        raise BusError(f"{directory} is not a directory of this user: somebody else took the name")
    if stat.S_IMODE(status.st_mode) != 0o700:
        raise BusError(f"{directory} is open to others: chmod 700 it or remove it")


def _is_locked(path: Path) -> bool:
    try:
        with path.open("rb") as lock:
            fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    return False

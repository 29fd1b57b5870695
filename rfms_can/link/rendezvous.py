"""How processes of one user find each other: a private directory, and a lock held while alive.

``$XDG_RUNTIME_DIR`` (or the temporary directory) ``/rfms-<what>-<name>-<uid>/`` has permission
0700, so only the owner's processes reach the sockets in it. The process that claimed the name holds
the lock, and the kernel releases it when the process ends: a socket without a held lock is stale.
"""

import fcntl
import os
import re
import stat
import tempfile
from pathlib import Path
from typing import IO, Final, NamedTuple

from rfms_can.errors import RfmsError

NAME: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,39}")
LOCK_FILE: Final = "lock"


class Rendezvous(NamedTuple):
    """A name under which processes of this user find a server or a hub.

    Attributes:
        what: kind of process, e.g. ``hub``.
        name: 1 to 40 letters, digits, ``_``, ``.`` or ``-``.
        error: type of the errors raised.
    """

    what: str
    name: str
    error: type[RfmsError]

    @property
    def directory(self) -> Path:
        """Its directory, which need not exist.

        Raises:
            RfmsError: (as ``error``) the name is invalid.
        """
        if not NAME.fullmatch(self.name):
            raise self.error(
                f"{self.what} name {self.name!r}: 1 to 40 letters, digits, '_', '.' or '-', "
                f"a letter or digit first"
            )
        return _base() / f"rfms-{self.what}-{self.name}-{os.getuid()}"

    def claim(self) -> IO[bytes]:
        """Claim the name; returns the lock, to be kept open.

        Raises:
            RfmsError: (as ``error``) the name is in use, or the directory is another user's.
        """
        directory = self.directory
        try:
            directory.mkdir(mode=0o700, parents=True, exist_ok=True)
            self.check_ours()
            lock = (directory / LOCK_FILE).open("a+b")
        except OSError as error:
            raise self.error(
                f"{self.what} {self.name!r}: {directory} cannot be used: {error.strerror}"
            ) from error
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            lock.seek(0)
            owner = lock.read(20).decode("ascii", "replace") or "unknown"
            lock.close()
            raise self.error(
                f"{self.what} {self.name!r} is running already (process {owner}): stop it or take "
                f"another name"
            ) from error
        lock.truncate(0)
        lock.write(str(os.getpid()).encode())
        lock.flush()
        return lock

    def check_ours(self) -> None:
        """Check that the directory belongs to this user and is closed to others.

        Raises:
            RfmsError: (as ``error``) it is not.
            FileNotFoundError: it does not exist.
        """
        directory = self.directory
        status = directory.lstat()
        if not stat.S_ISDIR(status.st_mode) or status.st_uid != os.getuid():
            raise self.error(
                f"{directory} is not a directory of this user: another user has the name"
            )
        if stat.S_IMODE(status.st_mode) != 0o700:
            raise self.error(f"{directory} is open to others: chmod 700 it or remove it")

    @property
    def alive(self) -> bool:
        """Whether a process holds the name now."""
        return _is_locked(self.directory / LOCK_FILE)


def running_names(what: str) -> list[str]:
    """Names of this user's hubs, servers ... that are running."""
    prefix, suffix = f"rfms-{what}-", f"-{os.getuid()}"
    return [
        directory.name.removeprefix(prefix).removesuffix(suffix)
        for directory in sorted(_base().glob(f"{prefix}*{suffix}"))
        if _is_locked(directory / LOCK_FILE)
    ]


def _base() -> Path:
    return Path(os.environ.get("XDG_RUNTIME_DIR") or tempfile.gettempdir())


def _is_locked(path: Path) -> bool:
    try:
        with path.open("rb") as lock:
            fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    return False

"""File descriptors of a process that takes connections: raised, counted, and some kept back."""

import os
import resource
from typing import Final

WANTED: Final = 4096
"""Descriptors that are enough for every connection a server or a hub takes."""
LEAST_SPARE: Final = 64
"""Descriptors kept back at least, for what the process opens itself."""


def raise_limit() -> int:
    """Raise this process' limit of descriptors towards ``WANTED``; the limit now in force."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    allowed = WANTED if hard == resource.RLIM_INFINITY else min(WANTED, hard)
    if soft != resource.RLIM_INFINITY and soft < allowed:
        resource.setrlimit(resource.RLIMIT_NOFILE, (allowed, hard))
        return allowed
    return WANTED if soft == resource.RLIM_INFINITY else soft


def connections_each(kinds: int, most: int) -> int:
    """How many connections of each kind there may be, so that no kind takes those of another.

    A quarter of the limit is kept back: a burst is accepted faster than it is cut.

    Args:
        kinds: of connections.
        most: the largest answer.
    """
    limit = raise_limit()
    room = limit - len(os.listdir("/proc/self/fd")) - max(LEAST_SPARE, limit // 4)
    return max(1, min(most, room // kinds))

"""Memory of a process' threads besides the first: received messages, in a server of ZeroMQ.

ZeroMQ bounds the parts of a message, not their number, and shows a message only when its last part
has come: what an unended one holds is found at the allocator alone. The GNU C library gives threads
arenas of their own, apart from the first's, and ``malloc_info(3)`` tells how much of them is in use
(60 microseconds). Another C library has no such function: memory is not bounded there.
"""

import ctypes
import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Final

_STATM: Final = Path("/proc/self/statm")
_LINE_BYTES: Final = 256
_PAGE: Final = os.sysconf("SC_PAGE_SIZE")
_HEAP: Final = b"<heap nr="
_SYSTEM: Final = re.compile(rb'<system type="current" size="(\d+)"')
_FREE: Final = re.compile(rb'<total type="\w+" count="\d+" size="(\d+)"')


def resident_memory() -> Callable[[], int]:
    """The function that tells the bytes of memory this process occupies.

    Its file stays open: there may be no descriptor left when it is called.
    """
    file = _STATM.open("rb", buffering=0)
    return lambda: int(os.pread(file.fileno(), _LINE_BYTES, 0).split()[1]) * _PAGE


def thread_memory() -> Callable[[], int] | None:
    """The function that tells the bytes in use of all threads but the first; None without one."""
    library = ctypes.CDLL(None)
    if not hasattr(library, "malloc_info"):
        return None
    library.open_memstream.restype = ctypes.c_void_p
    library.malloc_info.argtypes = [ctypes.c_int, ctypes.c_void_p]
    library.fclose.argtypes = library.free.argtypes = [ctypes.c_void_p]

    def measured() -> int:
        text, size = ctypes.c_void_p(), ctypes.c_size_t()
        stream = library.open_memstream(ctypes.byref(text), ctypes.byref(size))
        if not stream:
            return 0
        library.malloc_info(0, stream)
        library.fclose(stream)
        try:
            return used(ctypes.string_at(text.value or 0, size.value))
        finally:
            library.free(text)

    return measured


def used(report: bytes) -> int:
    """Bytes in use of all arenas but the first, of a report of ``malloc_info``."""
    total = 0
    for arena in report.split(_HEAP)[2:]:
        body = arena.partition(b"</heap>")[0]
        system = _SYSTEM.search(body)
        if system is not None:
            total += int(system[1]) - sum(int(size) for size in _FREE.findall(body))
    return total

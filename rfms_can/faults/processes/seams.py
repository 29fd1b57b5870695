"""What a process can only do to itself: done at a signal, arranged for before its command begins.

``Command`` installs one of these as the handler of a signal; the command that runs then is
``rfms`` as it is, and each process it starts has the handler too.
"""

import ctypes
import errno
import os
import platform
import time
from collections.abc import Callable
from typing import Final

from rfms_can.errors import RfmsError

_PR_SET_NO_NEW_PRIVS: Final = 38
_PR_SET_SECCOMP: Final = 22
_SECCOMP_MODE_FILTER: Final = 2
_LOAD: Final = 0x20  # BPF_LD | BPF_W | BPF_ABS
_JUMP_IF_EQUAL: Final = 0x15  # BPF_JMP | BPF_JEQ | BPF_K
_RETURN: Final = 0x06  # BPF_RET | BPF_K
_ALLOW: Final = 0x7FFF_0000  # SECCOMP_RET_ALLOW
_FAIL: Final = 0x0005_0000  # SECCOMP_RET_ERRNO
SEND_CALLS: Final = {"x86_64": (44, 46), "aarch64": (206, 211)}
"""Numbers of the system calls sendto and sendmsg, by machine."""
LARGEST_JUMP_S: Final = 400 * 86400.0
"""Of the wall clock, either way."""


class _Instruction(ctypes.Structure):
    """struct sock_filter of linux/filter.h."""

    _fields_ = (
        ("code", ctypes.c_ushort),
        ("if_true", ctypes.c_ubyte),
        ("if_false", ctypes.c_ubyte),
        ("value", ctypes.c_uint),
    )


class _Program(ctypes.Structure):
    """struct sock_fprog."""

    _fields_ = (("length", ctypes.c_ushort), ("first", ctypes.POINTER(_Instruction)))


def sends_fail(error: int) -> Callable[[], None]:
    """From then on the kernel answers an error to whatever this process sends on a socket.

    By a filter of system calls (seccomp), which stays for the life of the process: a full queue of
    the interface (ENOBUFS), or of the socket itself (EAGAIN).

    Raises:
        RfmsError: the numbers of this machine's system calls are not known.
    """
    machine = platform.machine()
    if machine not in SEND_CALLS:
        raise RfmsError(
            f"no_room_to_send: system calls of {machine!r} are not known, those of "
            f"{', '.join(SEND_CALLS)} are: leave row 17 out with --rows"
        )

    def install() -> None:
        calls = SEND_CALLS[machine]
        instructions = [(_LOAD, 0, 0, 0)]  # the number of the call stands first
        for place, call in enumerate(calls):
            instructions.append((_JUMP_IF_EQUAL, len(calls) - place, 0, call))
        instructions += [(_RETURN, 0, 0, _ALLOW), (_RETURN, 0, 0, _FAIL | error)]
        array = (_Instruction * len(instructions))(*(_Instruction(*i) for i in instructions))
        program = _Program(len(instructions), array)
        libc = ctypes.CDLL(None, use_errno=True)
        if libc.prctl(_PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) or libc.prctl(
            _PR_SET_SECCOMP, _SECCOMP_MODE_FILTER, ctypes.byref(program)
        ):
            raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))

    return install


NO_BUFFER: Final = {True: errno.EAGAIN, False: errno.ENOBUFS}
"""What a send that finds no room fails with, on a hub and on a CAN interface."""


def wall_clock_jumps(seconds: float) -> Callable[[], None]:
    """From then on this process sees another time of day; its monotonic clocks go on.

    What Python code reads: a clock of the whole machine is not ours to set.
    """

    def install() -> None:
        now_s, now_ns, clock = time.time, time.time_ns, time.clock_gettime
        clock_ns = time.clock_gettime_ns
        jump_ns = round(seconds * 1e9)
        time.time = lambda: now_s() + seconds
        time.time_ns = lambda: now_ns() + jump_ns
        time.clock_gettime = lambda which: clock(which) + seconds * (which == time.CLOCK_REALTIME)
        time.clock_gettime_ns = lambda which: (
            clock_ns(which) + jump_ns * (which == time.CLOCK_REALTIME)
        )

    return install

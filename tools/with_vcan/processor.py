"""Which processor a user-mode kernel is bound to.

Every system call of a process inside is a hand-over between two processes outside, and within one
processor a hand-over costs a quarter of one across two. The kernel inside is single-threaded, so
nothing is lost by binding all of its processes to the same processor.
"""

import os
import time
from pathlib import Path

LOOK_S = 0.1
"""Some ticks of the kernel's accounting, which is what idle time is counted in."""


def idlest_processor() -> int:
    """Find the processor that had the least to do in the last moments."""
    allowed = os.sched_getaffinity(0)
    if len(allowed) == 1:
        return next(iter(allowed))
    before = idle_ticks()
    time.sleep(LOOK_S)
    after = idle_ticks()
    return max(allowed, key=lambda number: after.get(number, 0) - before.get(number, 0))


def idle_ticks() -> dict[int, int]:
    """Read the idle time of every processor, in ticks since boot (proc(5), /proc/stat)."""
    ticks = {}
    for line in Path("/proc/stat").read_text().splitlines():
        name, *fields = line.split()
        if name.startswith("cpu") and name != "cpu":
            ticks[int(name[3:])] = int(fields[3])
    return ticks

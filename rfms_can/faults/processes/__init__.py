"""Faults of processes: a real system on a hub or vcan0, faults by signals and the kernel's means.

The system is what ``rfms up`` starts; a stranger on its bus sees what comes of a fault. No process
has test code: what no other process can do to it (a socket that takes nothing more, a wall clock
that jumps) is done by a signal that was arranged for before ``rfms`` began (``seams.py``).
"""

"""Statistics of a server."""

from typing import Final

import msgspec

LATENCY_EDGES_NS: Final = tuple(1_000_000 * edge for edge in (1, 2, 3, 4, 5, 6, 8, 12, 16, 24, 32))
"""Upper ends of the bins of ``ServerNumbers.latency_ns``; one more bin holds longer times."""


class ServerNumbers(msgspec.Struct, frozen=True):
    """A server's numbers since its start.

    Attributes:
        sessions: sessions of coordinators that it keeps.
        requests: requests processed, including refused ones.
        repeated: requests that were sent again and got the stored answer.
        refused: messages refused, on all queues.
        emergencies: emergency stops accepted.
        lapses: leases that lapsed or were released while the arm moved, so that it was stopped.
        unattended: lockstep cycles run while the holder of the lease did not wait.
        latency_cycles: histogram of requests that change the motion, by the number of cycles from
            the cycle of their receipt to that of the SETPOINT they act on; index 3: 3 or more.
        latency_ns: in real time the times from receipt to that SETPOINT, by
            ``LATENCY_EDGES_NS``; empty on other clocks.
        latency_max_ns: the longest of them.
    """

    sessions: int
    requests: int
    repeated: int
    refused: int
    emergencies: int
    lapses: int
    unattended: int
    latency_cycles: list[int]
    latency_ns: list[int]
    latency_max_ns: int

"""What a server counts, for those who ask how it is doing."""

from typing import Final

import msgspec

LATENCY_EDGES_NS: Final = tuple(1_000_000 * edge for edge in (1, 2, 3, 4, 5, 6, 8, 12, 16, 24, 32))
"""Upper ends of the bins of ``ServerNumbers.latency_ns``; one more bin holds what is above."""


class ServerNumbers(msgspec.Struct, frozen=True):
    """A server's numbers since its start.

    Attributes:
        sessions: coordinators it remembers.
        requests: requests processed, refused ones among them.
        repeated: requests that had been processed already and were answered as before.
        refused: messages refused, on all queues.
        emergencies: emergency stops taken.
        lapses: leases that lapsed or were given back while the arm moved, so that it was stopped.
        unattended: lockstep cycles that went on while the holder of the lease did not wait.
        latency_cycles: of requests that change the motion, how many cycles lay between the one in
            progress at their receipt and the one whose SETPOINT they acted in; index 3: 3 or more.
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

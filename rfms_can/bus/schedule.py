"""Response times and load of a set of periodic frames on one bus.

The analysis is that of Davis, Burns, Bril and Lukkien, "Controller Area Network (CAN)
schedulability analysis: refuted, revisited and revised", Real-Time Systems 35 (2007), with the
sufficient and exact treatment of several instances in one busy period. All times are integer ns.

Event frames (no period) may hold the bus when a more urgent frame is queued, so they count as
blocking; they do not interfere, since nothing bounds how often they come.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil
from typing import Final

from rfms_can.bus.timing import BusTiming

Load = tuple[int, int, int]
"""A stream's load: period T, jitter J, bus time C, all ns."""

MAX_ITERATIONS: Final = 100_000


@dataclass(frozen=True, slots=True)
class Stream:
    """Frames of one identifier.

    Attributes:
        name: for tables.
        id: identifier, unique; the lower, the higher the priority.
        length: payload, bytes.
        period_ns: least time between two hand-overs (T_m), also their deadline; None on event.
        jitter_ns: largest delay of a hand-over (J_m).
        fd: CAN FD or classic.
    """

    name: str
    id: int
    length: int
    period_ns: int | None
    jitter_ns: int = 0
    fd: bool = True


@dataclass(frozen=True, slots=True)
class Response:
    """Result of the analysis for one stream.

    Attributes:
        stream: the stream.
        wire_ns: bus time of one frame, fully stuffed (C_m).
        blocking_ns: longest less urgent frame (B_m).
        response_ns: bound from the nominal hand-over to the end of the frame and its
            intermission (R_m); None if it is unbounded, because the load down to this priority
            exceeds the bus, and for an event frame.
    """

    stream: Stream
    wire_ns: int
    blocking_ns: int
    response_ns: int | None

    @property
    def in_time(self) -> bool:
        """Whether each frame has been sent before the next of its kind; true for event frames."""
        if self.stream.period_ns is None:
            return True
        return self.response_ns is not None and self.response_ns <= self.stream.period_ns


def load(streams: Sequence[Stream], timing: BusTiming) -> float:
    """Fraction of the bus time of periodic streams, frames fully stuffed; above 1 it diverges."""
    return sum(
        timing.worst_case_ns(stream.length, stream.fd) / stream.period_ns
        for stream in streams
        if stream.period_ns is not None
    )


def response_times(streams: Sequence[Stream], timing: BusTiming) -> list[Response]:
    """The response-time bound of every stream, most urgent first."""
    ordered = sorted(streams, key=lambda stream: stream.id)
    wire_ns = [timing.worst_case_ns(stream.length, stream.fd) for stream in ordered]
    responses = []
    higher: list[Load] = []
    taken = 0.0
    for place, stream in enumerate(ordered):
        blocking_ns = max(wire_ns[place + 1 :], default=0)
        bound_ns = None
        if stream.period_ns is not None:
            own = (stream.period_ns, stream.jitter_ns, wire_ns[place])
            taken += wire_ns[place] / stream.period_ns
            if taken <= 1.0:
                bound_ns = _response_ns(own, higher, blocking_ns, ceil(timing.bit_ns))
            higher.append(own)
        responses.append(Response(stream, wire_ns[place], blocking_ns, bound_ns))
    return responses


def _response_ns(own: Load, higher: Sequence[Load], blocking_ns: int, bit_ns: int) -> int | None:
    """R_m: the largest response of all instances in the longest busy period at this priority."""
    period, jitter, cost = own
    busy = _least_fixed_point(blocking_ns + cost, blocking_ns, [*higher, own], 0)
    if busy is None:
        return None
    worst = 0
    for instance in range(_instances(busy + jitter, period)):
        before = blocking_ns + instance * cost
        queued = _least_fixed_point(before, before, higher, bit_ns)
        if queued is None:
            return None
        worst = max(worst, jitter + queued - instance * period + cost)
    return worst


def _instances(window_ns: int, period_ns: int) -> int:
    """Largest number of hand-overs in a window: ceil(window / period)."""
    return -(-window_ns // period_ns)


def _least_fixed_point(
    start_ns: int, constant_ns: int, loads: Sequence[Load], bit_ns: int
) -> int | None:
    """Smallest t >= start with t = constant + sum ceil((t + J + tau_bit) / T) C; None if none.

    At a load of exactly 1 the busy period may never end; the iteration is then given up.
    """
    time_ns = start_ns
    for _ in range(MAX_ITERATIONS):
        following = constant_ns + sum(
            _instances(time_ns + jitter + bit_ns, period) * cost for period, jitter, cost in loads
        )
        if following <= time_ns:
            return time_ns
        time_ns = following
    return None

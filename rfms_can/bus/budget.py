"""The bus budget of the wire contract: what the DBC's frames cost at a control rate.

A usual cycle holds the cyclic frames, with heartbeats and the gripper's command at their share; a
full one holds the second pose and what compliance needs (COMPLY, BIAS, FORCE) as well, and one in
between those of them that are named. Event frames (start-up, homing, configuration, emergencies)
count as blocking only.

The bounds run from a frame's hand-over. A frame that answers another is handed over later than
the cycle's start, but as long as all frames of a cycle fit into it (``cycle_ns`` below the
period), no response reaches into the next cycle, each more urgent frame interferes once, and the
analysis without jitter holds.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Final

from cantools.database.can import Database, Message

from rfms_can.bus.schedule import Response, Stream, load, response_times
from rfms_can.bus.timing import NS_PER_S, BusTiming
from rfms_can.errors import BusError
from rfms_can.tables import complete
from rfms_can.wire.codec import load_database

TARGET_LOAD: Final = 0.8
"""Load up to which a bus is planned; the rest is for retransmissions and events."""

OCCASIONAL: Final = frozenset({"SETPOINT_2", "COMPLY", "BIAS", "FORCE"})
"""Frames that a cycle in operation holds only when the motion or the tool needs them."""

OTHER_ARMS: Final = ("JOINT_SETPOINT_", "POSITION_")
"""Frames of arms without a closed form and of boards that take positions; ours have neither. Near
singularities, half turns and ends of ranges the master sends JOINT_SETPOINT all the same: one frame
for each pose, 106 us at 1/5 Mbit/s, on top of what a full cycle holds."""
OTHER_NODES: Final = ("BOARD_", "FORCE_SENSOR")
"""Nodes that are on the bus only where the plant is not: it speaks for them."""

PLANT: Final = "PLANT"
SYNC: Final = "SYNC"
ROWS: Final = "ROWS_"
DAC: Final = "DAC_"
JOINT_COUNT: Final = 6
CLASSIC_BYTES: Final = 8


class Rows(StrEnum):
    """How the six rows of a set are sent."""

    ALL = "all"
    STAGGERED = "staggered"


class Cycle(StrEnum):
    """Which frames a cycle in operation holds."""

    USUAL = "usual"
    FULL = "full"


class Traffic(StrEnum):
    """Which frames share the bus."""

    BOTH = "control and plant"
    CONTROL = "control"
    PLANT = "plant"


_OF_PLANT: Final = complete(
    {Traffic.BOTH: (True, False), Traffic.CONTROL: (False,), Traffic.PLANT: (True,)}, Traffic
)
"""Whether the frames of a bus are the plant's own, those between it and the joints."""


@dataclass(frozen=True, slots=True)
class Budget:
    """One bus at one rate.

    Attributes:
        traffic: on the bus.
        timing: its bit rates.
        responses: per frame, most urgent first.
        load: fraction of the bus time, 1 and more for an overloaded bus.
        cycle_ns: bus time of all frames that one cycle can hold, and the longest blocking.
        max_rate_hz: control rate at ``TARGET_LOAD``.
    """

    traffic: Traffic
    timing: BusTiming
    responses: tuple[Response, ...]
    load: float
    cycle_ns: int
    max_rate_hz: float

    @property
    def in_time(self) -> bool:
        """Whether every periodic frame is sent within its period."""
        return all(response.in_time for response in self.responses)


def budget(
    rate_hz: float,
    timing: BusTiming,
    *,
    rows: Rows = Rows.ALL,
    traffic: Traffic = Traffic.BOTH,
    cycle: Cycle = Cycle.FULL,
    occasional: Collection[str] = (),
    database: Database | None = None,
) -> Budget:
    """The budget of one bus; on a classic one, payloads go in frames of 8 bytes.

    ``occasional`` names frames of :data:`OCCASIONAL` that a usual cycle holds nevertheless.

    Raises:
        BusError: the rate is not positive.
        DbcError: the DBC cannot be read.
    """
    streams = contract_streams(
        rate_hz,
        timing,
        rows=rows,
        traffic=traffic,
        cycle=cycle,
        occasional=occasional,
        database=database,
    )
    responses = response_times(streams, timing)
    taken = load(streams, timing)
    once = sum(response.wire_ns for response in responses if response.stream.period_ns is not None)
    staggered = _staggered_surplus_ns(responses, rows)
    return Budget(
        traffic,
        timing,
        tuple(responses),
        taken,
        once - staggered + max(response.wire_ns for response in responses),
        rate_hz * TARGET_LOAD / taken,
    )


def contract_streams(
    rate_hz: float,
    timing: BusTiming,
    *,
    rows: Rows = Rows.ALL,
    traffic: Traffic = Traffic.BOTH,
    cycle: Cycle = Cycle.FULL,
    occasional: Collection[str] = (),
    database: Database | None = None,
) -> list[Stream]:
    """The DBC's messages as streams; a message's ``RfmsEvery`` counts control periods.

    Raises:
        BusError: a rate that is not positive.
        DbcError: the DBC cannot be read.
    """
    if not rate_hz > 0:
        raise BusError(f"control rate {rate_hz} Hz is not positive")
    period_ns = round(NS_PER_S / rate_hz)
    streams = []
    for message in (database or load_database()).messages:
        if _is_sent(message) and _carries(message, traffic):
            every = _every(message, rows, OCCASIONAL if cycle is Cycle.FULL else occasional)
            stream = Stream(
                message.name,
                message.frame_id,
                message.length,
                every * period_ns if every else None,
                fd=message.is_fd,
            )
            streams += [stream] if timing.data_bit_rate else split_for_classic(stream)
    return streams


def split_for_classic(stream: Stream) -> list[Stream]:
    """The stream as classic frames of up to 8 bytes, handed over one after the other.

    The segments share an identifier on a real bus; here each has its own priority within it.
    """
    lengths = [CLASSIC_BYTES] * (stream.length // CLASSIC_BYTES)
    if stream.length % CLASSIC_BYTES:
        lengths.append(stream.length % CLASSIC_BYTES)
    return [
        replace(
            stream,
            name=stream.name if len(lengths) == 1 else f"{stream.name} {segment}/{len(lengths)}",
            length=length,
            fd=False,
        )
        for segment, length in enumerate(lengths, start=1)
    ]


def _every(message: Message, rows: Rows, occasional: Collection[str]) -> int:
    """Cycles between two frames of a message in operation; 0 for an event."""
    if message.name in OCCASIONAL:
        return 1 if message.name in occasional else 0
    if message.name.startswith(ROWS) and rows is Rows.STAGGERED:
        return JOINT_COUNT
    return int(message.dbc.attributes["RfmsEvery"].value)


def _is_sent(message: Message) -> bool:
    """Whether a node of the usual bus sends the message: master, joints, gripper and plant."""
    sent = any(not sender.startswith(OTHER_NODES) for sender in message.senders)
    return sent and not message.name.startswith(OTHER_ARMS)


def _carries(message: Message, traffic: Traffic) -> bool:
    """Whether a bus with this traffic carries the message; SYNC and events for all are on both."""
    if message.name == SYNC:
        return True
    of_plant = PLANT in message.senders or message.name.startswith(DAC)
    return of_plant in _OF_PLANT[traffic]


def _staggered_surplus_ns(responses: Sequence[Response], rows: Rows) -> int:
    """Bus time of the rows that a staggered cycle omits: all but one."""
    if rows is Rows.ALL:
        return 0
    costs = [r.wire_ns for r in responses if r.stream.name.startswith(ROWS)]
    return sum(costs) * (JOINT_COUNT - 1) // JOINT_COUNT

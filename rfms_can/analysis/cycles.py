"""A bus log, cycle by cycle: what every frame of the enabled arm said, in arrays.

A frame belongs to the cycle whose SYNC came last before it; one that echoes another cycle's low
byte is left out, and so is a frame that a node would have refused (counted).
"""

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rfms_can.bus.timing import BusTiming
from rfms_can.wire.codec import MessageCodec
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.protection import Decoder, Refusal
from rfms_can.wire.records import Dac, JointError, Measure, Rows, Setpoint, Sync
from rfms_can.wire.vocabulary import NodeState

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_ENABLED: Final = frozenset((NodeState.OPERATIONAL, NodeState.QUICKSTOP))
_MISSING: Final = [float("nan")] * len(JOINTS)


class CycleLog(NamedTuple):
    """What went over the bus while the arm was enabled: one row a cycle, NaN where nothing came.

    Attributes:
        cycle: numbers of the cycles, from 0 at enable (N).
        counts: encoder counts (N, 6).
        velocity_codes: velocity ADC (N, 6).
        errors: joint errors, rad (N, 6).
        current_codes: motor-current DAC (N, 6).
        gravity: gravity torque of the rows, Nm (N, 6).
        sequence: the move under way, by its number; -1 where no set-point came (N).
        state: of the trajectory generator, ``TrajectoryState``; -1 likewise (N).
        mode: of the segment, ``Mode``; -1 likewise (N).
        acceleration_time: t_acc of that move, s; -1 likewise (N).
        busy_ns: bus time of the cycle's frames (N).
        frames: how many frames the log has, all phases.
        refused: frames of ours that broke the wire contract, all phases.
    """

    cycle: Integers
    counts: Floats
    velocity_codes: Floats
    errors: Floats
    current_codes: Floats
    gravity: Floats
    sequence: Integers
    state: Integers
    mode: Integers
    acceleration_time: Floats
    busy_ns: Integers
    frames: int
    refused: int


class _Cycle:
    """One cycle being read."""

    __slots__ = ("busy_ns", "codes", "counts", "errors", "gravity", "number", "setpoint", "speeds")

    def __init__(self, number: int) -> None:
        self.number = number
        self.counts = _MISSING.copy()
        self.speeds = _MISSING.copy()
        self.errors = _MISSING.copy()
        self.codes = _MISSING.copy()
        self.gravity = _MISSING.copy()
        self.setpoint: tuple[int, int, int, float] = (-1, -1, -1, -1.0)
        self.busy_ns = 0

    def has(self, low_byte: int) -> bool:
        """Whether a frame with this echo belongs here."""
        return low_byte == self.number & 0xFF


_Reader = tuple[Decoder[Any], Callable[[_Cycle, Any], None]]


def read_cycles(frames: Iterable[Frame], wire: Wire, timing: BusTiming) -> CycleLog:
    """Read a log; without a cycle of an enabled arm, all arrays are empty."""
    decoders = _decoders(wire)
    sync_id = wire.id(Sync)
    cycles: list[_Cycle] = []
    cycle: _Cycle | None = None
    total = refused = 0
    for frame in frames:
        total += 1
        decoder, store = decoders.get(frame.id, (None, _ignore))
        record = None if decoder is None else decoder.decode(frame)
        if isinstance(record, Refusal):
            refused += 1
            record = None
        if frame.id == sync_id and isinstance(record, Sync):
            cycle = _Cycle(record.cycle) if record.state in _ENABLED else None
            if cycle is not None:
                cycles.append(cycle)
        if cycle is None:
            continue
        cycle.busy_ns += timing.exact_ns(frame)
        if record is not None:
            store(cycle, record)
    return _as_arrays(cycles, total, refused)


def _decoders(wire: Wire) -> dict[int, _Reader]:
    """For each identifier we read: how to decode it, and where it goes."""
    table: dict[int, _Reader] = {
        wire.id(Sync): (Decoder(wire.codec(Sync)), _ignore),
        wire.id(Setpoint, 1): (Decoder(wire.codec(Setpoint, 1)), _store_setpoint),
    }
    for index, joint in enumerate(JOINTS):
        for record, store in _STORES.items():
            codec: MessageCodec[Any] = wire.codec(record, joint)
            table[codec.id] = (Decoder(codec), partial(store, index))
    return table


def _ignore(_cycle: _Cycle, _record: Any) -> None:
    """SYNC itself, and frames of no interest here."""


def _store_setpoint(cycle: _Cycle, setpoint: Setpoint) -> None:
    if setpoint.cycle == cycle.number:
        values = (setpoint.sequence, setpoint.state, setpoint.mode, setpoint.acceleration_time)
        cycle.setpoint = values


def _store_measure(index: int, cycle: _Cycle, measure: Measure) -> None:
    if cycle.has(measure.cycle):
        cycle.counts[index] = measure.counts
        cycle.speeds[index] = measure.velocity_adc


def _store_error(index: int, cycle: _Cycle, error: JointError) -> None:
    if cycle.has(error.cycle):
        cycle.errors[index] = error.error


def _store_dac(index: int, cycle: _Cycle, dac: Dac) -> None:
    if cycle.has(dac.cycle):
        cycle.codes[index] = dac.current_dac


def _store_rows(index: int, cycle: _Cycle, rows: Rows) -> None:
    cycle.gravity[index] = rows.gravity


_STORES: Final[dict[Any, Callable[[int, _Cycle, Any], None]]] = {
    Measure: _store_measure,
    JointError: _store_error,
    Dac: _store_dac,
    Rows: _store_rows,
}
"""Where the values of each joint's frames go."""


def _as_arrays(cycles: list[_Cycle], frames: int, refused: int) -> CycleLog:
    def table(rows: list[list[float]]) -> Floats:
        return np.array(rows, dtype=np.float64).reshape(-1, len(JOINTS))

    def column(values: Iterable[int]) -> Integers:
        return np.array(list(values), dtype=np.int64)

    return CycleLog(
        cycle=column(c.number for c in cycles),
        counts=table([c.counts for c in cycles]),
        velocity_codes=table([c.speeds for c in cycles]),
        errors=table([c.errors for c in cycles]),
        current_codes=table([c.codes for c in cycles]),
        gravity=table([c.gravity for c in cycles]),
        sequence=column(c.setpoint[0] for c in cycles),
        state=column(c.setpoint[1] for c in cycles),
        mode=column(c.setpoint[2] for c in cycles),
        acceleration_time=np.array([c.setpoint[3] for c in cycles], dtype=np.float64),
        busy_ns=column(c.busy_ns for c in cycles),
        frames=frames,
        refused=refused,
    )

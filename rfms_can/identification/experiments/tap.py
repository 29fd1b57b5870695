"""Captures the frames of an enabled arm, cycle by cycle, as a bus listener receives them."""

from collections.abc import Callable
from functools import partial
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.protection import Decoder
from rfms_can.wire.records import Dac, Measure, Sync
from rfms_can.wire.vocabulary import NodeState

Integers = npt.NDArray[np.int32]

FIELDS: Final = 4
"""Counts, current ADC, velocity ADC, DAC."""
MISSING: Final = -(2**31)
"""Value in place of a missing frame."""


class Tap:
    """Collects MEASURE and DAC of joints 1 to 6 while SYNC says that the arm is enabled."""

    def __init__(self, wire: Wire) -> None:
        self._rows: list[list[int]] = []
        self._row: list[int] | None = None
        self._low = 0
        self._sync_id = wire.id(Sync)
        self._sync = Decoder(wire.codec(Sync))
        self._readers: dict[int, tuple[Decoder[Any], Callable[[Any], None]]] = {}
        for index, joint in enumerate(JOINTS):
            for record, store in ((Measure, self._measure), (Dac, self._dac)):
                codec: Any = wire.codec(record, joint)
                self._readers[codec.id] = (Decoder(codec), partial(store, index))

    def take(self, _: int, frame: Frame) -> None:
        """Process a frame of any kind."""
        if frame.id == self._sync_id:
            self._begin(self._sync.decode(frame))
            return
        reader = self._readers.get(frame.id)
        if reader is None or self._row is None:
            return
        decoder, store = reader
        record = decoder.decode(frame)
        if isinstance(record, Measure | Dac) and record.cycle == self._low:
            store(record)

    @property
    def table(self) -> Integers:
        """(cycles, 4, 6): counts, current ADC, velocity ADC and DAC of each cycle from enable."""
        rows = np.array(self._rows, dtype=np.int32)
        return rows.reshape(-1, FIELDS, len(JOINTS))

    def _begin(self, sync: object) -> None:
        self._row = None
        if isinstance(sync, Sync) and sync.state == NodeState.OPERATIONAL:
            self._row, self._low = [MISSING] * (FIELDS * len(JOINTS)), sync.cycle & 0xFF
            self._rows.append(self._row)

    def _measure(self, index: int, measure: Measure) -> None:
        if self._row is not None:
            width = len(JOINTS)
            self._row[index] = measure.counts
            self._row[width + index] = measure.current_adc
            self._row[2 * width + index] = measure.velocity_adc

    def _dac(self, index: int, dac: Dac) -> None:
        if self._row is not None:
            self._row[3 * len(JOINTS) + index] = dac.current_dac

"""What a stranger hears on the bus, frame by frame with the time, and what it means."""

import time
from collections.abc import Callable, Iterator
from typing import Any, Final, NamedTuple

from rfms_can.bus.driver import open_port
from rfms_can.errors import BusError
from rfms_can.wire.codec import MessageCodec
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import GRIPPER, JOINTS, MASTER, PLANT
from rfms_can.wire.records import Dac, Emcy, Estop, Heartbeat, Measure, Nmt, Sync

NODES: Final = (*JOINTS, GRIPPER, MASTER, PLANT)
_HEARD: Final[tuple[tuple[type[Any], tuple[int, ...]], ...]] = (
    (Measure, JOINTS),
    (Dac, JOINTS),
    (Emcy, NODES),
    (Heartbeat, NODES),
    (Sync, (0,)),
    (Nmt, (0,)),
    (Estop, (0,)),
)
_WAIT_S: Final = 0.02


class Heard(NamedTuple):
    """A frame, decoded.

    Attributes:
        at_ns: monotonic time.
        node: whose it is, or about whom; 0 of a message that is of no node.
        values: the record.
    """

    at_ns: int
    node: int
    values: Any


class Tape:
    """Listens on a bus; decodes only when asked.

    Args:
        bus: its URL.

    Attributes:
        frames: everything heard so far, with monotonic times, ns.
        gone_ns: when the bus was found gone; None while it is there.
        caught_up: whether nothing was waiting to be heard a moment ago.

    Raises:
        BusError: the bus does not exist.
    """

    def __init__(self, bus: str) -> None:
        wire = Wire()
        self._codecs: dict[int, tuple[int, MessageCodec[Any]]] = {}
        for record, nodes in _HEARD:
            for node in nodes:
                codec = wire.codec(record, node or None)
                self._codecs[codec.id] = (node, codec)
        self.frames: list[tuple[int, Frame]] = []
        self.gone_ns: int | None = None
        self.caught_up = False
        self._port = open_port(bus, frozenset(self._codecs), client="rfms faults")

    def listen(self, seconds: float, until: Callable[[], bool] = lambda: False) -> bool:
        """Listen for a while, or until a condition holds; whether it holds.

        The condition is looked at whenever nothing comes, and every so often.
        """
        stop, look = time.monotonic() + seconds, 0
        while time.monotonic() < stop:
            look -= 1
            if look < _AT_LATEST or (self.caught_up and look < 0):
                if until():
                    return True
                look = _LOOK_EVERY
            if not self._take():
                look = -1
        return until()

    def _take(self) -> bool:
        if self.gone_ns is not None:
            time.sleep(_WAIT_S)
            return False
        try:
            frame = self._port.recv(0.0)
            self.caught_up = frame is None
            if frame is None:
                frame = self._port.recv(_WAIT_S)
        except BusError:
            self.gone_ns, self.caught_up = time.monotonic_ns(), True
            return False
        if frame is not None:
            self.frames.append((time.monotonic_ns(), frame))
        return frame is not None

    def heard(self, start: int, stop: int | None = None) -> Iterator[Heard]:
        """What was heard between two places, decoded; without what is out of its range."""
        for at_ns, frame in self.frames[start:stop]:
            node, codec = self._codecs[frame.id]
            values = codec.unpack(frame.data) if len(frame.data) == codec.length else None
            if values is not None:
                yield Heard(at_ns, node, values)

    def close(self) -> None:
        """Leave the bus."""
        self._port.close()


_LOOK_EVERY: Final = 128
"""Frames between two looks at a condition: some eight control cycles."""
_AT_LATEST: Final = -896
"""Where so many more came without a moment in which nothing was waiting, it is looked at too."""

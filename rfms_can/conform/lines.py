"""The tester's way to the node: send a frame, let time pass, take what came.

On a line whose time is *virtual*, it passes only when the tester lets it, and all a node answers is
there once the line has settled. On a port time is real, and the tester asks for a HEARTBEAT to know
that the node has dealt with everything before.
"""

import time
from collections.abc import Callable, Sequence
from typing import Final, Protocol

from rfms_can.bus.port import Port
from rfms_can.bus.simulated import SimulatedBus
from rfms_can.conform.outcome import NodeSilent
from rfms_can.node.protocol import NOTHING, Node
from rfms_can.wire.frame import Frame

MakeNode = Callable[[], Node]
"""Switches a node on: a new one at each call."""


class Line(Protocol):
    """What the tester needs of a bus.

    Attributes:
        virtual: whether time passes only in ``pass_until``.
        settle_ns: how long to listen on for an answer after the node's HEARTBEAT; real time.
    """

    virtual: bool
    settle_ns: int

    @property
    def now_ns(self) -> int:
        """Time of the line, ns."""

    def send(self, frame: Frame) -> None:
        """Put a frame on the bus, after those before it."""

    def receive(self, until_ns: int) -> Frame | None:
        """The next frame of the node; None if none comes by then, or where nothing is to come."""

    def pass_until(self, time_ns: int) -> None:
        """Let time pass; frames that come meanwhile are kept for ``receive``."""

    def power_on(self) -> bool:
        """Switch the node off and on; False where this line cannot."""

    def close(self) -> None:
        """Leave the bus."""


MOST_CALLS: Final = 1000
"""Calls of a node's timer at one time, after which it has hung: on a bus it would be silent."""


class PumpedLine:
    """A node that is called directly: no bus, no time between a frame and its answer.

    Args:
        make: makes the node.

    Attributes:
        node: the node under test; the suite does not look at it.
    """

    virtual = True
    settle_ns = 0

    def __init__(self, make: MakeNode) -> None:
        self._make = make
        self.now_ns = 0
        self._came: list[Frame] = []
        self.node: Node
        self.power_on()

    def send(self, frame: Frame) -> None:
        """Hand the node a frame, if it listens to it."""
        if frame.id in self._accepts:
            self._came += self.node.on_frame(frame, self.now_ns)

    def receive(self, until_ns: int) -> Frame | None:
        """The next answer, if there is one."""
        return self._came.pop(0) if self._came else None

    def pass_until(self, time_ns: int) -> None:
        """Call the node's timer as often as it is due.

        Raises:
            NodeSilent: its deadline does not move on.
        """
        calls = 0
        while (due := self.node.next_deadline_ns()) is not None and due <= time_ns:
            calls = calls + 1 if due <= self.now_ns else 0
            if calls > MOST_CALLS:
                told = f"a timer that is due at {due} ns, {MOST_CALLS} times"
                raise NodeSilent("nothing", told, "a timer that moves on")
            self.now_ns = max(self.now_ns, due)
            self._came += self.node.on_time(self.now_ns)
        self.now_ns = max(self.now_ns, time_ns)

    def power_on(self) -> bool:
        """Make a new node."""
        self._came.clear()
        self.node = self._make()
        self._accepts = self.node.accepts
        self.pass_until(self.now_ns)
        return True

    def close(self) -> None:
        """Nothing to leave."""


class _Speaker:
    """The tester's controller on the simulated bus: it only sends."""

    name = "tester"
    accepts: frozenset[int] = frozenset()

    def on_frame(self, _frame: Frame, _now_ns: int) -> Sequence[Frame]:
        """Hears nothing: the line watches the bus."""
        return NOTHING

    def on_time(self, _now_ns: int) -> Sequence[Frame]:
        """Never due."""
        return NOTHING

    def next_deadline_ns(self) -> int | None:
        """The tester lets time pass itself."""
        return None


class SimulatedLine:
    """A node on the simulated bus: each frame takes its time, nothing else does.

    Args:
        make: makes the node.
    """

    virtual = True
    settle_ns = 0

    def __init__(self, make: MakeNode) -> None:
        self._make = make
        self._bus = SimulatedBus()
        self._came: list[Frame] = []
        self._bus.observers.append(self._observe)
        self._own = self._bus.attach(_Speaker())
        self._node = self._bus.attach(make())
        self.pass_until(1)

    @property
    def now_ns(self) -> int:
        """Virtual time, ns."""
        return self._bus.now_ns

    def send(self, frame: Frame) -> None:
        """Send a frame, and wait until it and all that it brings forth have gone over the bus."""
        self._bus.send(self._own, (frame,))
        self._settle()

    def receive(self, until_ns: int) -> Frame | None:
        """The next frame, if there is one."""
        return self._came.pop(0) if self._came else None

    def _observe(self, _time_ns: int, frame: Frame, sender: str) -> None:
        if sender != self._own.node.name:
            self._came.append(frame)

    def pass_until(self, time_ns: int) -> None:
        """Run the bus to a time."""
        self._bus.run_until(time_ns)
        self._settle()

    def _settle(self) -> None:
        self._bus.run_until(lambda: self._bus.idle)

    def power_on(self) -> bool:
        """Take the node off the bus and put a new one on."""
        self._bus.detach(self._node)
        self._came.clear()
        self._node = self._bus.attach(self._make())
        self.pass_until(self._bus.now_ns)
        return True

    def close(self) -> None:
        """Nothing to leave."""


SETTLE_NS: Final = 2_000_000
"""How long a board's answer may come after a HEARTBEAT that it sent to a later frame, ns."""


class PortLine:
    """A node on a hub or a CAN interface.

    Args:
        port: the tester's port, which receives all identifiers and none of its own frames.
        settle_ns: see ``Line``; 0 where a node answers in the order of what it hears.
    """

    virtual = False

    def __init__(self, port: Port, settle_ns: int = SETTLE_NS) -> None:
        self._port = port
        self.settle_ns = settle_ns
        self._came: list[Frame] = []

    @property
    def now_ns(self) -> int:
        """Monotonic time, ns."""
        return time.monotonic_ns()

    def send(self, frame: Frame) -> None:
        """Send a frame in a packet of its own."""
        self._port.send((frame,))

    def receive(self, until_ns: int) -> Frame | None:
        """The next frame, waited for until then."""
        if self._came:
            return self._came.pop(0)
        return self._next(until_ns)

    def _next(self, until_ns: int) -> Frame | None:
        while True:
            left_s = (until_ns - time.monotonic_ns()) * 1e-9
            frame = self._port.recv(max(0.0, left_s))
            if frame is not None or left_s <= 0.0:
                return frame

    def pass_until(self, time_ns: int) -> None:
        """Wait; frames that come are kept."""
        while (frame := self._next(time_ns)) is not None or time.monotonic_ns() < time_ns:
            if frame is not None:
                self._came.append(frame)

    def power_on(self) -> bool:
        """A hand has to do that."""
        return False

    def close(self) -> None:
        """Close the port."""
        self._port.close()

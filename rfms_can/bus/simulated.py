"""The simulated bus: all nodes in one process, discrete events in virtual time.

A frame is queued in its node's controller the moment the node hands it over. When the bus is
idle, the lowest identifier among all controllers' queues wins and occupies the bus for its exact
duration, stuff bits counted. With its last bit it is delivered to every node that accepts the
identifier, except the sender; after three bits of intermission the bus is idle again.

Order of simultaneous events, so that a run repeats to the bit:

1. the frame that ends is observed, then delivered, receivers in the order of attachment;
2. delayed hand-overs and deliveries (latency, delay), oldest first;
3. ``on_time`` of nodes whose deadline has passed, in the order of attachment;
4. arbitration.

What this fake does not model: receive queues (a node takes a frame the instant it is delivered,
so none can overflow; ``Disturbance.lost_at`` takes their place), acknowledgement (a lone sender
is acknowledged), propagation delay, oscillator tolerance and resynchronisation, the change of
rate inside the bits BRS and CRC delimiter, overload frames, the recessive error-state bit of an
error-passive sender, the further 7 counts of the receiver that flags an error first, error flags
shorter than 12 bits, and where in a frame a collision shows (its end is taken). Nodes compute in
zero time unless they are attached with a latency.
"""

from collections.abc import Callable, Sequence
from heapq import heappop, heappush
from typing import Final

from rfms_can.bus.controller import TX_CAPACITY, Controller, Route, receivers
from rfms_can.bus.disturbance import Disturbance, Disturber
from rfms_can.bus.medium import Medium
from rfms_can.bus.statistics import BusStatistics
from rfms_can.bus.timing import BusTiming
from rfms_can.errors import BusError
from rfms_can.node.port_counts import tell_port
from rfms_can.node.protocol import Node
from rfms_can.wire.frame import Frame

NEVER: Final = 1 << 62
MAX_CALLS_AT_ONE_INSTANT: Final = 1000

Observer = Callable[[int, Frame, str], None]  # time_ns, frame, sender's name


class SimulatedBus:
    """A CAN bus in virtual time.

    Args:
        timing: bit rates; CAN FD on 1/5 Mbit/s if not given.
        worst_case: every frame takes its worst-case time instead of its exact one.
        disturber: called at the start of each transmission, see ``disturbance.py``.
        start_ns: initial virtual time.

    Attributes:
        now_ns: virtual time, ns. Read only.
        observers: called at the end of each frame; append to it.
    """

    def __init__(
        self,
        timing: BusTiming | None = None,
        *,
        worst_case: bool = False,
        disturber: Disturber | None = None,
        start_ns: int = 0,
    ) -> None:
        self.timing = timing or BusTiming()
        self.now_ns = start_ns
        self.observers: list[Observer] = []
        self._medium = Medium(self.timing, start_ns, worst_case, disturber, on_bus_off=self.reroute)
        self._controllers: list[Controller] = []
        self._deadlines: list[int] = [NEVER]  # first the delayed actions, then by controller
        self._delayed: list[tuple[int, int, Callable[[], None]]] = []  # heap
        self._serial = 0
        self._called_ns, self._calls = start_ns, 0

    @property
    def statistics(self) -> BusStatistics:
        """Traffic since the start, or since ``reset_statistics``."""
        return self._medium.statistics

    @property
    def idle(self) -> bool:
        """Whether no frame is on the wire and none waits for it."""
        return self._medium.sending is None and not self._medium.pending

    @property
    def disturber(self) -> Disturber | None:
        """Called at the start of each transmission; may be set at any time."""
        return self._medium.disturber

    @disturber.setter
    def disturber(self, disturber: Disturber | None) -> None:
        self._medium.disturber = disturber

    def reset_statistics(self) -> None:
        """Start new statistics; the object returned before keeps the old counts."""
        self._medium.statistics = BusStatistics(since_ns=self.now_ns)

    def attach(
        self, node: Node, *, tx_capacity: int = TX_CAPACITY, latency_ns: int = 0
    ) -> Controller:
        """Put a node on the bus; raises ``BusError`` if its name is taken."""
        if any(node.name == controller.name for controller in self._controllers):
            raise BusError(f"two nodes are named {node.name!r}: names tell senders apart")
        controller = Controller(node, len(self._controllers) + 1, tx_capacity, latency_ns)
        tell_port(node, controller.counts)
        self._controllers.append(controller)
        self._deadlines.append(NEVER)
        self._read_deadline(controller)
        self.reroute()
        return controller

    def detach(self, controller: Controller) -> None:
        """Disconnect a node: its queue is lost and it is never called again."""
        del self._deadlines[controller.index]
        self._controllers.remove(controller)
        for index, remaining in enumerate(self._controllers, start=1):
            remaining.index = index
        controller.bus_off = True
        self._medium.drop(controller)
        self.reroute()

    def switch_off(self, controller: Controller) -> None:
        """Take a controller off the bus, as its 32nd error in a row does (bus-off).

        Its queue is lost, it neither sends nor receives, and nothing brings it back; its node is
        called at its deadlines.
        """
        controller.bus_off = True
        self._medium.drop(controller)
        self.reroute()

    def exchange(self, controller: Controller, node: Node) -> None:
        """Put another node of the same name behind a controller: another start of it, or one in
        front of it that sees what it hears and sends."""
        controller.node = node
        self._read_deadline(controller)
        self.reroute()

    def send(self, controller: Controller, frames: Sequence[Frame]) -> None:
        """Hand frames over at this instant on behalf of a node (a program, a test)."""
        self._medium.queue(controller, frames, self.now_ns)

    def run_until(self, goal: int | Callable[[], bool]) -> None:
        """Run to a virtual time in ns, or until a predicate, evaluated after each event, holds.

        Raises:
            BusError: no event is left and the predicate does not hold, or a node's deadline does
                not advance.
        """
        for controller in self._controllers:
            self._read_deadline(controller)  # a program may have changed them between runs
        if callable(goal):
            while not goal():
                if not self._advance(NEVER - 1):
                    raise BusError(
                        f"no event is left at {self.now_ns} ns (no frame pending, no deadline), "
                        f"and the awaited condition does not hold"
                    )
        else:
            while self._advance(goal):
                pass
            self.now_ns = max(self.now_ns, goal)

    def step(self) -> bool:
        """Process the next event; False without one."""
        return self._advance(NEVER - 1)

    def _advance(self, limit_ns: int) -> bool:
        """Process the next event up to ``limit_ns``; False without one."""
        medium = self._medium
        timer_ns = min(self._deadlines)
        while medium.sending is None and medium.pending:
            start_ns = max(medium.idle_ns, self.now_ns)
            if start_ns >= timer_ns or start_ns > limit_ns:
                break
            self.now_ns = start_ns
            medium.start(start_ns)
        if medium.sending is not None and medium.end_ns <= timer_ns:
            if medium.end_ns > limit_ns:
                return False
            self._finish()
            return True
        if timer_ns > limit_ns:
            return False
        self._call(self._deadlines.index(timer_ns), timer_ns)
        return True

    def _call(self, index: int, timer_ns: int) -> None:
        """Run a delayed action, or call the node whose deadline has passed."""
        self.now_ns = now_ns = max(self.now_ns, timer_ns)
        if index == 0:
            heappop(self._delayed)[2]()
            self._deadlines[0] = self._delayed[0][0] if self._delayed else NEVER
            return
        controller = self._controllers[index - 1]
        self._calls = self._calls + 1 if now_ns == self._called_ns else 1
        self._called_ns = now_ns
        if self._calls > MAX_CALLS_AT_ONE_INSTANT:
            raise BusError(
                f"{controller.name}: its deadline {timer_ns} ns is still due at {now_ns} ns "
                f"after {MAX_CALLS_AT_ONE_INSTANT} calls of on_time"
            )
        frames = controller.node.on_time(now_ns)
        if frames:
            self._hand_over(controller, frames)
        self._read_deadline(controller)

    def _finish(self) -> None:
        """End the frame on the wire: observe and deliver it."""
        medium = self._medium
        self.now_ns = now_ns = medium.end_ns
        entry = medium.finish(self._controllers)
        if entry is None:
            return  # an error frame
        sender, frame = entry[3], entry[4]
        if medium.disturbance is not None or medium.twins:
            self._finish_specially(sender, frame)
            return
        for observe in self.observers:
            observe(now_ns, frame, sender.name)
        routes = sender.routes.get(frame.id)
        self._deliver(
            receivers(sender, frame.id, self._controllers) if routes is None else routes, frame
        )

    def _finish_specially(self, sender: Controller, frame: Frame) -> None:
        """End a frame with twins or a disturbance."""
        twins = [twin[3] for twin in self._medium.twins]
        disturbance = self._medium.disturbance or Disturbance()
        self._medium.twins, self._medium.disturbance = (), None
        sent, frame = frame, _delivered(frame, disturbance)
        for observe in self.observers:
            observe(self.now_ns, frame, sender.name)
        routes: list[Route] = []
        echo: list[Route] = []
        for route in receivers(sender, frame.id, self._controllers):
            if route[0] is sender:
                echo.append(route)
            elif route[0].name in disturbance.lost_at:
                route[0].rx_lost += 1
            elif route[0] not in twins:
                routes.append(route)
        self._deliver(echo, sent)
        for _ in range(1 + disturbance.copies):
            if disturbance.delay_ns:
                self._do_later(disturbance.delay_ns, lambda: self._deliver_late(routes, frame))
            else:
                self._deliver(routes, frame)

    def _deliver(self, routes: Sequence[Route], frame: Frame) -> None:
        now_ns = self.now_ns
        deadlines = self._deadlines
        for controller, index, on_frame, next_deadline_ns in routes:
            answers = on_frame(frame, now_ns)
            if answers:
                self._hand_over(controller, answers)
            deadline_ns = next_deadline_ns()
            deadlines[index] = NEVER if deadline_ns is None else deadline_ns

    def _deliver_late(self, routes: Sequence[Route], frame: Frame) -> None:
        """Deliver to the nodes still attached (their indices may have changed)."""
        attached = {route[0] for route in routes if not route[0].bus_off}
        self._deliver([c.route() for c in self._controllers if c in attached], frame)

    def _hand_over(self, controller: Controller, frames: Sequence[Frame]) -> None:
        if controller.latency_ns:
            frames = tuple(frames)
            self._do_later(controller.latency_ns, lambda: self.send(controller, frames))
        else:
            self._medium.queue(controller, frames, self.now_ns)

    def _do_later(self, delay_ns: int, action: Callable[[], None]) -> None:
        self._serial += 1
        heappush(self._delayed, (self.now_ns + delay_ns, self._serial, action))
        self._deadlines[0] = self._delayed[0][0]

    def _read_deadline(self, controller: Controller) -> None:
        deadline_ns = controller.node.next_deadline_ns()
        self._deadlines[controller.index] = NEVER if deadline_ns is None else deadline_ns

    def reroute(self) -> None:
        """Discard the cached routes after a node's acceptance filter has changed."""
        for controller in self._controllers:
            controller.routes.clear()


def _delivered(frame: Frame, disturbance: Disturbance) -> Frame:
    """What the receivers get of a frame."""
    if disturbance.data is None and disturbance.fd is None:
        return frame
    data = frame.data if disturbance.data is None else disturbance.data
    return Frame(frame.id, data, frame.fd if disturbance.fd is None else disturbance.fd)

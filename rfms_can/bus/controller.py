"""One node's CAN controller on the simulated bus: transmit queue and fault confinement."""

from collections.abc import Callable, Sequence
from typing import Final

from rfms_can.node.port_counts import PortCounts
from rfms_can.node.protocol import Node, hears_itself
from rfms_can.wire.frame import Frame

TX_CAPACITY: Final = 32
"""Transmit buffers of one controller: Bosch M_CAN in queue mode has this many, sent by ID."""

ERROR_PASSIVE: Final = 128
BUS_OFF: Final = 256

Handler = Callable[[Frame, int], Sequence[Frame]]
Route = tuple["Controller", int, Handler, Callable[[], int | None]]
"""A receiver: controller, index in the bus' deadlines, ``on_frame``, ``next_deadline_ns``."""


class Controller:
    """A node's port on the simulated bus, with the state of its controller; see ``attach``.

    Fault confinement follows ISO 11898-1: a failed transmission adds 8 to the transmit error
    counter (TEC), a sent one takes 1 off; a receiver counts 1 up or down (REC). From 128 on in
    either the controller is error-passive, from a TEC of 256 on it is bus-off: it neither sends nor
    receives, and there is no automatic recovery.

    Attributes:
        name: the node's name.
        node: the node.
        tx_capacity: frames the transmit queue holds.
        latency_ns: time from a call of the node to the hand-over of its frames.
        pending: frames in the queue, the one on the wire included.
        tx_overflow: frames refused because the queue was full or the controller bus-off
            (a driver's ENOBUFS).
        rx_lost: frames lost at the receiver by a disturbance.
        tec: transmit error counter.
        rec: receive error counter.
        bus_off: whether the controller has left the bus.
    """

    __slots__ = (
        "bus_off",
        "index",
        "latency_ns",
        "name",
        "node",
        "pending",
        "rec",
        "routes",
        "rx_lost",
        "suspended_until_ns",
        "tec",
        "tx_capacity",
        "tx_overflow",
    )

    def __init__(self, node: Node, index: int, tx_capacity: int, latency_ns: int) -> None:
        self.name = node.name
        self.node = node
        self.index = index
        self.tx_capacity = tx_capacity
        self.latency_ns = latency_ns
        self.pending = 0
        self.tx_overflow = 0
        self.rx_lost = 0
        self.tec = 0
        self.rec = 0
        self.bus_off = False
        self.suspended_until_ns = 0
        self.routes: dict[int, tuple[Route, ...]] = {}

    @property
    def error_passive(self) -> bool:
        """Whether the controller may only flag errors passively and waits before it sends."""
        return self.tec >= ERROR_PASSIVE or self.rec >= ERROR_PASSIVE

    def counts(self) -> PortCounts:
        """What this port has counted: bus-off lasts, and a receive queue never overflows."""
        return PortCounts(int(self.bus_off), self.tx_overflow)

    def route(self) -> Route:
        """This controller as a receiver."""
        return self, self.index, self.node.on_frame, self.node.next_deadline_ns

    def transmit_failed(self) -> None:
        """Count an error in a frame it sent; the 32nd in a row leads to bus-off."""
        self.tec += 8
        if self.tec >= BUS_OFF:
            self.bus_off = True

    def receive_failed(self) -> None:
        """Count an error in a received frame."""
        self.rec += 1

    def received(self) -> None:
        """Count a valid received frame."""
        if self.rec >= ERROR_PASSIVE:
            self.rec = ERROR_PASSIVE - 1
        elif self.rec:
            self.rec -= 1


def receivers(
    sender: Controller, identifier: int, controllers: Sequence[Controller]
) -> tuple[Route, ...]:
    """Receivers of a sender's frames with one identifier; cached in ``sender.routes``.

    A node that accepts an identifier it sends itself receives its own frame at the end of the
    transmission, like the transmit confirmation of a real controller, unless it has none
    (``hears_itself``).
    """
    echo = hears_itself(sender.node)
    sender.routes[identifier] = routes = tuple(
        controller.route()
        for controller in controllers
        if not controller.bus_off
        and identifier in controller.node.accepts
        and (echo or controller is not sender)
    )
    return routes

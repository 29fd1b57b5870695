"""What a node's port has counted, and the endpoint whose heartbeat tells it.

A node does no I/O and does not know its port: who attaches it gives it the counts.
"""

from collections.abc import Callable
from typing import Any, Final, NamedTuple

from rfms_can.node.endpoint import Endpoint
from rfms_can.node.protocol import Node
from rfms_can.wire.contract import Wire


class PortCounts(NamedTuple):
    """What a port has counted since it was opened.

    Attributes:
        bus_offs: how often its controller has gone bus-off.
        overflows: frames it has lost because a queue was full, on sending and on receiving.
    """

    bus_offs: int = 0
    overflows: int = 0


MOST: Final = PortCounts(bus_offs=0xF, overflows=0xFF)
"""The largest counts that HEARTBEAT carries."""
_MAX_U16: Final = 0xFFFF


def tell_port(node: Node, counts: Callable[[], PortCounts]) -> None:
    """Give a node its port's counts, if it tells them in its heartbeat (``port_counts``)."""
    telling: Any = node
    if hasattr(node, "port_counts"):
        telling.port_counts = counts


class PortTellingEndpoint(Endpoint):
    """An endpoint whose heartbeat tells what its port has counted.

    Attributes:
        port_counts: gives the counts; the driver sets it (``tell_port``).
    """

    def __init__(self, number: int, wire: Wire, boot_id: int) -> None:
        super().__init__(number, wire, boot_id)
        self.port_counts: Callable[[], PortCounts] = PortCounts

    def _beat(self, state: int, register: int = 0, config_hash: int = 0) -> None:
        """Send a heartbeat."""
        counted = self.port_counts()
        self._out.append(
            self._heartbeat.frame(
                state,
                min(counted.bus_offs, MOST.bus_offs),
                register,
                self.boot_id,
                self.wire.dbc_hash,
                config_hash,
                min(self.discarded, _MAX_U16),
                min(counted.overflows, MOST.overflows),
            )
        )

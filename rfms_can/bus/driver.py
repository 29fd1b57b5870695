"""Opens a process' port on the bus of a URL; python-can opens SocketCAN and other interfaces.

``url.py`` explains bus URLs; ``node_driver.py`` drives a node on its port.
"""

import logging
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any, Final, NamedTuple

import can

from rfms_can.bus.filters import cover
from rfms_can.bus.hub.port import HubPort
from rfms_can.bus.node_driver import NodeDriver, run_node
from rfms_can.bus.port import LONGEST_WAIT_S, OnForeign, Port
from rfms_can.bus.socketcan_port import SocketCanPort
from rfms_can.bus.url import HUB, OWN, SIM, SOCKETCAN, BusUrl, parse_bus_url
from rfms_can.errors import BusError, FrameError
from rfms_can.tables import complete
from rfms_can.wire.frame import Frame

# python-can logs the errors that it also raises: without a handler they would be printed twice
logging.getLogger("can").addHandler(logging.NullHandler())

_OPENING_FAILS: Final = (
    can.CanError,
    OSError,
    ValueError,
    TypeError,
    ImportError,
    AttributeError,
    NameError,
    NotImplementedError,
)
"""Errors raised by interfaces for a missing channel, option or driver."""

__all__ = ["NodeDriver", "PythonCanPort", "open_port", "run_node"]


def open_port(
    url: str,
    accepts: frozenset[int] | None,
    *,
    client: str = "",
    echo: bool = False,
    on_foreign: OnForeign | None = None,
) -> Port:
    """Open a port on the bus of a URL.

    Args:
        url: see ``url.py``; not ``sim``, which has no ports.
        accepts: identifiers to receive; None for all.
        client: name of this port in the statistics of a hub.
        echo: whether to receive own frames of these identifiers too, once they are sent.
        on_foreign: called for each frame other than a data frame with an 11-bit identifier.

    Raises:
        BusError: the URL is invalid, or the bus does not exist; the message says what to do.
    """
    bus = parse_bus_url(url)
    wanted = _Wanted(accepts, client, echo, on_foreign)
    return _OPEN.get(bus.interface, _open_python_can)(bus, wanted)


class _Wanted(NamedTuple):
    """What a port shall do; see ``open_port``."""

    accepts: frozenset[int] | None
    client: str
    echo: bool
    on_foreign: OnForeign | None


def _refuse_simulated(_bus: BusUrl, _wanted: _Wanted) -> Port:
    raise BusError(
        "bus 'sim' exists within one process: nodes of their own processes meet on a hub "
        "(rfms hub NAME, then hub:NAME) or on a CAN interface"
    )


def _open_hub(bus: BusUrl, wanted: _Wanted) -> HubPort:
    accepts, client, echo, on_foreign = wanted
    return HubPort(bus.channel, accepts, client=client, echo=echo, on_foreign=on_foreign)


def _open_socketcan(bus: BusUrl, wanted: _Wanted) -> SocketCanPort:
    # not can.Bus, which reads configuration files that may select another interface
    from can.interfaces.socketcan import SocketcanBus  # noqa: PLC0415 (Linux only)

    device = bus.channel
    accepts, _, echo, on_foreign = wanted
    filters: list[can.typechecking.CanFilter] | None = None
    if accepts is not None:
        filters = [
            {"can_id": identifier, "can_mask": mask, "extended": False}
            for identifier, mask in cover(accepts)
        ]
        if on_foreign is not None:  # extended frames are to be counted
            filters.append({"can_id": 0, "can_mask": 0, "extended": True})
    try:
        opened = SocketcanBus(device, receive_own_messages=echo, fd=True, can_filters=filters)
    except OSError as error:
        raise BusError(
            f"bus '{bus}' does not exist ({error.strerror}): make it with 'ip link add {device} "
            f"type vcan; ip link set {device} mtu 72 up', or use hub:NAME where the kernel has "
            f"no CAN"
        ) from error
    return SocketCanPort(opened.socket, device, on_foreign, opened.shutdown)


def _open_python_can(bus: BusUrl, wanted: _Wanted) -> "PythonCanPort":
    arguments: dict[str, Any] = {"fd": True, **bus.options}
    if wanted.echo:
        arguments["receive_own_messages"] = True
    try:
        opened = can.Bus(
            channel=bus.channel, interface=bus.interface, ignore_config=True, **arguments
        )
    except _OPENING_FAILS as error:
        known = ", ".join(sorted(can.VALID_INTERFACES))
        raise BusError(
            f"bus '{bus}' cannot be opened: {error}. Check the channel, the device and its "
            f"driver; python-can's interfaces are {known}"
        ) from error
    return PythonCanPort(opened, bus.text, wanted.accepts, wanted.on_foreign)


_OPEN: Final[dict[str, Callable[[BusUrl, _Wanted], Port]]] = complete(
    {SIM: _refuse_simulated, HUB: _open_hub, SOCKETCAN: _open_socketcan}, OWN
)
"""How a port on each of our own buses is opened."""


class PythonCanPort:
    """A ``Port`` on any interface of python-can, by its own ``send`` and ``recv``.

    Args:
        bus: the opened bus; the port closes it.
        url: for error messages.
        accepts: identifiers to receive, None for all. They are filtered here: with python-can's own
            filters a rejected frame would end a ``recv`` that does not wait.
        on_foreign: see ``open_port``.

    Attributes:
        statistics: counts, see ``Port``.
    """

    def __init__(
        self,
        bus: can.BusABC,
        url: str,
        accepts: frozenset[int] | None,
        on_foreign: OnForeign | None = None,
    ) -> None:
        self._bus = bus
        self._url = url
        self._accepts = accepts
        self._on_foreign = on_foreign
        self.statistics: Counter[str] = Counter()

    def send(self, frames: Sequence[Frame]) -> None:
        """Send frames; a frame refused by the interface is counted."""
        for frame in frames:
            message = can.Message(
                arbitration_id=frame.id,
                is_extended_id=False,
                data=frame.data,
                is_fd=frame.fd,
                bitrate_switch=frame.fd,
            )
            try:
                self._bus.send(message)
            except can.CanOperationError:
                self.statistics["tx_overflow"] += 1
            except (can.CanError, OSError) as error:
                raise self._gone(error) from error
            else:
                self.statistics["sent"] += 1

    def recv(self, timeout_s: float) -> Frame | None:
        """The next frame, None if none came in time; see ``Port``."""
        while True:
            try:
                message = self._bus.recv(min(timeout_s, LONGEST_WAIT_S))
            except (can.CanError, OSError) as error:
                raise self._gone(error) from error
            if message is None:
                return None
            timeout_s = 0.0
            frame = _as_frame(message)
            if frame is None:
                self._count_foreign("error" if message.is_error_frame else "not 11-bit data")
            elif self._accepts is None or frame.id in self._accepts:
                self.statistics["received"] += 1
                return frame

    def _count_foreign(self, kind: str) -> None:
        self.statistics["error_frames" if kind == "error" else "foreign"] += 1
        if self._on_foreign is not None:
            self._on_foreign(kind)

    def fileno(self) -> int:
        """The interface's descriptor; -1 if it has none."""
        return self._bus.fileno()

    def close(self) -> None:
        """Close the bus."""
        self._bus.shutdown()

    def _gone(self, error: Exception) -> BusError:
        return BusError(f"bus '{self._url}' has gone ({error}): check the device and start again")


def _as_frame(message: can.Message) -> Frame | None:
    """A python-can message as a frame; None unless a data frame with an 11-bit identifier."""
    if message.is_error_frame or message.is_extended_id or message.is_remote_frame:
        return None
    try:
        return Frame(message.arbitration_id, bytes(message.data), message.is_fd)
    except FrameError:
        return None

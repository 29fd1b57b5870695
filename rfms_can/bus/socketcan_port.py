"""A port on a raw SocketCAN socket that python-can has opened and configured.

python-can's ``send`` and ``recv`` add a ``select`` and a message object to every frame; on the
per-cycle path the socket is read and written directly: one system call a frame.
"""

import errno
import socket
import time
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Final

from rfms_can.bus.canfd_struct import (
    CANFD_BYTES,
    ERROR_FLAG,
    can_id_of,
    pack_socketcan,
    unpack_socketcan,
)
from rfms_can.bus.port import OnForeign, receive, set_time_limits
from rfms_can.errors import BusError
from rfms_can.wire.frame import Frame

TX_RETRIES: Final = 20
TX_RETRY_S: Final = 0.0005

# linux/can/error.h: classes in the identifier, controller problems in byte 1 of the payload
_ERROR_CONTROLLER: Final = 0x004
_ERROR_BUS_OFF: Final = 0x040
_CONTROLLER_RX_OVERFLOW: Final = 0x01
_PAYLOAD: Final = 8


class SocketCanPort:
    """A ``Port`` on a CAN_RAW socket, filters and FD set.

    Args:
        sock: the socket; its owner closes it.
        device: for error messages.
        on_foreign: called for each frame other than a data frame with an 11-bit identifier.
        on_close: called once by ``close``.

    Attributes:
        statistics: counts, see ``Port``.
    """

    def __init__(
        self,
        sock: socket.socket,
        device: str,
        on_foreign: OnForeign | None = None,
        on_close: Callable[[], None] | None = None,
    ) -> None:
        self._socket = sock
        self._device = device
        self._on_foreign = on_foreign
        self._on_close = on_close
        self.statistics: Counter[str] = Counter()
        set_time_limits(sock)

    def send(self, frames: Sequence[Frame]) -> None:
        """Send frames; a frame is dropped and counted if the device's queue stays full."""
        for frame in frames:
            self._send_one(pack_socketcan(frame))

    def _send_one(self, packet: bytes) -> None:
        for _ in range(TX_RETRIES):
            try:
                self._socket.send(packet)
            except BlockingIOError:
                break  # the socket's own buffer, and its time limit has passed
            except OSError as error:
                if error.errno != errno.ENOBUFS:
                    raise self._gone(error) from error
                time.sleep(TX_RETRY_S)  # the device's queue: nothing to poll for
            else:
                self.statistics["sent"] += 1
                return
        self.statistics["tx_overflow"] += 1

    def recv(self, timeout_s: float) -> Frame | None:
        """The next frame, None if none came in time; see ``Port``."""
        while True:
            try:
                packet = receive(self._socket, CANFD_BYTES, timeout_s)
            except OSError as error:
                raise self._gone(error) from error
            if packet is None:
                return None
            frame = unpack_socketcan(packet)
            if frame is not None:
                self.statistics["received"] += 1
                return frame
            self._count_foreign(packet)
            timeout_s = 0.0

    def _count_foreign(self, packet: bytes) -> None:
        can_id = can_id_of(packet)
        kind = "error" if can_id & ERROR_FLAG else "not 11-bit data"
        if can_id & ERROR_FLAG:
            self.statistics["error_frames"] += 1
            if can_id & _ERROR_BUS_OFF:
                self.statistics["bus_off"] += 1
            if can_id & _ERROR_CONTROLLER and packet[_PAYLOAD + 1] & _CONTROLLER_RX_OVERFLOW:
                self.statistics["rx_overflow"] += 1
        else:
            self.statistics["foreign"] += 1
        if self._on_foreign is not None:
            self._on_foreign(kind)

    def fileno(self) -> int:
        """The socket's descriptor."""
        return self._socket.fileno()

    def close(self) -> None:
        """Close the socket by its owner."""
        if self._on_close is not None:
            self._on_close()
            self._on_close = None

    def _gone(self, error: OSError) -> BusError:
        return BusError(
            f"socketcan:{self._device} has gone ({error.strerror}): "
            f"bring it up with 'ip link set {self._device} up', then start this node again"
        )

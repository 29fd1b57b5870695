"""A port on a hub, for nodes and the python-can plugin."""

import os
import socket
import sys
from collections import Counter, deque
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final

import msgspec

from rfms_can.bus.canfd_struct import CANFD_BYTES, pack_canfd, unpack_canfd
from rfms_can.bus.hub.address import SOCKET_FILE, hub_directory, live_hubs
from rfms_can.bus.hub.protocol import MAX_FRAMES_PER_PACKET, MAX_PACKET_BYTES, Hello, Welcome
from rfms_can.bus.port import OnForeign, receive, set_time_limits
from rfms_can.bus.timing import BusTiming
from rfms_can.errors import BusError
from rfms_can.wire.frame import Frame

WELCOME_WAIT_S: Final = 5.0


class HubPort:
    """One client of a hub; a ``Port``.

    Args:
        name: the hub's name.
        accepts: identifiers to receive; None for all.
        client: this port's name in the hub's statistics.
        echo: whether to receive own frames.
        batch: whether several frames may come in one packet; without, ``fileno`` is readable
            whenever ``recv`` has something.
        on_foreign: called for each frame other than a data frame with an 11-bit identifier.

    Attributes:
        statistics: counts, see ``Port``.
        timing: the hub's bit rates.

    Raises:
        BusError: no hub of that name is running, or it refuses this client.
    """

    def __init__(
        self,
        name: str,
        accepts: Iterable[int] | None = None,
        *,
        client: str = "",
        echo: bool = False,
        batch: bool = True,
        on_foreign: OnForeign | None = None,
    ) -> None:
        self._name = name
        self._on_foreign = on_foreign
        self._waiting: deque[Frame] = deque()
        self.statistics: Counter[str] = Counter()
        self._socket = _connect(name, hub_directory(name) / SOCKET_FILE)
        hello = Hello(
            client=client or f"{Path(sys.argv[0]).name} {os.getpid()}",
            ids=None if accepts is None else sorted(accepts),
            echo=echo,
            batch=batch,
        )
        try:
            self.timing = self._introduce(hello)
        except BaseException:
            self._socket.close()
            raise
        set_time_limits(self._socket)

    def _introduce(self, hello: Hello) -> BusTiming:
        self._socket.settimeout(WELCOME_WAIT_S)
        try:
            self._socket.send(msgspec.json.encode(hello))
            welcome = msgspec.json.decode(self._socket.recv(MAX_PACKET_BYTES), type=Welcome)
        except (OSError, msgspec.DecodeError) as error:
            raise BusError(f"hub {self._name!r} does not answer: {error}; restart it") from error
        if welcome.refused:
            raise BusError(f"hub {self._name!r} refuses {hello.client!r}: {welcome.refused}")
        return BusTiming(welcome.nominal_bit_rate, welcome.data_bit_rate)

    def send(self, frames: Sequence[Frame]) -> None:
        """Send frames in one packet, or in several if they do not fit."""
        if len(frames) > MAX_FRAMES_PER_PACKET:
            self.send(frames[:MAX_FRAMES_PER_PACKET])
            self.send(frames[MAX_FRAMES_PER_PACKET:])
            return
        try:
            self._socket.send(b"".join([pack_canfd(frame) for frame in frames]))
        except BlockingIOError:
            self.statistics["tx_overflow"] += len(frames)
        except OSError as error:
            raise self._gone(error.strerror) from error
        else:
            self.statistics["sent"] += len(frames)

    def recv(self, timeout_s: float) -> Frame | None:
        """The next frame, None if none came in time; see ``Port``."""
        waiting = self._waiting
        while not waiting:
            try:
                packet = receive(self._socket, MAX_PACKET_BYTES, timeout_s)
            except OSError as error:
                raise self._gone(error.strerror) from error
            if packet is None:
                return None
            if not packet:
                raise self._gone("it was stopped")
            self._take(packet)
            timeout_s = 0.0  # if all of it was foreign
        self.statistics["received"] += 1
        return waiting.popleft()

    def _take(self, packet: bytes) -> None:
        for offset in range(0, len(packet), CANFD_BYTES):
            frame = unpack_canfd(packet, offset)
            if frame is not None:
                self._waiting.append(frame)
                continue
            self.statistics["foreign"] += 1
            if self._on_foreign is not None:
                self._on_foreign("not 11-bit data")

    def fileno(self) -> int:
        """The socket's descriptor."""
        return self._socket.fileno()

    def close(self) -> None:
        """Leave the hub."""
        self._socket.close()

    def _gone(self, reason: str | None) -> BusError:
        return BusError(f"hub {self._name!r} has gone ({reason}): start it again, then this node")


def _connect(name: str, path: Path) -> socket.socket:
    sock = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    try:
        sock.connect(str(path))
    except OSError as error:
        sock.close()
        running = ", ".join(live_hubs()) or "none"
        raise BusError(
            f"no hub {name!r} is running (running: {running}): start it with 'rfms hub {name}'"
        ) from error
    return sock

"""A process that writes every frame of a bus to a candump log."""

import contextlib
import math
import mmap
import os
import socket
import sys
import time
from pathlib import Path
from typing import Final

from rfms_can.bus.driver import open_port
from rfms_can.bus.port import Port
from rfms_can.bus.url import parse_bus_url
from rfms_can.rig.candump import CandumpWriter
from rfms_can.rig.child import Child, Stop, describe
from rfms_can.rig.settings import RunSettings

LAST_FRAMES_S: Final = 1.0
"""How long a recorder that is to stop goes on reading a busy bus, s."""
ROOM_BYTES: Final = 1 << 24
"""Receive buffer of a recorder: some 20 000 frames."""
_TOLD_BYTES: Final = 256
"""Room for what a recorder tells its parent."""
_SO_RCVBUFFORCE: Final = 33  # asm-generic/socket.h


class Recorder(Child):
    """A process that writes every frame of the bus to a candump log.

    Args:
        path: file to write.
        settings: of the run.
    """

    def __init__(self, path: Path, settings: RunSettings) -> None:
        self._told = mmap.mmap(-1, _TOLD_BYTES)  # shared with the process
        channel = parse_bus_url(settings.bus).channel

        def body(stop: Stop) -> None:
            port = open_port(settings.bus, None, client="recorder")
            _make_room(port)
            writer = CandumpWriter(path, channel, time.time_ns() - time.monotonic_ns())
            try:
                _record(port, writer, stop)
            finally:
                writer.close()
                port.close()
                self._told.write(writer.cut.encode()[:_TOLD_BYTES])
                if writer.cut:
                    sys.stderr.write(f"recorder: {path} is cut: {writer.cut}\n")

        super().__init__("recorder", body)

    @property
    def cut(self) -> str:
        """Why the log is not whole, once the process has ended; empty if it is."""
        if self.exit_code:
            return describe(self)
        return self._told[:].rstrip(b"\0").decode(errors="replace")

    def close(self) -> None:
        """End it once it has read all there is."""
        self.signal()
        self.join()


def _record(port: Port, writer: CandumpWriter, stop: Stop) -> None:
    """Write what comes, until told to stop and nothing is left to read."""
    until = math.inf
    while time.monotonic() < until:
        frame = port.recv(1.0)
        if frame is not None:
            writer.write(time.monotonic_ns(), frame)
        elif stop():
            return
        if stop() and until == math.inf:
            until = time.monotonic() + LAST_FRAMES_S


def _make_room(port: Port) -> None:
    """Enlarge the kernel's receive buffer, so that a delayed reader loses no frame.

    Beyond the system's bound where that is allowed (root), else up to the bound.
    """
    with (
        contextlib.suppress(OSError),  # not every interface of python-can is a socket
        socket.socket(fileno=os.dup(port.fileno())) as sock,
    ):
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, ROOM_BYTES)
        sock.setsockopt(socket.SOL_SOCKET, _SO_RCVBUFFORCE, ROOM_BYTES)

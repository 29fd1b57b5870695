"""A process that writes every frame of a bus to a candump log."""

import contextlib
import math
import os
import socket
import time
from pathlib import Path
from typing import Final

from rfms_can.bus.driver import open_port
from rfms_can.bus.port import Port
from rfms_can.bus.url import parse_bus_url
from rfms_can.rig.candump import CandumpWriter
from rfms_can.rig.child import Child, Stop
from rfms_can.rig.settings import RunSettings

LAST_FRAMES_S: Final = 1.0
"""How long a recorder that is to stop goes on reading a busy bus, s."""
ROOM_BYTES: Final = 1 << 24
"""Receive buffer of a recorder: some 20 000 frames."""
_SO_RCVBUFFORCE: Final = 33  # asm-generic/socket.h


def start_recorder(path: Path, settings: RunSettings) -> Child:
    """A process that writes every frame of the bus to a candump log."""
    channel = parse_bus_url(settings.bus).channel

    def body(stop: Stop) -> None:
        port = open_port(settings.bus, None, client="recorder")
        _make_room(port)
        writer = CandumpWriter(path, channel, time.time_ns() - time.monotonic_ns())
        until = math.inf
        try:
            while time.monotonic() < until:
                frame = port.recv(1.0)
                if frame is not None:
                    writer.write(time.monotonic_ns(), frame)
                elif stop():
                    return  # told to stop, and nothing left to read
                if stop() and until == math.inf:
                    until = time.monotonic() + LAST_FRAMES_S
        finally:
            writer.close()
            port.close()

    return Child("recorder", body)


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
